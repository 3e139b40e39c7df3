#include "datasets/plan/plan.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <map>
#include <set>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "scenes/kinds/kinds.h"
#include "simulator/lens/lens_file.h"
#include "simulator/scene/gltf/gltf.h"
#include "tests/datasets/small_recipe.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;
using testing::small_recipe;

std::vector<std::string> texts(const Plan& plan) {
  std::vector<std::string> all;
  for (const SampleLine& line : plan.lines) all.push_back(to_text(line));
  return all;
}

Plan plan_of(const json& recipe) { return make_plan(read_recipe(recipe, "r.json")); }

json of_charts(int count, int seeds) {
  json recipe = small_recipe(count);
  recipe["scenes"] = {
      {{"kind", "chart"}, {"seeds", {1, seeds}}, {"set", {{"pattern", "focus_ladder"}, {"width_px", 128}}}}};
  recipe["set"] = json::object();
  recipe["split"] = {{"train", 0.6}, {"validation", 0.1}, {"test", 0.3}};
  return recipe;
}

TEST(Plan, LinesHangOnTheirIndexAlone) {
  const std::vector<std::string> few = texts(plan_of(small_recipe(7))), many = texts(plan_of(small_recipe(40)));
  ASSERT_EQ(many.size(), 40U);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
  EXPECT_EQ(std::set<std::string>(many.begin(), many.end()).size(), 40U);
  json other = small_recipe(7);
  other["seed"] = 6;
  EXPECT_NE(texts(plan_of(other)), few);
}

TEST(Plan, LinesAreReadAsTheyWereWritten) {
  for (const std::string& text : texts(plan_of(small_recipe()))) {
    EXPECT_EQ(to_text(read_sample_line(text, "line")), text);
  }
}

// A drawn scene's file holds its whole lens, whose fields would hide the named file's.
TEST(Plan, ALensFileTakesThePlaceOfTheScenesLens) {
  const std::string lenses = DUALPIXEL_SOURCE_DIR "/lens_models/";
  const json scene = {{"version", 1}, {"lens", read_json_file(lenses + "phone_6p_4.2mm_f1.8.json")}};
  SampleLine line;
  const auto lens_with = [&](const json& set) {
    line.set = set;
    return simulator::read_lens(with_set(scene, line).at("lens"), "", "/lens", 1).thin;
  };
  const std::string file = lenses + "phone_7p_4.9mm_f1.85.json";
  EXPECT_NEAR(lens_with({{"lens.file", file}}).focal_length_m, 4.88e-3, 5e-6);
  EXPECT_NEAR(lens_with({{"lens.file", file}}).f_number, 1.85, 5e-3);
  EXPECT_NEAR(lens_with({{"lens.file", file}, {"lens.f_number", 2.8}}).f_number, 2.8, 1e-9);
  EXPECT_NEAR(lens_with({{"lens.file", lenses + "phone_thin_4.4mm_f1.8.json"}}).focal_length_m, 4.442e-3, 5e-6);
  EXPECT_NEAR(lens_with({{"lens.file", nullptr}, {"lens.f_number", 2.8}}).focal_length_m,
              lens_with(json::object()).focal_length_m, 1e-9);
}

TEST(Plan, SplitsShareNoSceneAndHaveTheirShares) {
  constexpr int kCount = 400;
  const Plan plan = plan_of(of_charts(kCount, 20));
  std::map<json, std::set<Split>> splits;
  std::map<json, int> counts;
  for (const SampleLine& line : plan.lines) {
    splits[line.scene].insert(line.split);
    ++counts[line.scene];
  }
  EXPECT_EQ(splits.size(), 20U);
  for (const auto& [scene, in] : splits) EXPECT_EQ(in.size(), 1U) << scene;
  // The discrepancy of the golden ratio's sequence of n points is below 1 + 1.5 log2(n) points (Niederreiter 1992).
  const double off = 1 + 1.5 * std::log2(kCount);
  EXPECT_NEAR(static_cast<double>(plan.samples[0]), 0.6 * kCount, off);
  EXPECT_NEAR(static_cast<double>(plan.samples[1]), 0.1 * kCount, off);
  EXPECT_EQ(plan.scenes, (std::array<std::size_t, 3>{12, 2, 6}));
}

