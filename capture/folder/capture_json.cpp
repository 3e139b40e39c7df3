#include "capture/folder/capture_json.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/color_filter_array.h"
#include "capture/folder/camera_json.h"
#include "capture/split_kinds.h"

namespace dualpixel {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kFocusAtInfinity_m = std::numeric_limits<double>::infinity();

/// JSON has no infinity.
Json number_or_inf(double value) { return std::isinf(value) ? Json("inf") : Json(value); }

Json to_json(const NoiseProfile& noise) { return {{"shot_dn", noise.shot_dn}, {"read_dn2", noise.read_dn2}}; }

NoiseProfile read_noise(Fields fields) {
  NoiseProfile noise;
  fields.number("shot_dn", noise.shot_dn, 0, 1e9);
  fields.number("read_dn2", noise.read_dn2, 0, 1e15);
  fields.done();
  return noise;
}

/// The texts among a capture's provenance, by their names in capture.json.
struct ProvenanceText {
  const char* name;
  std::string Provenance::*text;
};
constexpr ProvenanceText kStrings[] = {{"program", &Provenance::program},
                                       {"scene_file", &Provenance::scene_file},
                                       {"gltf_xxh64", &Provenance::gltf_xxh64}};
constexpr ProvenanceText kJsonTexts[] = {{"scene", &Provenance::scene}, {"plan", &Provenance::plan}};
constexpr const char* kNoiseFraction = "noise_fraction_reached";

/// Stores the value in the field of that name and returns true, where there is such a field and the value fits it.
bool read_known(const std::string& name, const nlohmann::json& value, Provenance& provenance) {
  if (name == kNoiseFraction && value.is_number_float()) {
    provenance.noise_fraction_reached = value.get<double>();
    return true;
  }
  for (const ProvenanceText& field : kStrings) {
    if (name != field.name || !value.is_string()) continue;
    provenance.*field.text = value.get<std::string>();
    return !(provenance.*field.text).empty();
  }
  for (const ProvenanceText& field : kJsonTexts) {
    if (name != field.name) continue;
    provenance.*field.text = value.dump();
    return true;
  }
  return false;
}

}  // namespace

Json conventions() {
  return {{"axes", "opencv"},
          {"pixel_center", 0.5},
          {"depth", "planar z from the entrance pupil, metres"},
          {"disparity", "right(x + d) = left(x), DP pixels; negative in front of the focus plane"},
          {"left_view", "light that crossed the pupil at x < 0"},
          {"camera_from_world", "row-major 4x4, points are columns, metres"}};
}

Json to_json(const Camera& camera) {
  Json json = {{"name", camera.name},
               {"width_px", camera.width_px},
               {"height_px", camera.height_px},
               {"pixel_pitch_um", camera.pixel_pitch_um},
               {"cfa", camera.cfa},
               {"dp_downsample_x", camera.dp_downsample_x},
               {"dp_downsample_y", camera.dp_downsample_y},
               {"focal_length_mm", camera.focal_length_mm},
               {"f_number", camera.f_number},
               {"focus_distance_m", number_or_inf(camera.focus_distance_m)},
               {"principal_point_px", camera.principal_point_px},
               {"split", camera.split},
               {"alpha", camera.alpha}};
  if (const Image& light = camera.relative_light; !light.empty()) {
    json["lens_shading"] = {{"columns", light.width}, {"rows", light.height}, {"relative_light", light.data}};
  }
  return json;
}

Json to_json(const Exposure& exposure) {
  Json json = {{"time_s", exposure.time_s},
               {"iso", exposure.iso},
               {"bits", exposure.bits},
               {"black_level_dn", exposure.black_level_dn},
               {"white_level_dn", exposure.white_level_dn}};
  if (exposure.mosaic_white_level_dn) json["mosaic_white_level_dn"] = *exposure.mosaic_white_level_dn;
  if (exposure.dp_white_level_dn) json["dp_white_level_dn"] = *exposure.dp_white_level_dn;
  json["mosaic_noise"] = to_json(exposure.mosaic_noise);
  json["dp_noise"] = to_json(exposure.dp_noise);
  json["white_balance"] = exposure.white_balance;
  if (exposure.color_matrix) json["color_matrix"] = *exposure.color_matrix;
  json["lux_s_per_unit"] = exposure.lux_s_per_unit;
  return json;
}

