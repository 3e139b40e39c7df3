// The JSON Schemas in docs/schemas accept and refuse the documents that the readers accept and refuse.
// GCC 12 misjudges std::string and std::regex in valijson (bugs 105651, 105562).
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wrestrict"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>
#include <vector>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "datasets/recipe/recipe.h"
#include "evaluation/camera_fit/measurements.h"
#include "simulator/scene_file.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

using nlohmann::json;

class Schema {
 public:
  explicit Schema(const std::string& name) {
    json document = read_json_file(DUALPIXEL_SOURCE_DIR "/docs/schemas/" + name + ".schema.json");
    json& fields = document["properties"];
    if (fields.contains("lens")) {
      const std::string lens = fields["lens"]["$ref"];
      fields["lens"] = read_json_file(DUALPIXEL_SOURCE_DIR "/docs/schemas/" + lens);
    }
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(valijson::adapters::NlohmannJsonAdapter(document), schema_);
  }

  bool accepts(const json& document) const {
    valijson::Validator validator;
    const valijson::adapters::NlohmannJsonAdapter target(document);
    return validator.validate(schema_, target, nullptr);
  }

 private:
  valijson::Schema schema_;
};

/// The document with each value replaced by values of other types and sizes, each field removed, and a field added to
/// each object. Of arrays the first element only; nothing below a pointer that `skipped` names.
std::vector<json> mutations(const json& document, const std::vector<std::string>& skipped) {
  const std::vector<json> values = {nullptr, true, -1, 0, 3, 1.5, 1e300, "x", "inf", json::array(), json::object()};
  std::vector<json> all;
  const std::function<void(const std::string&)> visit = [&](const std::string& pointer) {
    if (std::find(skipped.begin(), skipped.end(), pointer) != skipped.end()) return;
    const json& at = document.at(json::json_pointer(pointer));
    const auto add = [&](const std::function<void(json&)>& change) {
      change((all.emplace_back(document))[json::json_pointer(pointer)]);
    };
    if (!pointer.empty()) {
      for (const json& value : values) add([&](json& target) { target = value; });
    }
    if (at.is_object()) {
      add([](json& target) { target["unheard_of"] = 1; });
      for (const auto& [name, value] : at.items()) {
        add([&name = name](json& target) { target.erase(name); });
        visit(pointer + "/" + name);
      }
    } else if (at.is_array() && !at.empty()) {
      add([](json& target) { target.erase(0); });
      add([](json& target) { target.push_back(target[0]); });
      visit(pointer + "/0");
    }
  };
  visit("");
  return all;
}

/// Where schema and reader disagree the reader must be the stricter, for one of the `reasons` that no schema can state.
void expect_agreement(const std::string& name, const json& good, const std::vector<std::string>& skipped,
                      const std::function<void(const json&)>& read, const std::vector<std::string>& reasons) {
  const Schema schema(name);
  EXPECT_TRUE(schema.accepts(good));
  int accepted = 0, refused = 0;
  for (const json& document : mutations(good, skipped)) {
    std::string refusal;
    try {
      read(document);
    } catch (const InputError& error) {
      refusal = error.what();
    }
    (refusal.empty() ? accepted : refused)++;
    const bool beyond_schema = std::any_of(reasons.begin(), reasons.end(), [&](const std::string& reason) {
      return refusal.find(reason) != std::string::npos;
    });
    if (beyond_schema) continue;
    EXPECT_EQ(schema.accepts(document), refusal.empty()) << refusal << '\n' << json::diff(good, document);
  }
  EXPECT_GT(accepted, 30);
  EXPECT_GT(refused, 80);
}

