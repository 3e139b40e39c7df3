#include "datasets/render/render.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "capture/error.h"
#include "datasets/plan/plan.h"
#include "datasets/render/sample_folder.h"
#include "datasets/state/state.h"
#include "tests/datasets/small_recipe.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;
using testing::bytes_under;
using testing::small_recipe;

void plan_into(const std::string& folder, const json& recipe) {
  const Recipe read = read_recipe(recipe, "r.json");
  write_plan(make_plan(read), read, folder);
}

Capture capture_of(const SampleLine& line) {
  static std::unique_ptr<simulator::ReadyScene> ready;
  return render_line(line, "", ready).capture;
}

SampleLine first_line(const json& recipe) { return make_plan(read_recipe(recipe, "r.json")).lines.front(); }

TEST(SlowRender, ShardsGiveTheBytesOfTheWhole) {
  const TemporaryFolder folder;
  json recipe = small_recipe(7);  // of three scenes, one of them drawn
  recipe["scenes"].push_back({{"kind", "chart"}, {"seeds", {1, 1}}, {"set", {{"width_px", 128}}}});
  for (const char* set : {"whole", "four", "nine"}) plan_into(folder / set, recipe);
  const RenderCounts counts = render_shard({.dataset = folder / "whole"});
  EXPECT_EQ(counts.rendered, 7);
  EXPECT_EQ(counts.left(), 0);
  int rendered = 0;
  for (int i : {2, 0, 3, 1}) {  // which do not divide seven
    rendered += render_shard({.dataset = folder / "four", .shard = {i, 4}, .jobs = 1 + i % 2}).rendered;
  }
  for (int i = 8; i >= 0; --i) rendered += render_shard({.dataset = folder / "nine", .shard = {i, 9}}).rendered;
  EXPECT_EQ(rendered, 2 * 7);
  const auto whole = bytes_under(folder / "whole");
  EXPECT_EQ(whole.size(), 2U + 2 + 7 * 6);  // and those of the drawn scene
  EXPECT_TRUE(whole == bytes_under(folder / "four"));
  EXPECT_TRUE(whole == bytes_under(folder / "nine"));
}

// Samples of one scene go on with the light that those before them found, each with a goal of its own.
TEST(SlowRender, LightThatOtherSamplesFoundChangesNoByte) {
  const TemporaryFolder folder;
  json recipe = small_recipe(3);
  recipe["scenes"].erase(1);
  recipe["set"]["sensor.width_px"] = 32, recipe["set"]["sensor.height_px"] = 24;
  recipe["set"].erase("render.light_spacing_px");
  recipe["set"]["render.noise_fraction"] = {{"grid", {0.5, 4, 1}}};
  for (const char* set : {"run", "apart"}) plan_into(folder / set, recipe);
  EXPECT_EQ(render_shard({.dataset = folder / "run"}).rendered, 3);
  for (int i : {1, 2, 0}) EXPECT_EQ(render_shard({.dataset = folder / "apart", .shard = {i, 3}}).rendered, 1);
  EXPECT_TRUE(bytes_under(folder / "run") == bytes_under(folder / "apart"));
}

TEST(SlowRender, RendersOnlyWhatIsMissing) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  plan_into(set, small_recipe(4));
  render_shard({.dataset = set});
  const auto before = bytes_under(set);
  std::filesystem::remove_all(set + "/samples/000002");
  // as a killed program leaves it
  std::filesystem::create_directories(set + "/samples/.dualpixel-1-0.tmp");
  const RenderCounts counts = render_shard({.dataset = set});
  EXPECT_EQ(counts.there, 3);
  EXPECT_EQ(counts.rendered, 1);
  EXPECT_EQ(clear(set).leftovers, 1);
  EXPECT_TRUE(before == bytes_under(set));
}

