#include "evaluation/failures/atlas_camera.h"

#include <filesystem>
#include <utility>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "scenes/drawn/phone_lenses.h"
#include "simulator/scene_file.h"

namespace dualpixel::evaluation {
namespace {

using nlohmann::json;

/// A lens that the program holds, with the default sensor.
AtlasCamera held_lens(const std::string& name, const std::string& lens) {
  const json document = scenes::phone_lens(lens);
  return {name, {{"lens", document}}, simulator::read_lens_of(document, lens, 1.0).lens, {}};
}

AtlasCamera camera_of_file(const std::string& path) {
  if (!std::filesystem::exists(path)) {
    throw InputError("--camera: " + printable(path) +
                     ": must be thin, prescription, ideal, or a camera or lens file that exists");
  }
  const json file = read_json_file(path);
  if (file.is_object() && file.contains("gltf")) {
    throw InputError("--camera: " + printable(path) + ": is a scene file: must be a camera file or a lens file");
  }
  const simulator::LensOfFile found = simulator::read_lens_of(file, path, {});
  const std::string absolute = std::filesystem::absolute(path).string();
  AtlasCamera camera{path, json::object(), found.lens, found.sensor.value_or(simulator::SensorOptions{})};
  const bool is_lens = found.pointer.empty();
  camera.document[is_lens ? "lens" : "camera"] = {{"file", absolute}};
  return camera;
}

}  // namespace

AtlasCamera atlas_camera(const std::string& name) {
  AtlasCamera camera = name == "thin"           ? held_lens(name, "phone_thin")
                       : name == "prescription" ? held_lens(name, "phone_6p")
                                                : camera_of_file(name);
  return with_side(std::move(camera), kAtlasSide_px);
}

AtlasCamera with_side(AtlasCamera camera, int side_px) {
  for (const char* side : {"width_px", "height_px"}) camera.document["sensor"][side] = side_px;
  camera.sensor.width_px = camera.sensor.height_px = side_px;
  return camera;
}

AtlasCamera with_plain_lens(AtlasCamera camera, const json& fields) {
  json lens = {{"model", "aberrated"},
               {"focal_length_mm", 1e3 * camera.lens.thin.focal_length_m},
               {"f_number", camera.lens.thin.f_number}};
  lens.update(fields);
  camera.document["lens"] = lens;
  camera.lens = simulator::read_lens_of(lens, camera.name, camera.lens.thin.focus_distance_m).lens;
  return camera;
}

AtlasCamera focused_for(AtlasCamera camera, double blur_dp_px) {
  // b = L f / (z - f) of a point at infinity
  const simulator::ThinLens& thin = camera.lens.thin;
  const double f = thin.focal_length_m;
  const double focus_m = f + f * thin.pupil_diameter_m() / (blur_dp_px * dp_pitch_m(camera));
  camera.lens = simulator::refocused(camera.lens, focus_m);
  camera.document["camera"]["focus_distance_m"] = focus_m;
  return camera;
}

double dp_pitch_m(const AtlasCamera& camera) {
  const simulator::SensorOptions& sensor = camera.sensor;
  const bool dense = sensor.dp_downsample_x * sensor.dp_downsample_y == 1;
  return 1e-6 * sensor.pixel_pitch_um * (dense ? 2 : sensor.dp_downsample_x);
}

double side_dp_px(const AtlasCamera& camera) {
  return 1e-6 * camera.sensor.pixel_pitch_um * camera.sensor.width_px / dp_pitch_m(camera);
}

double depth_of_blur(const AtlasCamera& camera, double blur_dp_px) {
  const simulator::ThinLens& thin = camera.lens.thin;
  const double per_diopter_m = thin.pupil_diameter_m() * thin.image_distance_m();
  return 1 / (1 / thin.focus_distance_m - blur_dp_px * dp_pitch_m(camera) / per_diopter_m);
}

glm::vec3 point_seen_at(const AtlasCamera& camera, double x_dp_px, double y_dp_px, double depth_m) {
  const double m_per_px = dp_pitch_m(camera) * depth_m / camera.lens.thin.image_distance_m();
  return {x_dp_px * m_per_px, -y_dp_px * m_per_px, -depth_m};
}

}  // namespace dualpixel::evaluation
