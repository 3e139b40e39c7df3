#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "simulator/render/camera_view.h"
#include "simulator/render/ray_log.h"
#include "simulator/render/render_scene.h"

/// The light paths of one photosite: every camera sample crosses the pixel and the pupil at one point and is shared
/// between the left and the right view by the split pixel. Sixteen samples go together as one packet.
namespace dualpixel::simulator {

/// How samples are spread over pixel, pupil and lights. All but the last are there to be charted against it
/// (`dualpixel bench render`).
enum class Sampling {
  random,   ///< independent numbers
  padded,   ///< planar nets, one for the pixel, one for the pupil, paired at random
  joint,    ///< one net of four dimensions
  mirrored  ///< joint, in pairs that oppose each other in the pupil
};

struct PathOptions {
  int max_bounces = 0;  ///< 0: emitted and direct light; n: n further reflections
  /// Set: instead of the lens the ideal one with its chief rays is looked through, its pupil this much wider; 0 is a
  /// pinhole.
  std::optional<double> ideal_aperture_scale;
  Sampling sampling = Sampling::mirrored;
  RayLog* log = nullptr;  ///< set: gets every packet that is traced, too; one log serves one thread
};

/// Linear RGB in nits, as Views holds it.
struct HalfRadiance {
  glm::vec3 left{0}, right{0};
};

/// Mean over `samples` points, 1 .. 65536, of the net that `pixel_key` scrambles; powers of two sample best. The last
/// of an odd number lies in either half of the pupil, by the key.
HalfRadiance render_pixel(const RenderScene& world, const CameraView& camera, const PathOptions& options, int x, int y,
                          std::uint32_t samples, std::uint64_t pixel_key);

}  // namespace dualpixel::simulator