TEST(SlowRender, GoesOnWhereASampleCannotBeRendered) {
  const TemporaryFolder folder;
  const std::string set = folder / "set", glb = read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb");
  json recipe = small_recipe(4);
  folder.write("mine.glb", glb);
  folder.write("mine.json",
               R"({"version": 1, "gltf": "mine.glb", "environment": {"model": "constant", "nits": [9, 9, 9]}})");
  recipe["scenes"][0]["file"] = folder / "mine.json";
  plan_into(set, recipe);
  folder.write("mine.glb", glb + "x");  // no valid file any more
  RenderCounts counts = render_shard({.dataset = set});
  EXPECT_GT(counts.failed, 0);
  EXPECT_EQ(counts.failed + counts.rendered, 4);
  const DatasetState state = state_of(set);
  EXPECT_EQ(state.total().failed, counts.failed);
  EXPECT_EQ(state.total().there, counts.rendered);
  for (const auto& [name, reason] : state.reasons) EXPECT_NE(reason.find("mine"), std::string::npos) << reason;
  folder.write("mine.glb", glb);
  counts = render_shard({.dataset = set});
  EXPECT_EQ(counts.failed, 0);
  EXPECT_EQ(state_of(set).total().there, 4);
  EXPECT_TRUE(state_of(set).reasons.empty());
}

TEST(SlowRender, EndsAfterTheSampleInWhichItIsStopped) {
  const TemporaryFolder folder;
  plan_into(folder / "set", small_recipe(3));
  std::atomic<int> stopped = 0;
  const RenderCounts counts = render_shard(
      {.dataset = folder / "set", .stopped = &stopped, .progress = [&](const RenderCounts&) { stopped = 15; }});
  EXPECT_EQ(counts.rendered, 1);
  EXPECT_EQ(counts.left(), 2);
  EXPECT_EQ(state_of(folder / "set").total().there, 1);
}

TEST(Render, WritesNoSampleWhoseLightIsNotFinite) {
  const TemporaryFolder folder;
  const SampleLine line = first_line(small_recipe(1));
  RenderedSample sample{capture_of(line), {}};
  Truth& truth = *sample.capture.truth;
  const auto refuses = [&] {
    return message_of<InputError>([&] { write_sample(line, sample, folder / "set"); }).find("not finite") !=
           std::string::npos;
  };
  float& value = truth.right.data.back();
  for (const float bad : {NAN, INFINITY}) {
    const float good = std::exchange(value, bad);
    EXPECT_TRUE(refuses()) << bad;
    value = good;
  }
  const double noise = std::exchange(truth.noise->views, INFINITY);
  EXPECT_TRUE(refuses());
  EXPECT_FALSE(is_there(folder / "set", line));
  truth.noise->views = noise;
  write_sample(line, sample, folder / "set");
  EXPECT_TRUE(is_there(folder / "set", line));
}

TEST(Render, WritesNoPictureWithAValueThatIsNotFinite) {
  const TemporaryFolder folder;
  json recipe = small_recipe(1);
  recipe["keep"] = {"left", "normal", "view_disparity_dp_px", "view_depth_m", "depth_m", "all_in_focus"};
  const SampleLine line = first_line(recipe);
  RenderedSample sample{capture_of(line), {}};
  Truth& truth = *sample.capture.truth;
  const auto refusal = [&](float& value, float bad) {
    const float good = std::exchange(value, bad);
    std::string message = message_of<InputError>([&] { write_sample(line, sample, folder / "set"); });
    value = good;
    return message;
  };
  EXPECT_EQ(refusal(truth.normal.data[5], NAN), "normal: a value is not finite");
  EXPECT_EQ(refusal(truth.all_in_focus.data[5], INFINITY), "all_in_focus: a value is not finite");
  EXPECT_EQ(refusal(truth.depth_m.data[0], -INFINITY), "depth_m: a value is not finite");
  EXPECT_EQ(refusal(truth.depth_m.data[0], NAN), "depth_m: a value is not finite");
  EXPECT_NE(refusal(truth.disparity_dp_px.data[0], NAN), "");
  EXPECT_EQ(refusal(truth.depth_m.data[0], INFINITY), "");  // as of the sky
  EXPECT_TRUE(is_there(folder / "set", line));
  SampleLine dpdd = line;
  dpdd.layout = Layout::dpdd;
  dpdd.keep = {};
  truth.all_in_focus.data[4] = NAN;  // green
  EXPECT_EQ(message_of<InputError>([&] { write_sample(dpdd, sample, folder / "dpdd"); }),
            "target.png: a value is not finite");
  EXPECT_FALSE(is_there(folder / "dpdd", dpdd));
}

