#include "evaluation/failures/atlas_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "evaluation/methods/child_process.h"
#include "pipeline/burst/align.h"
#include "pipeline/burst/merge.h"
#include "scenes/textures/paint.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kTexels = 8.0 / 3;     // of a painted side, for a DP px
constexpr double kSeen = 1.5;           // side of whole_picture() over that of the picture
constexpr double kRepeats_dp_px = 256;  // of pink noise
constexpr double kGray = 0.18, kLongest_s = 1.0 / 15;
constexpr int kFrames = 3;
constexpr double kRenderNoise = 0.15;  // over the sensor's, in one frame

scenes::PinkNoise pink_noise(const AtlasScene& scene, unsigned layer) {
  constexpr int kLowest = 4, kHighest = 128;
  return {static_cast<std::uint32_t>(simulator::hash(scene.draw, layer)), kLowest, kHighest, 1};
}

double reflectance(double contrast, double n) { return kAtlasMean * (1 + contrast * n); }

}  // namespace

Paint pink_paint(const AtlasScene& scene, unsigned layer, double contrast) {
  return [=, noise = pink_noise(scene, layer)](double x, double y) {
    return reflectance(contrast, noise(static_cast<float>(x / kRepeats_dp_px), static_cast<float>(y / kRepeats_dp_px)));
  };
}

Paint striped_paint(const AtlasScene& scene, double angle_deg) {
  const double angle = angle_deg * std::numbers::pi / 180;
  return [=, noise = pink_noise(scene, 0)](double x, double y) {
    const double across = x * std::sin(angle) - y * std::cos(angle);
    return reflectance(kAtlasContrast, noise(static_cast<float>(across / kRepeats_dp_px), 0));
  };
}

Window whole_picture(const AtlasScene& scene) {
  const double half = 0.5 * kSeen * side_dp_px(scene.camera);
  return {-half, half, -half, half};
}

int add_paint(AtlasScene& scene, const Paint& paint, double factor) {
  const double side = kSeen * side_dp_px(scene.camera);
  const int texels = static_cast<int>(std::lround(kTexels * side));
  const int texture = scene.glb.add_texture(scenes::paint(texels, [&](float u, float v) {
    return glm::vec3(static_cast<float>(paint((u - 0.5) * side, (v - 0.5) * side)));
  }));
  return scene.glb.add_material(texture, glm::vec3(static_cast<float>(factor)), true);
}

Place at_blur(const AtlasScene& scene, double blur_dp_px) {
  return [camera = &scene.camera, depth_m = depth_of_blur(scene.camera, blur_dp_px)](double x, double y) {
    return point_seen_at(*camera, x, y, depth_m);
  };
}

void add_surface(AtlasScene& scene, int material, const Window& window, const Place& place) {
  constexpr double kCell_dp_px = 16;
  const double side = kSeen * side_dp_px(scene.camera);
  const double width = window.right - window.left, height = window.bottom - window.top;
  const int columns = static_cast<int>(std::ceil(width / kCell_dp_px));
  const int rows = static_cast<int>(std::ceil(height / kCell_dp_px));
  scenes::Mesh mesh;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double x = window.left + width * i / columns, y = window.top + height * j / rows;
      mesh.positions.push_back(place(x, y));
      mesh.uvs.emplace_back(x / side + 0.5, y / side + 0.5);
      if (i == 0 || j == 0) continue;
      const auto corner = static_cast<unsigned>(j * (columns + 1) + i), above = corner - columns - 1;
      mesh.triangles.emplace_back(above - 1, corner - 1, corner);
      mesh.triangles.emplace_back(above - 1, corner, above);
    }
  }
  scene.glb.add_node("surface", mesh, material);
}

void add_wall(AtlasScene& scene, int material, double blur_dp_px) {
  add_surface(scene, material, whole_picture(scene), at_blur(scene, blur_dp_px));
}