json scene() {
  const json sensor = {{"width_px", 64},
                       {"height_px", 48},
                       {"pixel_pitch_um", 1.4},
                       {"electrons_per_lux_s", {1000, 2000, 1500}},
                       {"full_well_e", 5000},
                       {"well_spill", 0.5},
                       {"readout", "sum_and_left"},
                       {"row_noise_dn", 0.5},
                       {"row_time_us", 10},
                       {"dark_current_e_per_s", 5},
                       {"hot_pixel_share", 0.001},
                       {"hot_pixel_e_per_s", 500},
                       {"temperature_c", 30},
                       {"dark_current_doubling_c", 8},
                       {"color_matrix", {0.7, 0.2, 0.1, 0.2, 0.7, 0.1, 0.1, 0.2, 0.7}},
                       {"illuminant", {1.2, 1, 0.8}},
                       {"read_noise_e", 2},
                       {"read_noise_after_gain_dn", 0.5},
                       {"prnu", 0.01},
                       {"dark_offset_dn", 1},
                       {"fixed_pattern_seed", 4},
                       {"dp_downsample_x", 2},
                       {"dp_downsample_y", 4},
                       {"bits", 10},
                       {"black_level_dn", 64}};
  const json render = {{"samples_per_pixel", 4},
                       {"photograph_samples_per_pixel", 4},
                       {"max_bounces", 1},
                       {"light_spacing_px", 4.5},
                       {"light_samples", 32},
                       {"light_memory_mb", 100},
                       {"seed", 5},
                       {"all_in_focus_samples_per_pixel", 4},
                       {"error", 0.01}};
  return {{"version", 1},
          {"gltf", "portrait.glb"},
          {"camera", {{"file", "cameras/phone_2019.json"}, {"node", "camera"}, {"focus_distance_m", 0.79}}},
          {"lens", {{"file", "../lens_models/phone_thin_4.4mm_f1.8.json"}}},
          {"sensor", sensor},
          {"exposure", {{"time_s", 0.01}, {"iso", 100}}},
          {"burst",
           {{"frames", 2},
            {"hand_shake", 1},
            {"hand_shake_seed", 3},
            {"interval_s", 0.1},
            {"exposure_poses", 2},
            {"animation", false}}},
          {"environment", {{"model", "none"}}},
          {"unlit_white_nits", 100},
          {"model_size_m", 2},
          {"face_px", {10, 10, 5, 5}},
          {"truth", {{"photograph_aperture_scale", 5}, {"photograph_lens", "ideal"}}},
          {"render", render}};
}

void read_scene(const json& document) { simulator::read_simulation(document, DUALPIXEL_SCENES_DIR "/scene.json"); }

TEST(Schema, SaysOfScenesWhatTheReaderSays) {
  const std::vector<std::string> skipped = {"/lens", "/camera/file"};
  const std::vector<std::string> reasons = {"/sensor/black_level_dn: ",
                                            "/burst/interval_s: ",
                                            "/camera/look_at_m: ",
                                            "of the illuminant under one filter: each row",
                                            "where the illuminant is white: must have an inverse",
                                            "/truth/photograph_lens: ",
                                            "/truth/photograph_aperture_scale: is that of",
                                            "/lens/focal_length_mm: ",
                                            "/model_size_m: cannot be given",
                                            "this machine has"};
  expect_agreement("scene", scene(), skipped, read_scene, reasons);
  for (const json& environment : {json{{"model", "constant"}, {"nits", {1, 2, 3}}},
                                  json{{"model", "sky"},
                                       {"sun_elevation_deg", 40},
                                       {"sun_azimuth_deg", 140},
                                       {"zenith_nits", 4000},
                                       {"horizon_nits", 7500},
                                       {"ground_nits", 2200},
                                       {"sun_glow_nits", 12000},
                                       {"sun_glow_width_deg", 20}},
                                  json{{"model", "file"}, {"path", "sky.exr"}, {"nits_per_unit", 10}}}) {
    json document = scene();
    document["environment"] = environment;
    document["camera"] = {{"position_m", {0, 0, 0}}, {"look_at_m", {0, 0, -1}}, {"up", {0, 1, 0}}};
    document["render"].erase("error");
    document["render"]["noise_fraction"] = 0.5;
    document["sensor"]["dp_downsample_x"] = document["sensor"]["dp_downsample_y"] = 1;
    expect_agreement("scene", document, skipped, read_scene, reasons);
  }
}

TEST(Schema, SaysOfMeasurementsWhatTheReaderSays) {
  const json document = read_json_file(DUALPIXEL_SOURCE_DIR "/tests/data/camera_fit/full_frame_measurements.json");
  const auto read = [](const json& j) {
    evaluation::read_camera_measurements(j, DUALPIXEL_SOURCE_DIR "/tests/data/camera_fit/m.json");
  };
  expect_agreement("measurements", document, {"/lens", "/sensor"}, read,
                   {"one for each number of", "must be above low", "must be the JSON pointer", "starts at",
                    "the lens cannot focus", "/lens", "is named before", "no figure at a place that is fitted"});
}

TEST(Schema, AcceptsTheShippedScenes) {
  const Schema schema("scene");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(DUALPIXEL_SCENES_DIR)) {
    if (entry.path().extension() != ".json") continue;
    EXPECT_TRUE(schema.accepts(read_json_file(entry.path()))) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4);
}