// A chart of so little contrast is drawn with a warning, which both of its samples repeat.
TEST(SlowRender, SamplesSayWhatIsWrongWithTheirDrawnScene) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  json recipe = small_recipe(2);
  recipe["scenes"] = {{{"kind", "chart"}, {"seeds", {1, 1}}}};
  recipe["scenes"][0]["set"] = {{"pattern", "siemens_star"}, {"contrast", 0.05}, {"width_px", 128}};
  recipe["set"].erase("exposure.iso");
  plan_into(set, recipe);
  EXPECT_EQ(render_shard({.dataset = set}).rendered, 2);
  const std::string even = "the picture shows an even surface and nothing else";
  for (const char* name : {"000000", "000001"}) {
    const json sample = json::parse(read_bytes(set + "/samples/" + name + "/sample.json"));
    EXPECT_EQ(sample["scene_warnings"], json::array({even}));
  }
  const std::string file = std::filesystem::directory_iterator(set + "/scenes")->path() / "warnings.json";
  const std::string limit = "exposure: 99 s at ISO 100 are asked for";
  write_bytes(file, json::array({even, limit}).dump());
  const auto warnings = [&](const json& fields) {
    SampleLine line = read_plan(set).front();
    line.set.update(fields);
    std::unique_ptr<simulator::ReadyScene> ready;
    return render_line(line, set, ready).scene_warnings;
  };
  EXPECT_EQ(warnings(json::object()), (std::vector<std::string>{even, limit}));
  EXPECT_EQ(warnings({{"exposure.iso", 200}}), std::vector<std::string>{even});  // has an exposure of its own
}

// The box of a drawn scene is that of its own lens and sensor.
TEST(SlowRender, TheFaceOfADrawnSceneIsTheSamples) {
  const TemporaryFolder folder;
  json recipe = small_recipe(1);
  recipe["scenes"] = {{{"kind", "chart"}, {"seeds", {1, 1}}, {"set", {{"pattern", "planes"}, {"width_px", 128}}}}};
  for (const char* field : {"width_px", "height_px", "pixel_pitch_um"}) {
    recipe["set"].erase(std::string("sensor.") + field);
  }
  const auto render = [&] {
    std::unique_ptr<simulator::ReadyScene> ready;
    return render_line(first_line(recipe), folder.path.string(), ready).capture;
  };
  EXPECT_FALSE(render().face_px);
  // as of a portrait, in the scene that was drawn
  const std::string file = std::filesystem::directory_iterator(folder / "scenes")->path() / "scene.json";
  json scene = json::parse(read_bytes(file));
  const std::array<double, 4> face = {48, 24, 32, 40};
  scene["face_px"] = face;
  write_bytes(file, scene.dump());
  recipe["relations"] = json::object();
  EXPECT_EQ(render().face_px, face);
  recipe["set"]["sensor.pixel_pitch_um"] = 0.5 * scene["sensor"]["pixel_pitch_um"].get<double>();
  recipe["set"]["sensor.width_px"] = 256, recipe["set"]["sensor.height_px"] = 192;
  const auto close_up = render().face_px;
  ASSERT_TRUE(close_up);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR((*close_up)[i], 2 * face[i], 1) << i;  // rounded outwards
  recipe["relations"] = {{"camera_shell", {{"distance", 2}, {"elevation_deg", 10}}}};
  EXPECT_FALSE(render().face_px);
}

