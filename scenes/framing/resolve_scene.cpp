#include "scenes/framing/resolve_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "scenes/drawn/meter.h"
#include "scenes/framing/free_place.h"
#include "scenes/framing/light_meter.h"
#include "scenes/framing/scene_document.h"
#include "scenes/framing/seen_depth.h"
#include "simulator/scene/scale.h"
#include "simulator/simulate.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;
using Ready = std::unique_ptr<simulator::ReadyScene>;

constexpr double kMeanSignal = 0.18;

/// What to focus on; at most one of these.
struct FocusRequest {
  bool automatic = false;
  std::optional<std::array<double, 2>> at_px;
  std::optional<std::string> node;

  bool any() const { return automatic || at_px || node; }
};

/// Takes what is no distance out of the document's camera.
FocusRequest take_focus_request(json& document, const std::string& path) {
  FocusRequest request;
  const auto found = document.find("camera");
  if (found == document.end() || !found->is_object()) return request;
  json& camera = *found;
  Fields fields(camera, path, "/camera");
  const json distance = fields.raw("focus_distance_m");
  request.automatic = distance == "auto";
  if (fields.has("focus_at_px")) fields.numbers("focus_at_px", request.at_px.emplace().data(), 2);
  if (fields.has("focus_node")) fields.text("focus_node", request.node.emplace());
  if (!request.any()) return request;
  if (!distance.is_null() + request.at_px.has_value() + request.node.has_value() > 1) {
    fields.fail(request.node ? "focus_node" : "focus_at_px",
                "give one of focus_distance_m, focus_at_px and focus_node; null takes a field away");
  }
  for (const char* field : {"focus_distance_m", "focus_at_px", "focus_node"}) camera.erase(field);
  return request;
}

/// Takes model_scale out of the document: 1 where it is absent.
double take_model_scale(json& document, const std::string& path) {
  constexpr double kSmallest = 1e-6, kLargest = 1e6;
  Fields fields(document, path);
  double scale = 1;
  if (!fields.has("model_scale")) return scale;
  fields.number("model_scale", scale, kSmallest, kLargest);
  if (fields.has("model_size_m")) fields.fail("model_scale", "give either model_scale or model_size_m");
  document.erase("model_scale");
  return scale;
}

void scale_model(double scale, json& document, const std::string& path, Ready& ready) {
  make_ready(simulator::read_simulation(document, path), ready);
  document["model_size_m"] = std::stod(fmt::format("{:.9g}", scale * simulator::longest_side(ready->scene)));
}

/// From where the whole of the scene's ball is in the picture, a little from above and aside.
void place_camera_around(json& document, const simulator::Simulation& s, const simulator::ReadyScene& ready) {
  constexpr double kMargin = 1.05, kElevation_deg = 15, kAzimuth_deg = 30;
  const auto bounds = ready.world.intersector.bounds();
  const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
  const double radius = 0.5 * glm::length(bounds.high - bounds.low);
  const double half_side_m = 0.5e-6 * s.sensor.pixel_pitch_um * std::min(s.sensor.width_px, s.sensor.height_px);
  const double distance = kMargin * radius / std::sin(std::atan(half_side_m / s.lens.thin.focal_length_m));
  const auto position = free_place(ready, middle, {distance, kElevation_deg, kAzimuth_deg});
  if (!position) {
    throw InputError(printable(s.path) +
                     ": no place was found from which a camera sees the scene; give one by "
                     "camera.position_m and camera.look_at_m");
  }
  const auto short_point = [](glm::vec3 p) {
    return std::array<double, 3>{short_number(p.x), short_number(p.y), short_number(p.z)};
  };
  set_pose(document, short_point(*position), short_point(middle));
}

void focus(const FocusRequest& request, json& document, const std::string& path, const simulator::ReadyScene& ready) {
  const simulator::Simulation s = simulator::read_simulation(document, path);
  double depth = 0;
  if (request.node) {
    depth = seen_depth_of_node(s, ready, *request.node, path, "/camera/focus_node");
  } else if (request.at_px) {
    const auto [x, y] = *request.at_px;
    if (!(x >= 0 && x <= s.sensor.width_px && y >= 0 && y <= s.sensor.height_px)) {
      Fields(document["camera"], path, "/camera")
          .fail("focus_at_px", fmt::format("[{:g}, {:g}]: must lie in the picture of {} x {} photosites", x, y,
                                           s.sensor.width_px, s.sensor.height_px));
    }
    depth = seen_depth(s, ready, x / s.sensor.width_px, y / s.sensor.height_px, path, "/camera/focus_at_px");
  } else {
    depth = seen_depth(s, ready, 0.5, 0.5, path, "/camera/focus_distance_m: auto");
  }
  document["camera"]["focus_distance_m"] = short_number(depth);
}

void expose(json& document, const std::string& path, simulator::ReadyScene& ready, std::vector<std::string>& warnings) {
  constexpr int kDigits = 2;
  const simulator::Simulation s = simulator::read_simulation(document, path);
  const simulator::CameraView camera = simulator::place_camera(s, ready.scene);
  const MeteredExposure metered = meter_for_mean(kMeanSignal, s, ready, camera, "/exposure", [](double) { return 1; });
  const auto missed = metered.missed(set_exposure(document, metered.seconds, kDigits));
  if (missed) warnings.push_back(printable(path) + ": " + to_text(*missed));
}

}  // namespace

json resolve_scene(json document, const std::string& path, Ready& ready, std::vector<std::string>& warnings) {
  const bool bare = is_gltf(path) && document.is_object();
  if (!document.is_object()) return document;  // read_simulation says what is wrong with it
  FocusRequest request = take_focus_request(document, path);
  const double scale = take_model_scale(document, path);
  if (bare && !document.contains("environment")) document["environment"] = {{"model", "sky"}};
  if (!bare && !request.any() && scale == 1) return document;

  if (scale != 1) scale_model(scale, document, path, ready);
  const simulator::Simulation s = simulator::read_simulation(document, path);
  make_ready(s, ready);
  const bool has_camera = s.pose || !s.camera_node.empty() || !ready->scene.cameras.empty();
  if (bare && !has_camera) place_camera_around(document, s, *ready);
  const bool focused = document.contains("camera") && document["camera"].contains("focus_distance_m");
  if (bare && !focused && !request.any()) request.automatic = true;
  if (request.any()) focus(request, document, path, *ready);
  if (bare && !document.contains("exposure")) expose(document, path, *ready, warnings);
  return document;
}

}  // namespace dualpixel::scenes