void add_strips(AtlasScene& scene, const Strips& strips, double strip_blur_dp_px, double wall_blur_dp_px) {
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), wall_blur_dp_px);
  const int material = add_paint(scene, pink_paint(scene, 1));
  const Window all = whole_picture(scene);
  for (double left = -strips.period * std::ceil(all.right / strips.period); left < all.right; left += strips.period) {
    add_surface(scene, material, {left, left + strips.width, all.top, all.bottom}, at_blur(scene, strip_blur_dp_px));
  }
}

void add_pane(AtlasScene& scene, double depth_m) {
  const int glass = scene.glb.add_material({.roughness = 0, .transmission = 1});
  add_surface(scene, glass, whole_picture(scene),
              [&](double x, double y) { return point_seen_at(scene.camera, x, y, depth_m); });
}

Place mirrored(Place place, double pane_depth_m) {
  return [place = std::move(place), pane_depth_m](double x, double y) {
    const glm::vec3 seen = place(x, y);
    return glm::vec3(seen.x, seen.y, -2 * static_cast<float>(pane_depth_m) - seen.z);
  };
}

double white_nits(const AtlasScene& scene) { return scene.illumination_lux / std::numbers::pi * kGray / scene.mean; }

simulator::ExposureOptions exposure_of(const AtlasScene& scene) {
  const simulator::SensorOptions& sensor = scene.camera.sensor;
  const double sensor_lux = scene.mean * white_nits(scene) * scene.camera.lens.thin.lux_per_nit();
  const double electrons_per_s = sensor_lux * sensor.electrons_per_lux_s[1];
  const double wanted = scene.level * sensor.full_well_e;
  const double time_s = std::min(kLongest_s, wanted / electrons_per_s);
  return {time_s, 100 * wanted / (electrons_per_s * time_s)};
}

double relative_noise(const AtlasScene& scene) {
  const Exposure exposure = simulator::describe_exposure(scene.camera.sensor, exposure_of(scene));
  const double mean_dn = 0.5 * scene.level * (exposure.white_level_dn - exposure.black_level_dn);
  return std::sqrt(exposure.dp_noise.shot_dn * mean_dn + exposure.dp_noise.read_dn2) / mean_dn;
}

Capture take_burst(const AtlasScene& scene) {
  const ScratchFolder folder;
  scene.glb.write(folder.path() + "/scene.glb");
  const simulator::ExposureOptions exposure = exposure_of(scene);
  nlohmann::json document = {{"version", 1}, {"gltf", "scene.glb"}};
  document["camera"] = {{"position_m", {0, 0, 0}}, {"look_at_m", {0, 0, -1}}};
  document["exposure"] = {{"time_s", exposure.time_s}, {"iso", exposure.iso}};
  document["burst"] = {{"frames", kFrames}};
  document["unlit_white_nits"] = white_nits(scene);
  document["render"] = {{"noise_fraction", kRenderNoise}, {"seed", scene.draw + 1}};
  document.merge_patch(scene.camera.document);
  document.merge_patch(scene.document);
  simulator::Simulation simulation = simulator::read_simulation(document, folder.path() + "/scene.json");
  simulation.with_all_in_focus = simulation.with_photograph = false;
  return simulator::simulate(simulation, simulator::load_scene(simulation));
}

ViewSample merged_views(const Capture& capture, pipeline::MergedBurst merged, int frames) {
  return view_sample(capture, std::move(merged.left), std::move(merged.right),
                     pipeline::view_sensor(capture.exposure, pipeline::merged_view_variance(frames)));
}

ViewSample take_views(const AtlasScene& scene) {
  const Capture capture = take_burst(scene);
  const std::vector<pipeline::MotionField> motions = pipeline::align_burst(capture.frames, 0, capture.exposure);
  return merged_views(capture, pipeline::merge_burst(capture.frames, 0, motions, capture.exposure),
                      static_cast<int>(capture.frames.size()));
}

}  // namespace dualpixel::evaluation
