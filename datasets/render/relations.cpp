#include "datasets/render/relations.h"

#include <algorithm>
#include <glm/glm.hpp>

#include "capture/error.h"
#include "scenes/framing/free_place.h"
#include "scenes/framing/light_meter.h"
#include "scenes/framing/scene_document.h"
#include "scenes/framing/seen_depth.h"
#include "simulator/simulate.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;

/// On the line's place of the shell, or else further around.
void place_on_shell(const json& shell, const simulator::ReadyScene& ready, const std::string& path, json& scene_file) {
  const auto bounds = ready.world.intersector.bounds();
  const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
  const double radius = 0.5 * glm::length(bounds.high - bounds.low);
  const auto position =
      scenes::free_place(ready, middle,
                         {radius * shell.at("distance").get<double>(), shell.at("elevation_deg").get<double>(),
                          shell.at("azimuth_deg").get<double>()});
  if (!position) throw InputError(printable(path) + ": camera_shell: no free place was found around the scene");
  scenes::set_pose(scene_file, {position->x, position->y, position->z}, {middle.x, middle.y, middle.z});
}

/// Whether the scene file's distance of focus is "auto".
bool focuses_itself(const json& scene_file) {
  const auto camera = scene_file.find("camera");
  return camera != scene_file.end() && camera->is_object() && camera->value("focus_distance_m", json()) == "auto";
}

/// By what the line sets of the exposure: the wells hold iso / 100 of white. Where nothing is set, the gain is that of
/// ISO 100 at least.
scenes::WhiteOfExposure white_of(const json& set, const simulator::ExposureOptions& exposure) {
  if (set.contains("exposure.iso")) return [exposure](double) { return std::min(1.0, exposure.iso / 100); };
  if (set.contains("exposure.time_s")) return [exposure](double s) { return std::min(1.0, s / exposure.time_s); };
  return [](double) { return 1; };
}

}  // namespace

std::optional<std::array<double, 2>> focus_place(const SampleLine& line, const json& scene_file) {
  if (line.relations.contains("focus_at")) return line.relations["focus_at"].get<std::array<double, 2>>();
  if (focuses_itself(scene_file)) return {{0.5, 0.5}};
  return {};
}

void stand_in_for_relations(const SampleLine& line, json& scene_file) {
  if (focuses_itself(scene_file)) scene_file["camera"].erase("focus_distance_m");
  if (line.relations.contains("camera_shell")) scenes::set_pose(scene_file, {0, 0, 1}, {0, 0, 0});
}

void resolve_geometry(const SampleLine& line, const std::optional<std::array<double, 2>>& focus,
                      const simulator::ReadyScene& ready, const std::string& path, json& scene_file) {
  const json& r = line.relations;
  if (r.contains("camera_shell")) place_on_shell(r.at("camera_shell"), ready, path, scene_file);
  if (!focus) return;
  constexpr double kNearest_m = 0.08, kFarthest_m = 1000;
  const char* field = r.contains("focus_at") ? "focus_at" : "/camera/focus_distance_m: auto";
  const double depth =
      scenes::seen_depth(simulator::read_simulation(scene_file, path), ready, (*focus)[0], (*focus)[1], path, field);
  scene_file["camera"]["focus_distance_m"] = scenes::short_number(std::clamp(depth, kNearest_m, kFarthest_m));
}

std::optional<scenes::MissedExposure> resolve_exposure(double mean, const json& set, const simulator::Simulation& s,
                                                       simulator::ReadyScene& ready,
                                                       const simulator::CameraView& camera, json& scene_file) {
  const scenes::MeteredExposure metered =
      scenes::meter_for_mean(mean, s, ready, camera, "exposure_mean", white_of(set, s.exposure));
  json& exposure = scene_file["exposure"];
  if (set.contains("exposure.iso")) {
    exposure["time_s"] = scenes::short_number(metered.seconds * 100 / s.exposure.iso);
  } else if (set.contains("exposure.time_s")) {
    exposure["iso"] = scenes::short_number(metered.seconds * 100 / s.exposure.time_s);
  } else {
    constexpr int kDigits = 4;
    return metered.missed(scenes::set_exposure(scene_file, metered.seconds, kDigits));
  }
  return metered.missed();
}

}  // namespace dualpixel::datasets