Image read_lens_shading(Fields fields) {
  constexpr int kMostNodes = 1024;  // along each side
  constexpr double kMostLight = 10;
  int columns = 0, rows = 0;
  fields.required("columns").integer("columns", columns, 2, kMostNodes);
  fields.required("rows").integer("rows", rows, 2, kMostNodes);
  const std::size_t nodes = static_cast<std::size_t>(columns) * rows;
  std::vector<double> values;
  fields.required("relative_light").list("relative_light", values, 0, kMostLight, nodes);
  if (values.size() != nodes) {
    fields.fail("relative_light", fmt::format("{} numbers: must be columns times rows, {}", values.size(), nodes));
  }
  Image light(columns, rows);
  light.data.assign(values.begin(), values.end());
  fields.done();
  return light;
}

Camera read_camera(Fields fields) {
  Camera camera;
  camera.focus_distance_m = 0;
  read_intrinsics(fields, camera);
  fields.choice("cfa", camera.cfa, names_of(kColorFilterArrays));
  fields.required("focus_distance_m").number("focus_distance_m", camera.focus_distance_m, 1e-4, kFocusAtInfinity_m);
  std::vector<std::string> splits = names_of(kSplitKinds);
  splits.push_back(camera.split);  // "unknown"
  fields.choice("split", camera.split, splits);
  fields.number("alpha", camera.alpha, 0, 10);
  if (fields.has("lens_shading")) camera.relative_light = read_lens_shading(fields.object("lens_shading"));
  fields.done();
  return camera;
}

Exposure read_exposure(Fields fields) {
  Exposure exposure;
  fields.number("time_s", exposure.time_s, 0, 1e6);
  fields.number("iso", exposure.iso, 0, 1e8);
  fields.required("bits").integer("bits", exposure.bits, 8, 16);
  fields.required("black_level_dn").number("black_level_dn", exposure.black_level_dn, 0, 65535);
  fields.required("white_level_dn").number("white_level_dn", exposure.white_level_dn, 0, 65535);
  const auto level = [&](const char* name, std::optional<double>& dn) {
    if (fields.has(name)) fields.number(name, dn.emplace(), 0, 65535);
  };
  level("mosaic_white_level_dn", exposure.mosaic_white_level_dn);
  level("dp_white_level_dn", exposure.dp_white_level_dn);
  exposure.mosaic_noise = read_noise(fields.object("mosaic_noise"));
  exposure.dp_noise = read_noise(fields.object("dp_noise"));
  fields.numbers("white_balance", exposure.white_balance.data(), 3);
  if (fields.has("color_matrix")) fields.numbers("color_matrix", exposure.color_matrix.emplace().data(), 9);
  fields.number("lux_s_per_unit", exposure.lux_s_per_unit, 0, 1e12);
  fields.done();
  return exposure;
}

void require_readable(const Camera& camera, const Exposure& exposure, const std::string& where) {
  const nlohmann::json camera_to_read = to_json(camera), exposure_to_read = to_json(exposure);
  read_camera(Fields(camera_to_read, where, "/camera"));
  read_exposure(Fields(exposure_to_read, where, "/exposure"));
}

Provenance read_provenance(const nlohmann::json& object) {
  Provenance provenance;
  for (const auto& [name, value] : object.items()) {
    if (!read_known(name, value, provenance)) provenance.other[name] = value.dump();
  }
  return provenance;
}

nlohmann::json to_json(const Provenance& provenance, const std::string& where) {
  const auto parsed = [&where](const std::string& name, const std::string& text) {
    return parse_json(text, where + ": /provenance/" + name);
  };
  nlohmann::json object = nlohmann::json::object();
  for (const auto& [name, text] : provenance.other) object[name] = parsed(name, text);
  for (const ProvenanceText& field : kStrings) {
    if (const std::string& text = provenance.*field.text; !text.empty()) object[field.name] = text;
  }
  for (const ProvenanceText& field : kJsonTexts) {
    if (const std::string& text = provenance.*field.text; !text.empty()) object[field.name] = parsed(field.name, text);
  }
  if (provenance.noise_fraction_reached) object[kNoiseFraction] = *provenance.noise_fraction_reached;
  return object;
}

void check_conventions(Fields fields) {
  const Json expected = conventions();
  for (const auto& [key, value] : expected.items()) {
    if (fields.required(key).raw(key) != nlohmann::json(value)) fields.fail(key, "must be " + value.dump());
  }
  fields.done();
}

}  // namespace dualpixel