// Some patterns are the shipped scenes', whatever the seed.
TEST(Plan, ChartsOfOneModelAreInOneSplit) {
  json recipe = of_charts(60, 60);
  recipe["scenes"][0]["set"].erase("pattern");  // drawn, one of seven
  std::map<std::string, std::set<Split>> splits;
  for (const SampleLine& line : plan_of(recipe).lines) {
    const std::string model = scenes::fixed_model_of(scenes::scene_kind("chart"), order_of(line.scene));
    splits[model].insert(line.split);
  }
  ASSERT_EQ(splits.size(), 4U);
  EXPECT_EQ(splits[""].size(), 3U);
  for (const char* model : {"target", "planes", "edges"}) EXPECT_EQ(splits[model].size(), 1U) << model;
  recipe["scenes"][0]["set"]["pattern"] = "planes";
  EXPECT_EQ(message_of<InputError>([&] { plan_of(recipe); }),
            "r.json: /scenes: 1 group of scenes that share no model and no light: must be 3 at least, one for each "
            "split of /split");
}

std::uint32_t word_in(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

std::string as_word(std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  return std::string(reinterpret_cast<const char*>(&word), sizeof(word));
}

/// The parts of a .glb file.
struct GlbParts {
  json root;
  std::string buffer;
};

GlbParts parts_of(const std::string& glb) {
  const std::uint32_t length = word_in(glb, 12);
  return {json::parse(glb.substr(20, length)), glb.substr(28 + length)};
}

/// As another program might save it: other JSON, and the buffer's parts in reverse order.
std::string saved_again(const std::string& glb) {
  auto [root, buffer] = parts_of(glb);
  root["asset"]["generator"] = "another program";
  std::string reversed;
  for (std::size_t i = root["bufferViews"].size(); i-- > 0;) {
    json& view = root["bufferViews"][i];
    const auto begin = view.value("byteOffset", std::size_t{0});
    view["byteOffset"] = reversed.size();
    reversed += buffer.substr(begin, view["byteLength"].get<std::size_t>());
    reversed.resize((reversed.size() + 3) / 4 * 4);
  }
  root["buffers"][0]["byteLength"] = reversed.size();
  std::string text = root.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  return "glTF" + as_word(2) + as_word(28 + text.size() + reversed.size()) + as_word(text.size()) + "JSON" + text +
         as_word(reversed.size()) + std::string("BIN\0", 4) + reversed;
}

TEST(Plan, CopiesOfAModelAreInOneSplit) {
  const TemporaryFolder folder;
  const std::string glb = read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb");
  for (const char* name : {"a.glb", "b.glb", "deep/C.GLB"}) folder.write(name, glb);
  folder.write("again.glb", saved_again(glb));
  GlbParts parts = parts_of(glb);
  parts.root["buffers"][0]["uri"] = "apart.bin";
  folder.write("apart.gltf", parts.root.dump());
  folder.write("apart.bin", parts.buffer);
  folder.write("other.glb", read_bytes(DUALPIXEL_SCENES_DIR "/occlusion_edges.glb"));
  folder.write("a.json", R"({"version": 1, "gltf": "a.glb"})");
  json recipe = small_recipe(64);
  recipe["scenes"] = {{{"folder", folder.path.string()}}};
  recipe["split"] = {{"train", 0.5}, {"test", 0.5}};
  std::set<std::string> train, test;
  for (const SampleLine& line : plan_of(recipe).lines) {
    (line.split == Split::train ? train : test).insert(line.scene["file"].get<std::string>());
  }
  std::set<std::string>& copies = train.size() == 5 ? train : test;
  EXPECT_EQ(copies, (std::set<std::string>{folder / "a.json", folder / "again.glb", folder / "apart.gltf",
                                           folder / "b.glb", folder / "deep/C.GLB"}));
  EXPECT_EQ(train.size() + test.size(), 6U);
}

// A small file must not cost minutes, nor a number without bounds what C++ leaves undefined.
TEST(Plan, ModelsWithHostileViewsAreKnownByTheirBytes) {
  const TemporaryFolder folder;
  folder.write("a.bin", std::string(16 << 20, 'a'));
  json model = {{"asset", {{"version", "2.0"}}}, {"scenes", {json::object()}}};
  model["buffers"] = {{{"byteLength", 16 << 20}, {"uri", "a.bin"}}};
  model["bufferViews"] = {{{"buffer", 0}, {"byteLength", 16 << 20}}};
  const auto hash = [&] { return simulator::geometry_hash(folder.write("a.gltf", model.dump())); };
  std::clock_t begin = std::clock();
  const std::string one_view = hash();
  const std::clock_t once = std::max<std::clock_t>(std::clock() - begin, 1);
  begin = std::clock();
  for (int i = 0; i < 10'000; ++i) model["bufferViews"].push_back(model["bufferViews"][0]);
  EXPECT_EQ(hash(), one_view);
  for (int i = 0; i < 10'000; ++i) {
    model["bufferViews"][static_cast<std::size_t>(i)] = {
        {"buffer", 0}, {"byteOffset", 4 * i}, {"byteLength", (16 << 20) - 4 * i}};
  }
  EXPECT_EQ(hash(), hash_of(model.dump()));
#ifndef DUALPIXEL_SANITIZED
  EXPECT_LT((std::clock() - begin) / once, 1000);  // every view by itself would take 20 000
#endif
  model["bufferViews"] = {{{"buffer", 0}, {"byteLength", 1e30}}};
  EXPECT_EQ(hash(), hash_of(model.dump()));
}

/// Models, each in a scene file of its own; the pictures of light are never opened by a plan.
json of_lit_models(const TemporaryFolder& folder, const std::map<std::string, std::string>& light_of_model) {
  for (const auto& [model, light] : light_of_model) {
    GlbParts parts = parts_of(read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb"));
    parts.buffer[0] = model[0];  // of its geometry, or else of a picture in it
    for (json& view : parts.root["bufferViews"]) parts.buffer[view.value("byteOffset", std::size_t{0})] = model[0];
    parts.root["buffers"][0]["uri"] = model + ".bin";
    folder.write("models/" + model + ".gltf", parts.root.dump());
    folder.write("models/" + model + ".bin", parts.buffer);
    const json scene = {
        {"version", 1}, {"gltf", model + ".gltf"}, {"environment", {{"model", "file"}, {"path", light}}}};
    folder.write("models/" + model + ".json", scene.dump());
  }
  json recipe = small_recipe(64);
  recipe["scenes"] = {{{"folder", folder / "models"}}};
  recipe["split"] = {{"train", 0.5}, {"test", 0.5}};
  return recipe;
}

TEST(Plan, ScenesLitByOnePictureAreInOneSplit) {
  const TemporaryFolder folder;
  // a and b by copies of one picture, b and c by one file
  folder.write("models/1.hdr", "sunset");
  folder.write("models/copy.hdr", "sunset");
  folder.write("models/2.hdr", "noon");
  const json recipe = of_lit_models(folder, {{"a", "1.hdr"}, {"b", "copy.hdr"}, {"c", "2.hdr"}, {"d", "2.hdr"}});
  std::map<Split, std::set<std::string>> models;
  for (const SampleLine& line : plan_of(recipe).lines) {
    models[line.split].insert(std::filesystem::path(line.scene["file"].get<std::string>()).stem());
  }
  using Names = std::set<std::string>;
  EXPECT_EQ((std::set<Names>{models[Split::train], models[Split::test]}), (std::set<Names>{{"a", "b"}, {"c", "d"}}));
  json lit = recipe;  // where the recipe's own light replaces them, four models stay four
  lit["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {9, 9, 9}}}}};
  lit["split"] = {{"train", 0.4}, {"validation", 0.3}, {"test", 0.3}};
  EXPECT_EQ(plan_of(lit).lines.size(), 64U);
  lit["set"] = recipe["set"];
  lit["set"]["environment.model"] = {{"choice", {"none", "file"}}};  // by which the scenes' own pictures stay in use
  EXPECT_EQ(message_of<InputError>([&] { plan_of(lit); }),
            "r.json: /scenes: 2 groups of scenes that share no model and no light: must be 3 at least, one for each "
            "split of /split");
  lit["set"] = recipe["set"];
  EXPECT_EQ(message_of<InputError>([&] { plan_of(lit); }),
            "r.json: /scenes: 2 groups of scenes that share no model and no light: must be 3 at least, one for each "
            "split of /split");
}

// A scene file may name a picture and leave to the recipe whether it lights the scene.
TEST(Plan, ScenesWhoseModelOfLightIsTheRecipesAreKnownByTheirPictures) {
  const TemporaryFolder folder;
  for (const char* name : {"1", "2"}) folder.write(std::string("models/") + name + ".hdr", name);
  json recipe = of_lit_models(folder, {{"a", "1.hdr"}, {"b", "1.hdr"}, {"c", "2.hdr"}});
  for (const auto& [name, light] : {std::pair{"a", "1.hdr"}, {"b", "1.hdr"}, {"c", "2.hdr"}}) {
    const json scene = {{"version", 1}, {"gltf", std::string(name) + ".gltf"}, {"environment", {{"path", light}}}};
    folder.write(std::string("models/") + name + ".json", scene.dump());
  }
  recipe["set"]["environment.model"] = "file";
  std::map<std::string, std::set<Split>> splits;
  for (const SampleLine& line : plan_of(recipe).lines) {
    splits[std::filesystem::path(line.scene["file"].get<std::string>()).stem()].insert(line.split);
  }
  EXPECT_EQ(splits["a"].size(), 1U);
  EXPECT_EQ(splits["a"], splits["b"]);
  EXPECT_NE(splits["a"], splits["c"]);
  // a picture of the recipe's takes the place of theirs, and lights all splits
  recipe["set"]["environment.path"] = folder / "models/1.hdr";
  EXPECT_TRUE(message_of<InputError>([&] { plan_of(recipe); }).starts_with("r.json: /set/environment.path: "));
  recipe.erase("split");
  for (const SampleLine& line : plan_of(recipe).lines) EXPECT_EQ(line.set["environment.path"], folder / "models/1.hdr");
}

// A large group must not be in the first split more often than a single scene is.
TEST(Plan, GroupsOfScenesAreDealtOutByChance) {
  const TemporaryFolder folder;
  folder.write("models/light.hdr", "noon");
  for (int i = 0; i < 18; ++i) {  // nine are lit by one picture; the others are nine groups of one
    const std::string name = std::string("models/") + static_cast<char>('a' + i);
    json model = {{"asset", {{"version", "2.0"}}}, {"bufferViews", {{{"buffer", 0}, {"byteLength", 1}}}}};
    model["buffers"] = {{{"byteLength", 1}, {"uri", std::string(1, static_cast<char>('a' + i)) + ".bin"}}};
    folder.write(name + ".bin", name.substr(7));
    folder.write(name + ".gltf", model.dump());
    json scene = {{"version", 1}, {"gltf", name.substr(7) + ".gltf"}};
    if (i < 9) scene["environment"] = {{"model", "file"}, {"path", "light.hdr"}};
    folder.write(name + ".json", scene.dump());
  }
  json recipe = small_recipe(1);
  recipe["scenes"] = {{{"folder", folder / "models"}}};
  recipe["split"] = {{"train", 0.5}, {"test", 0.5}};
  int in_train = 0;
  constexpr int kSeeds = 64;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    recipe["seed"] = seed;
    std::vector<std::string> warnings;
    const Assets assets = gather_assets(read_recipe(recipe, "r.json"), warnings);
    ASSERT_EQ(assets[0].scenes.size() + assets[2].scenes.size(), 18U);
    in_train += assets[0].scenes.size() > 9 ? 1 : 0;
  }
  EXPECT_NEAR(in_train, 0.5 * kSeeds, 4 * 0.5 * std::sqrt(kSeeds));  // four deviations of a fair coin's
}

TEST(Plan, SplitsShareNoEnvironment) {
  const TemporaryFolder folder;
  for (const char* name : {"1", "2", "3", "4"}) folder.write(std::string("light/") + name + ".exr", name);
  folder.write("light/deep/copy_of_1.EXR", "1");
  json recipe = small_recipe(200);
  recipe["split"] = {{"train", 0.5}, {"test", 0.5}};
  recipe["relations"]["environments"] = folder / "light";
  std::map<std::string, std::set<Split>> splits;  // of a picture's bytes
  std::set<std::string> files;
  for (const SampleLine& line : plan_of(recipe).lines) {
    const std::string file = line.set["environment"]["path"];
    files.insert(file);
    splits[read_bytes(file)].insert(line.split);
  }
  EXPECT_EQ(files.size(), 5U);
  EXPECT_EQ(splits.size(), 4U);
  for (const auto& [bytes, in] : splits) EXPECT_EQ(in.size(), 1U) << bytes;
  recipe["relations"].erase("environments");
  const std::string path = folder / "light/1.exr",
                    refusal =
                        ": would be in more than one split: name a folder by relations.environments, whose files "
                        "are shared out";
  recipe["set"]["environment.path"] = {{"choice", {path, folder / "light/2.exr"}}};
  EXPECT_EQ(message_of<InputError>([&] { plan_of(recipe); }), "r.json: /set/environment.path: " + path + refusal);
  recipe["set"].erase("environment.path");
  recipe["set"]["environment"] = {{"constant", {{"model", "file"}, {"path", path}}}};
  EXPECT_EQ(message_of<InputError>([&] { plan_of(recipe); }), "r.json: /set/environment: " + path + refusal);
  recipe.erase("split");
  EXPECT_EQ(plan_of(recipe).lines.size(), 200U);
}

/// As a user who may not read everything.
class AsNobody {
 public:
  AsNobody() : was_(geteuid()) { EXPECT_TRUE(was_ != 0 || seteuid(65534) == 0); }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;
  ~AsNobody() { EXPECT_TRUE(was_ != 0 || seteuid(was_) == 0); }

 private:
  uid_t was_;
};

/// A folder that nobody may read, until it is to be removed.
class Shut {
 public:
  explicit Shut(std::string path) : path_(std::move(path)) {
    std::filesystem::permissions(path_, std::filesystem::perms::none);
  }
  ~Shut() {
    std::error_code ignored;
    std::filesystem::permissions(path_, std::filesystem::perms::owner_all, ignored);
  }
  Shut(const Shut&) = delete;
  Shut& operator=(const Shut&) = delete;

 private:
  std::string path_;
};

TEST(Plan, SaysWhichFolderAndWhichSceneFileCannotBeRead) {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  fs::permissions(folder.path, fs::perms(0755));
  folder.write("models/a.glb", read_bytes(DUALPIXEL_SCENES_DIR "/slanted_planes.glb"));
  folder.write("models/notes.json", R"({"author": "somebody"})");
  folder.write("models/sizes.json", "[1, 2]");
  fs::create_symlink("nowhere", folder / "models/link.json");
  json recipe = small_recipe(2);
  recipe["scenes"] = {{{"folder", folder / "models"}}};
  recipe["set"]["environment"] = {{"constant", {{"model", "constant"}, {"nits", {9, 9, 9}}}}};
  const Plan plan = plan_of(recipe);
  EXPECT_EQ(plan.lines.size(), 2U);
  EXPECT_EQ(plan.warnings,
            std::vector<std::string>{(folder / "models/notes.json") + ": no scene file, which has version "
                                                                      "and gltf: left out, with 1 more"});
  folder.write("models/broken.json", R"({"version": 1, "gltf": "a.glb")");
  EXPECT_TRUE(message_of<InputError>([&] {
                plan_of(recipe);
              }).starts_with("r.json: /scenes/0: " + (folder / "models/broken.json") + ": parse error"));
  fs::remove(folder / "models/broken.json");
  fs::create_directories(folder / "models/shut/deep");
  const Shut shut(folder / "models/shut");
  const AsNobody nobody;
  if (eaccess(folder.path.c_str(), R_OK | X_OK) != 0) GTEST_SKIP() << "TMPDIR is not open to everybody";
  EXPECT_EQ(message_of<InputError>([&] { plan_of(recipe); }),
            "r.json: /scenes/0: " + (folder / "models/shut") + ": cannot be read as a folder: Permission denied");
}

TEST(Plan, GridsRunThroughAllCombinations) {
  json recipe = small_recipe(12);
  recipe["set"]["exposure.iso"] = {{"grid", {100, 200, 400}}};
  recipe["set"]["lens.f_number"] = {{"grid", {1.8, 2.8}}};
  std::map<std::pair<int, double>, int> seen;
  for (const SampleLine& line : plan_of(recipe).lines) {
    ++seen[{line.set["exposure.iso"].get<int>(), line.set["lens.f_number"].get<double>()}];
  }
  EXPECT_EQ(seen.size(), 6U);
  for (const auto& [values, count] : seen) EXPECT_EQ(count, 2);
}

TEST(Plan, ModelSizeIsAScenesOwn) {
  json recipe = small_recipe(20);
  recipe["relations"]["model_size_m"] = {{"log_uniform", {0.3, 2}}};
  std::map<json, std::set<double>> sizes;
  for (const SampleLine& line : plan_of(recipe).lines) sizes[line.scene].insert(line.set["model_size_m"].get<double>());
  ASSERT_EQ(sizes.size(), 2U);
  for (const auto& [scene, size] : sizes) EXPECT_EQ(size.size(), 1U);
}

TEST(Plan, StatesItsBytes) {
  // left and right 32 x 12, disparity likewise, depth 64 x 48, 4 bytes each
  EXPECT_EQ(plan_of(small_recipe()).bytes_per_sample, 4 * (3 * 32 * 12 + 64 * 48));
  json recipe = small_recipe();
  recipe.erase("keep");
  recipe["layout"] = "dpdd";
  recipe["set"]["sensor.dp_downsample_x"] = recipe["set"]["sensor.dp_downsample_y"] = 1;
  EXPECT_EQ(plan_of(recipe).bytes_per_sample, 4 * 6 * 64 * 48);
}

TEST(Plan, WarnsOfWhatIsSeldomMeant) {
  json recipe = small_recipe();
  EXPECT_TRUE(plan_of(recipe).warnings.empty());
  recipe["set"]["camera.file"] = DUALPIXEL_SCENES_DIR "/cameras/phone_2019.json";
  const std::vector<std::string> warnings = plan_of(recipe).warnings;
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(warnings[0].starts_with("r.json: 6 of 6 samples, the first is 0: ")) << warnings[0];
  EXPECT_NE(warnings[0].find("/lens: hides the lens of "), std::string::npos) << warnings[0];
  recipe["set"]["lens"] = nullptr;
  EXPECT_TRUE(plan_of(recipe).warnings.empty());
}

// The model of a drawn scene's environment is the kind's, and hangs on the seed of some.
TEST(Plan, TakesFieldsOfDrawnEnvironments) {
  json recipe = small_recipe(20);
  const auto fault = [&](const char* kind, const json& own, const char* field, const json& value) {
    recipe["scenes"] = {{{"kind", kind}, {"seeds", {1, 20}}, {"set", own}}};
    recipe["set"] = {{field, value}};
    return message_of<InputError>([&] { plan_of(recipe); });
  };
  const json low_or_high = {{"uniform", {10, 60}}}, none = json::object();
  const char *const elevation = "environment.sun_elevation_deg", *const nits = "environment.nits";
  EXPECT_EQ(fault("outdoors", none, elevation, low_or_high), "");
  EXPECT_EQ(fault("portrait", {{"place", "street"}}, elevation, low_or_high), "");
  EXPECT_EQ(fault("still_life", {{"light", "sun"}}, elevation, low_or_high), "");
  EXPECT_EQ(fault("room", none, nits, {5, 5, 5}), "");
  EXPECT_EQ(fault("outdoors", {{elevation, 20}}, "lens.f_number", 2.8), "");
  EXPECT_NE(fault("room", none, elevation, low_or_high).find("sun_elevation_deg: unknown field"), std::string::npos);
  EXPECT_NE(fault("chart", none, elevation, low_or_high).find("sun_elevation_deg: unknown field"), std::string::npos);
  EXPECT_NE(fault("portrait", none, elevation, low_or_high), "") << "rooms among them have no sun";
  EXPECT_NE(fault("still_life", none, elevation, low_or_high), "");
  EXPECT_NE(fault("outdoors", none, elevation, 900), "");
}

TEST(Plan, RefusesBeforeAnythingIsRendered) {
  const auto refusal = [](const std::string& pointer, const json& value) {
    json recipe = small_recipe();
    recipe[json::json_pointer(pointer)] = value;
    return message_of<InputError>([&] { plan_of(recipe); });
  };
  EXPECT_TRUE(refusal("/set/lens.f_number", {{"uniform", {-2, -1}}}).starts_with("r.json: sample 0: "));
  EXPECT_NE(refusal("/set/lens.f_number", -2).find("f_number: -2: must be a number in [0.1, 1000]"), std::string::npos);
  EXPECT_NE(refusal("/set/lens.f_numbr", 2).find("did you mean 'f_number'?"), std::string::npos);
  EXPECT_EQ(refusal("/keep/0", "lef"),
            "r.json: /keep: lef: must be one of 'left', 'right', 'combined', 'raw', "
            "'left_noiseless', 'right_noiseless', 'left_rgb', 'right_rgb', 'all_in_focus', "
            "'photograph', 'depth_m', 'blur_px', 'disparity_dp_px', 'normal', 'person', "
            "'valid', 'object_id', 'view_depth_m', 'view_blur_px', 'view_disparity_dp_px', "
            "'view_normal', 'view_person', 'view_valid', 'view_object_id'; did you mean "
            "'left'?");
  EXPECT_TRUE(refusal("/keep", json::array()).starts_with("r.json: /keep: []: must be a list of pictures: 'left', "));
  EXPECT_TRUE(refusal("/keep", "left").starts_with("r.json: /keep: \"left\": must be a list of pictures: 'left', "));
  EXPECT_EQ(refusal("/set/camera.focus_distance_m", 1),
            "r.json: /set/camera.focus_distance_m: follows from /relations/focus: give one of them");
  {
    json recipe = small_recipe();
    recipe["set"].erase("exposure.iso");
    recipe["set"]["exposure"] = {{"constant", {{"iso", 800}, {"time_s", 0.01}}}};
    recipe["relations"] = {{"exposure_mean", 0.2}};
    EXPECT_EQ(message_of<InputError>([&] { plan_of(recipe); }),
              "r.json: /set/exposure: follows from /relations/exposure_mean: give one of them");
  }
  EXPECT_EQ(refusal("/set/render.seed", 1),
            "r.json: /set/render.seed: each sample has a seed of its own: leave it out");
  EXPECT_EQ(refusal("/split", {{"train", 0.5}}),
            "r.json: /split/train: the shares of train, validation and test add up to 0.5: must be 1");
  EXPECT_EQ(refusal("/split", {{"train", 0.4}, {"validation", 0.3}, {"test", 0.3}}),
            "r.json: /scenes: 2 groups of scenes that share no model and no light: must be 3 at least, one for each "
            "split of /split");
  EXPECT_EQ(refusal("/count", 0), "r.json: /count: 0: must be an integer in [1, 10000000]");
  EXPECT_EQ(refusal("/scenes/0", {{"kind", "chart"}, {"seeds", {3, 1}}}),
            "r.json: /scenes/0/seeds: [3,1]: must be [first, last], whole numbers in [0, 1e15]");
  EXPECT_EQ(
      refusal("/scenes", {{{"kind", "chart"}, {"seeds", {0, 599999}}}, {{"kind", "room"}, {"seeds", {1, 400001}}}}),
      "r.json: /scenes/1/seeds: [1,400001]: 1000001 seeds in all: must be 1000000 at most");
  EXPECT_EQ(refusal("/scenes/1", {{"kind", "chart"}, {"seeds", {1, 3}}, {"set", {{"width_px", 64}}}}),
            "r.json: /scenes/1: chart: width_px: 64: must be a multiple of 16 in [128, 8192] photosites");
  EXPECT_EQ(refusal("/scenes/1", {{"file", "/none.json"}}), "r.json: /scenes/1: /none.json: no such file");
}

TEST(Recipe, RefusesFieldsOfTooManyNames) {
  std::string name = "lens.x";
  for (int i = 0; i < 500'000; ++i) name += ".x";
  json recipe = small_recipe();
  recipe["set"][name] = 1;
  const auto refusal = [&] { return message_of<InputError>([&] { read_recipe(recipe, "r.json"); }); };
  EXPECT_TRUE(refusal().starts_with("r.json: /set/lens.x.x"));
  EXPECT_TRUE(refusal().ends_with(": more than 32 names"));
  recipe["set"].erase(name);
  recipe["scenes"] = {{{"kind", "chart"}, {"seeds", {1, 2}}, {"set", {{name, 1}}}}};
  EXPECT_TRUE(refusal().starts_with("r.json: /scenes/0/set/lens.x.x"));
  EXPECT_TRUE(refusal().ends_with(": more than 32 names"));
  recipe["scenes"][0]["set"] = {{name.substr(0, std::string("lens").size() + 2 * 31), 1}};  // 32 of them
  EXPECT_EQ(refusal(), "");
}

TEST(Recipe, NamesFilesBesideItself) {
  json recipe = small_recipe();
  for (const char* field : {"lens.file", "camera.file", "environment.path"}) {
    recipe["set"][field] = "../files/a.json";
    EXPECT_EQ(read_recipe(recipe, "/sets/new/r.json").set.at(field).values.front(), "/sets/files/a.json");
  }
  const auto read = [&](const std::string& field, const json& value) {
    json other = small_recipe();
    other.erase("relations");
    other["set"][field] = {{"choice", {value, "b.json"}}};
    return read_recipe(other, "/sets/new/r.json").set.at(field).values.front();
  };
  const std::string name = "../files/a.json", full = "/sets/files/a.json";
  EXPECT_EQ(read("camera", {{"file", name}, {"node", "a"}}), (json{{"file", full}, {"node", "a"}}));
  EXPECT_EQ(read("lens", {{"base", {{"file", name}}}, {"field", {{"map", name}}}}),
            (json{{"base", {{"file", full}}}, {"field", {{"map", full}}}}));
  EXPECT_EQ(read("environment", {{"model", "file"}, {"path", name}}), (json{{"model", "file"}, {"path", full}}));
  EXPECT_EQ(read("truth.photograph_lens", name), full);
  for (const char* own : {"ideal", "own"}) EXPECT_EQ(read("truth.photograph_lens", own), own);
  recipe["scenes"] = {{{"kind", "chart"}, {"seeds", {1, 2}}, {"set", {{"camera.file", name}, {"light", name}}}}};
  EXPECT_EQ(read_recipe(recipe, "/sets/new/r.json").scenes[0].set, (json{{"camera.file", full}, {"light", name}}));
  recipe["scenes"] = {{{"kind", "portrait"}, {"seeds", {1, 2}}, {"set", {{"makehuman", "../files"}}}}};
  EXPECT_EQ(read_recipe(recipe, "/sets/new/r.json").scenes[0].set, (json{{"makehuman", "/sets/files"}}));
}

TEST(Plan, StaysAsItWasWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "set";
  const Recipe recipe = read_recipe(small_recipe(), "r.json");
  write_plan(make_plan(recipe), recipe, path);
  const std::string written = read_bytes(path + "/plan.jsonl");
  EXPECT_EQ(read_plan(path).size(), 6U);
  write_plan(make_plan(recipe), recipe, path);  // the same: stays
  json changed = small_recipe(7);
  changed["seed"] = 6;
  for (const json& other : {changed, small_recipe(5)}) {
    const Recipe another = read_recipe(other, "r.json");
    EXPECT_EQ(message_of<InputError>([&] { write_plan(make_plan(another), another, path); }),
              path + ": holds another plan, whose lines may not change: choose another folder");
    EXPECT_EQ(read_bytes(path + "/plan.jsonl"), written);
  }
  write_bytes(path + "/plan.jsonl", written.substr(1));
  EXPECT_EQ(message_of<InputError>([&] { read_plan(path); }),
            path + "/plan.jsonl: was changed since, or planning was cut short: plan the same recipe here again");
}

TEST(Plan, GetsMoreLinesWhereTheFirstStay) {
  const TemporaryFolder folder;
  const auto write = [](const std::string& to, int count) {
    const Recipe recipe = read_recipe(small_recipe(count), "r.json");
    write_plan(make_plan(recipe), recipe, to);
  };
  const std::string path = folder / "set", whole = folder / "whole";
  write(path, 6);
  const std::string about = read_bytes(path + "/dataset.json");
  write(path, 9);
  write(whole, 9);
  EXPECT_TRUE(testing::bytes_under(path) == testing::bytes_under(whole));
  EXPECT_EQ(read_plan(path).size(), 9U);
  write_bytes(path + "/dataset.json", about);  // as where it was killed between the two files
  write(path, 9);
  EXPECT_TRUE(testing::bytes_under(path) == testing::bytes_under(whole));
}

TEST(Plan, IsWrittenAgainWhereItsFileIsCutShort) {
  const TemporaryFolder folder;
  const Recipe recipe = read_recipe(small_recipe(), "r.json");
  const std::string path = folder / "set";
  write_plan(make_plan(recipe), recipe, path);
  const auto whole = testing::bytes_under(path);
  const std::string text = whole.at("plan.jsonl");
  write_bytes(path + "/plan.jsonl", text.substr(0, text.size() / 2));
  write_plan(make_plan(recipe), recipe, path);
  EXPECT_TRUE(testing::bytes_under(path) == whole);
}

TEST(Plan, LeavesADescriptionOfAnotherKindAsItIs) {
  const TemporaryFolder folder;
  const Recipe recipe = read_recipe(small_recipe(3), "r.json"), more = read_recipe(small_recipe(5), "r.json");
  const std::string path = folder / "set", about = path + "/dataset.json";
  write_plan(make_plan(recipe), recipe, path);
  json another = json::parse(read_bytes(about));
  another["plan_xxh64"] = "0123456789abcdef";
  for (const auto& [text, message] : std::map<std::string, std::string>{
           {R"({"title": "notes of mine"})",
            about + ": /format: is no data set of this version: must be \"dualpixel-dataset\", and /version 1"},
           {another.dump(), path + ": holds another plan, whose lines may not change: choose another folder"}}) {
    std::filesystem::remove(about);
    folder.write("mine.json", text);
    std::filesystem::create_symlink("../mine.json", about);
    EXPECT_EQ(message_of<InputError>([&] { write_plan(make_plan(more), more, path); }), message);
    EXPECT_EQ(read_bytes(folder / "mine.json"), text);
  }
}

TEST(Plan, SplitsGetWholeThings) {
  using Counts = std::array<std::size_t, 3>;
  EXPECT_EQ(split_counts(10, {0.8, 0.1, 0.1}), (Counts{8, 1, 1}));
  EXPECT_EQ(split_counts(3, {0.8, 0.1, 0.1}), (Counts{1, 1, 1}));
  EXPECT_EQ(split_counts(5, {0.5, 0, 0.5}), (Counts{2, 0, 3}));
  EXPECT_EQ(split_counts(1, {1, 0, 0}), (Counts{1, 0, 0}));
}

/// The most memory that this process has had since its peak was forgotten.
long peak_kb() {
  std::ifstream status("/proc/self/status");
  long peak = -1;
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) peak = std::stol(line.substr(6));
  }
  EXPECT_GT(peak, 0);
  return peak;
}

TEST(SlowPlan, OfAMillionSeedsTakesHalfAGigabyte) {
  ASSERT_TRUE(std::ofstream("/proc/self/clear_refs") << "5" << std::flush);  // forgets the peak (proc(5))
  const long before = peak_kb();
  const Plan plan = plan_of(of_charts(10000, 1'000'000));
  EXPECT_LT(peak_kb() - before, 500'000);
  // so few draws of so many hardly meet: by the evenly spread sequence, never
  std::set<json> scenes;
  for (const SampleLine& line : plan.lines) scenes.insert(line.scene);
  EXPECT_GT(scenes.size(), 9900U);
}

}  // namespace
}  // namespace dualpixel::datasets
