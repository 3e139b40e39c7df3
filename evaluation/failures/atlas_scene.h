#pragma once
#include <functional>
#include <nlohmann/json.hpp>

#include "evaluation/failures/atlas_camera.h"
#include "evaluation/methods/set_samples.h"
#include "pipeline/burst/merge.h"
#include "scenes/gltf/glb.h"

/// A scene of the failure atlas under construction, and the views that its camera takes of it. x and y: DP px from the
/// picture's middle, y down; surfaces are placed by where they are seen and by their blur diameter b, DP px.
namespace dualpixel::evaluation {

inline constexpr double kAtlasContrast = 0.2;  ///< of textures: root mean square over mean
inline constexpr double kAtlasMean = 0.5;      ///< of textures, as linear reflectance
inline constexpr double kAtlasLevel = 0.25;    ///< mean signal over white

struct AtlasScene {
  AtlasCamera camera;  ///< focused
  unsigned draw;       ///< which textures and which noise
  scenes::Glb glb;
  nlohmann::json document = nlohmann::json::object();  ///< further fields of the scene file
  double illumination_lux = 100;  ///< a gray card's 18 % have the brightness of the mean of the picture
  double level = kAtlasLevel;     ///< mean of the exposed picture
  double mean = kAtlasMean;       ///< of the picture over the white of what glows
};

/// A picture of reflectance: 1 is white, over (x, y).
using Paint = std::function<double(double x, double y)>;
/// Noise with as much contrast in every octave, from 2 to 64 px; each `layer` of a scene has its own.
Paint pink_paint(const AtlasScene& scene, unsigned layer, double contrast = kAtlasContrast);
/// The same along one direction alone, `angle_deg` from the lines to the baseline.
Paint striped_paint(const AtlasScene& scene, double angle_deg);

struct Window {
  double left, right;  ///< edges, DP px from the middle
  double top, bottom;
};
/// Everything that is seen, and half as much again, since blur brings it in.
Window whole_picture(const AtlasScene& scene);

/// A painted material that glows by itself, so that its light is exact; times `factor`.
int add_paint(AtlasScene& scene, const Paint& paint, double factor = 1);
/// Where what is seen at (x, y) lies, m.
using Place = std::function<glm::vec3(double x, double y)>;
Place at_blur(const AtlasScene& scene, double blur_dp_px);
/// A surface in that window of the picture, which shows its paint there.
void add_surface(AtlasScene& scene, int material, const Window& window, const Place& place);
void add_wall(AtlasScene& scene, int material, double blur_dp_px);
/// Upright strips of `width` in front of a wall, their left edges `period` apart; both painted.
struct Strips {
  double width, period;
};
void add_strips(AtlasScene& scene, const Strips& strips, double strip_blur_dp_px, double wall_blur_dp_px);
/// A thin pane of glass across the view.
void add_pane(AtlasScene& scene, double depth_m);
inline constexpr double kPaneReflects = 0.04;  ///< head-on: glTF's thin pane has one surface, of ior 1.5
/// What is placed behind the camera so that the pane at that depth shows it at `place`.
Place mirrored(Place place, double pane_depth_m);

/// Nits of white, which `illumination_lux` and `mean` stand for.
double white_nits(const AtlasScene& scene);
/// As automatic exposure would have it, no longer than 1/15 s.
simulator::ExposureOptions exposure_of(const AtlasScene& scene);
/// Noise of a pixel of one frame's views over the mean of the picture.
double relative_noise(const AtlasScene& scene);

/// Rendered, and exposed as a burst of three where the scene does not say otherwise. Throws InputError.
Capture take_burst(const AtlasScene& scene);
/// The merged views of `frames` frames with the truth of the first one, which they show.
ViewSample merged_views(const Capture& capture, pipeline::MergedBurst merged, int frames);
/// All frames of a burst, aligned to the first one and merged.
ViewSample take_views(const AtlasScene& scene);

}  // namespace dualpixel::evaluation