json recipe() {
  return {{"version", 1},
          {"title", "t"},
          {"count", 10},
          {"seed", 2},
          {"scenes", {{{"kind", "chart"}, {"seeds", {1, 2}}, {"set", {{"width_px", 128}}}, {"weight", 2}}}},
          {"set",
           {{"exposure.iso", {{"choice", {1, 2}}, {"weights", {1, 2}}}},
            {"lens.f_number", {{"log_uniform", {1, 2}}}},
            {"sensor.prnu", {{"normal", {0.01, 0.001}}, {"bounds", {0.005, 0.02}}}},
            {"sensor.bits", {{"integer", {10, 12}}}},
            {"sensor.read_noise_e", {{"uniform", {1, 2}}}},
            {"truth.photograph_aperture_scale", {{"grid", {3, 5}}}},
            {"burst.frames", 1},
            {"lens.split", {{"constant", {{"model", "hard"}}}}}}},
          {"relations",
           {{"focus", "surface"},
            {"exposure_mean", {{"uniform", {0.1, 0.2}}}},
            {"camera_shell", {{"distance", 2}, {"elevation_deg", 10}, {"azimuth_deg", 5}}},
            {"model_size_m", 2},
            {"environments", "skies"}}},
          {"split", {{"train", 0.8}, {"validation", 0.1}, {"test", 0.1}}},
          {"layout", "exr"},
          {"keep", {"left", "right"}}};
}

TEST(Schema, SaysOfRecipesWhatTheReaderSays) {
  const std::vector<std::string> reasons = {"must be [low, high]", "must be numbers in", "must be [first, last]",
                                            "one for each value",  "must reach within",  "deviation above 0",
                                            "add up to",           "follows from",       "is there twice"};
  const auto read = [](const json& document) { datasets::read_recipe(document, "recipe.json"); };
  expect_agreement("recipe", recipe(), {"/set/burst.frames"}, read, reasons);
  json dpdd = recipe();
  dpdd["layout"] = "dpdd";
  EXPECT_FALSE(Schema("recipe").accepts(dpdd));
  dpdd.erase("keep");
  EXPECT_TRUE(Schema("recipe").accepts(dpdd));
}

TEST(Schema, AcceptsTheShippedRecipes) {
  const Schema schema("recipe");
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(DUALPIXEL_SOURCE_DIR "/datasets/recipes")) {
    EXPECT_TRUE(schema.accepts(read_json_file(entry.path()))) << entry.path();
    ++count;
  }
  EXPECT_EQ(count, 4);
}

TEST(SlowSchema, SaysOfCapturesWhatTheReaderSays) {
  const TemporaryFolder folder;
  const std::string path = folder / "capture";
  Capture capture = pipeline::synthetic_capture(16, 8);
  capture.face_px = {{1, 2, 3, 4}};
  capture.frames.push_back(capture.frames.front());
  capture.truth->motion = {Image(16, 8, 2)};
  capture.truth->samples = capture.truth->render_sigma = Image(16, 8, 1, 1);
  capture.truth->left = capture.truth->right = Image(16, 8, 3, 1);
  capture.truth->noise = {.views = 0.1, .all_in_focus = 0.2, .photograph = 0.3};
  capture.truth->photograph_lens = "ideal";
  capture.exposure.dp_white_level_dn = 500;
  capture.exposure.mosaic_white_level_dn = 900;
  capture.exposure.color_matrix = Matrix3{1.5, -0.3, -0.2, -0.3, 1.5, -0.2, -0.1, -0.3, 1.4};
  write_capture(capture, path);
  const auto read = [&](const json& document) {
    write_bytes(path + "/capture.json", document.dump());
    read_capture(path, true);
  };
  // Values that only the images or another field contradict.
  const std::vector<std::string> reasons = {"the camera calls for",
                                            "inside the focal length",
                                            "must divide",
                                            "is beyond",
                                            ", beyond ",
                                            "must be below the white level",
                                            "must lie above the black level",
                                            "must have an inverse",
                                            "either every frame",
                                            "one for each frame but the first, or none",
                                            "not listed under /files",
                                            "listed twice",
                                            "bytes; capture.json says",
                                            "cannot be read",
                                            "the file was changed",
                                            "must be a path inside",
                                            "no such file",
                                            "must be a regular file"};
  expect_agreement("capture", read_json_file(path + "/capture.json"), {}, read, reasons);
}

TEST(SlowSchema, SaysOfResultsWhatTheReaderSays) {
  const TemporaryFolder folder;
  const std::string path = folder / "result";
  pipeline::write_result(pipeline::synthetic_result(pipeline::synthetic_capture()),
                         {{"mode", "dp"}, {"capture", "somewhere"}}, path);
  const auto read = [&](const json& document) {
    write_bytes(path + "/result.json", document.dump());
    pipeline::read_result(path);
  };
  expect_agreement("result", read_json_file(path + "/result.json"), {}, read, {});
}

}  // namespace
}  // namespace dualpixel
