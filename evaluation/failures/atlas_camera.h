#pragma once
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "simulator/lens/lens.h"
#include "simulator/sensor/sensor.h"

/// The camera that looks at the scenes of the failure atlas. Its sensor is cut down to kAtlasSide_px photosites a side
/// around the axis, where a row does not say otherwise. Lengths in the picture are in DP px along x, in both
/// directions.
namespace dualpixel::evaluation {

inline constexpr int kAtlasSide_px = 448;

struct AtlasCamera {
  std::string name;         ///< as it was asked for
  nlohmann::json document;  ///< what its scene files say: `camera`, `lens`, `sensor`; paths are absolute
  simulator::Lens lens;
  simulator::SensorOptions sensor;
};

/// "thin": the paper's phone as a thin lens; "prescription": the six-element phone lens of lens_models; else a camera
/// file (docs/fit_camera.md) or a lens file. Throws InputError.
AtlasCamera atlas_camera(const std::string& name);

/// With so many photosites a side around the axis.
AtlasCamera with_side(AtlasCamera camera, int side_px);

/// An ideal lens of the camera's focal length and f-number before a phone's soft split, and what `fields` say of its
/// aberrations, in place of the camera's own lens.
AtlasCamera with_plain_lens(AtlasCamera camera, const nlohmann::json& fields);

/// Focused so near that a point at infinity is `blur_dp_px` wide.
AtlasCamera focused_for(AtlasCamera camera, double blur_dp_px);

/// Of the pixels that are matched: of dense views, two photosites.
double dp_pitch_m(const AtlasCamera& camera);
/// Side of the picture, DP px.
double side_dp_px(const AtlasCamera& camera);
/// Depth at which a point is `blur_dp_px` wide (negative: in front of the focus), m.
double depth_of_blur(const AtlasCamera& camera, double blur_dp_px);
/// Where a point at (x, y) DP px from the picture's middle, y down, and at `depth_m` lies: glTF's axes, camera in the
/// origin, looking along -z.
glm::vec3 point_seen_at(const AtlasCamera& camera, double x_dp_px, double y_dp_px, double depth_m);

}  // namespace dualpixel::evaluation