TEST(SlowRender, VerifyFindsWhatIsKeptAndNotThere) {
  const TemporaryFolder folder;
  const std::string set = folder / "set", file = set + "/samples/000001/sample.json";
  plan_into(set, small_recipe(3));
  render_shard({.dataset = set});
  const std::string written = read_bytes(file);
  json document = json::parse(written);
  document["files"] = json::array();
  write_bytes(file, document.dump());
  const std::string names =
      ": /files: must name left.npy, right.npy, view_disparity_dp_px.npy, depth_m.npy, "
      "preview.png, as the plan has it";
  EXPECT_EQ(faults_of(set), std::vector<std::string>{file + names});
  document = json::parse(written);
  document["files"][0]["path"] = "../../../../secret";
  write_bytes(file, document.dump());
  EXPECT_EQ(faults_of(set), std::vector<std::string>{file + names});
  write_bytes(file, written);
  const std::string picture = set + "/samples/000001/left.npy", elsewhere = folder / "elsewhere.npy";
  std::filesystem::rename(picture, elsewhere);
  EXPECT_EQ(faults_of(set), std::vector<std::string>{picture + ": no such file"});
  std::filesystem::create_symlink(elsewhere, picture);
  EXPECT_EQ(faults_of(set), std::vector<std::string>{picture + ": is not a regular file"});
  EXPECT_EQ(clear(set).damaged, 1);
  EXPECT_EQ(render_shard({.dataset = set}).rendered, 1);
  EXPECT_EQ(read_bytes(file), written);
}

// A linked folder of samples may be another data set's, whose samples are not this plan's.
TEST(SlowRender, WritesAndClearsNothingBehindALinkedFolder) {
  const TemporaryFolder folder;
  const std::string set = folder / "set", other = folder / "other";
  plan_into(set, small_recipe(1));
  json recipe = small_recipe(1);
  recipe["seed"] = 6;
  plan_into(other, recipe);
  render_shard({.dataset = other});
  for (const char* part : {"samples", "scenes"}) {
    std::filesystem::create_directories(other + "/" + part);
    std::filesystem::create_directory_symlink("../other/" + std::string(part), set + "/" + part);
    const auto before = bytes_under(folder.path);
    const std::string refusal = set + "/" + part + ": is a link: must be a folder";
    EXPECT_EQ(message_of<InputError>([&] { clear(set); }), refusal);
    EXPECT_EQ(message_of<InputError>([&] { render_shard({.dataset = set}); }), refusal);
    EXPECT_TRUE(bytes_under(folder.path) == before);
    std::filesystem::remove(set + "/" + part);
  }
}

TEST(SlowRender, VerifyFindsWhatWasChanged) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  plan_into(set, small_recipe(3));
  render_shard({.dataset = set});
  EXPECT_TRUE(faults_of(set).empty());
  const std::string file = set + "/samples/000001/depth_m.npy";
  std::string bytes = read_bytes(file);
  bytes.back() = static_cast<char>(bytes.back() ^ 1);
  write_bytes(file, bytes);
  EXPECT_EQ(faults_of(set), std::vector<std::string>{file + ": the file was changed"});
  EXPECT_EQ(clear(set).damaged, 1);
  EXPECT_EQ(render_shard({.dataset = set}).rendered, 1);
  EXPECT_TRUE(faults_of(set).empty());
}

TEST(Render, WhatIsKeptChangesNoOtherPicture) {
  json recipe = small_recipe(1);
  const Capture few = capture_of(first_line(recipe));
  recipe["keep"] = {"all_in_focus", "photograph"};
  const Capture all = capture_of(first_line(recipe));
  EXPECT_TRUE(few.truth->photograph.empty() && few.truth->all_in_focus.empty());
  EXPECT_EQ(all.truth->photograph.width, 64);
  EXPECT_EQ(few.frames[0].left.data, all.frames[0].left.data);
  EXPECT_EQ(few.truth->left.data, all.truth->left.data);
}

TEST(SlowRelations, FocusLiesOnWhatTheCameraSeesThere) {
  for (const SampleLine& line : make_plan(read_recipe(small_recipe(6), "r.json")).lines) {
    const Capture capture = capture_of(line);
    const Image& depth = capture.truth->depth_m;
    const int x = static_cast<int>(line.relations["focus_at"][0].get<double>() * depth.width);
    const int y = static_cast<int>(line.relations["focus_at"][1].get<double>() * depth.height);
    // the relation looks through a pinhole at 64 pixels a row: within one of them, and rounded to four digits
    float low = 1e9f, high = 0;
    for (int py = std::max(y - 1, 0); py <= std::min(y + 1, depth.height - 1); ++py) {
      for (int px = std::max(x - 1, 0); px <= std::min(x + 1, depth.width - 1); ++px) {
        low = std::min(low, depth.at(px, py));
        high = std::max(high, depth.at(px, py));
      }
    }
    EXPECT_GE(capture.camera.focus_distance_m, low * (1 - 1e-3)) << line.name;
    EXPECT_LE(capture.camera.focus_distance_m, high * (1 + 1e-3)) << line.name;
  }
}

// "auto" is the surface in the middle of the picture: the same number as focus there.
TEST(SlowRelations, FocusIsAutomaticWhereTheSceneFileSaysSo) {
  json recipe = small_recipe(1);
  SampleLine middle = first_line(recipe);
  middle.relations["focus_at"] = {0.5, 0.5};
  const double expected_m = capture_of(middle).camera.focus_distance_m;
  recipe.erase("relations");
  const double file_m = capture_of(first_line(recipe)).camera.focus_distance_m;
  EXPECT_NE(expected_m, file_m);
  recipe["set"]["camera.focus_distance_m"] = "auto";
  EXPECT_EQ(capture_of(first_line(recipe)).camera.focus_distance_m, expected_m);
  recipe["set"]["camera.focus_distance_m"] = {{"choice", {"auto", 2.5}}};
  recipe["count"] = 32;
  std::set<double> distances_m;
  for (const SampleLine& line : make_plan(read_recipe(recipe, "r.json")).lines) {
    if (line.scene == middle.scene) distances_m.insert(capture_of(line).camera.focus_distance_m);
  }
  EXPECT_EQ(distances_m, (std::set<double>{expected_m, 2.5}));
}

TEST(SlowRelations, ExposureGivesTheMean) {
  json recipe = small_recipe(6);
  recipe["relations"]["exposure_mean"] = {{"grid", {0.05, 0.18, 0.85}}};
  recipe["set"]["exposure.iso"] = 200;
  for (const SampleLine& line : make_plan(read_recipe(recipe, "r.json")).lines) {
    const Capture capture = capture_of(line);
    EXPECT_EQ(capture.exposure.iso, 200);
    const Truth& truth = *capture.truth;
    double sum = 0, square = 0;
    const auto n = static_cast<double>(truth.left.pixel_count());
    for (std::size_t i = 0; i < truth.left.pixel_count(); ++i) {
      const double signal = std::min(1.0f, truth.left.data[3 * i + 1] + truth.right.data[3 * i + 1]);
      sum += signal / n;
      square += signal * signal / n;
    }
    // the meter reads 48 x 36 of the photosites: five standard errors of their mean
    const double error = 5 * std::sqrt((square - sum * sum) / (48 * 36));
    EXPECT_NEAR(sum, line.relations["exposure_mean"].get<double>(), error) << line.name;
    EXPECT_LT(error, 0.1);
  }
}

}  // namespace
}  // namespace dualpixel::datasets
