// Scenes from seeds: the same bytes for the same seed, nothing that readers warn of, and refusals by name.
#include "scenes/drawn/draw_scene.h"

#include <gtest/gtest.h>

#include <set>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "scenes/kinds/kinds.h"
#include "simulator/simulate.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

struct Drawn {
  std::string json, glb;
};

Drawn draw(const std::string& kind, std::uint64_t seed, std::vector<std::string> assignments = {}) {
  const TemporaryFolder folder;
  assignments.insert(assignments.begin(), "width_px=128");
  draw_scene(scene_kind(kind), {kind, seed, assignments}, folder.path.string());
  return {read_bytes(folder / "scene.json"), read_bytes(folder / "scene.glb")};
}

/// Loads what a seed gives; the reader refuses what is not finite and warns of triangles without area.
void expect_clean(const std::string& kind, std::uint64_t seed) {
  SCOPED_TRACE(kind + " " + std::to_string(seed));
  const TemporaryFolder folder;
  EXPECT_EQ(draw_scene(scene_kind(kind), {kind, seed, {"width_px=128"}}, folder.path.string()),
            std::vector<std::string>());
  const simulator::Simulation simulation =
      simulator::read_simulation(read_json_file(folder / "scene.json"), folder / "scene.json");
  const simulator::Scene scene = simulator::load_scene(simulation);
  EXPECT_EQ(scene.warnings, std::vector<std::string>());
  EXPECT_FALSE(scene.meshes.empty());
  for (const simulator::Mesh& mesh : scene.meshes) {
    for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-3);
  }
}

std::string refusal_of(const std::string& kind, const std::vector<std::string>& assignments) {
  try {
    draw(kind, 1, assignments);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SlowDrawnScenes, TheSeedDecidesEveryByte) {
  const Drawn first = draw("still_life", 3), again = draw("still_life", 3), other = draw("still_life", 4);
  EXPECT_TRUE(first.glb == again.glb);
  EXPECT_EQ(first.json, again.json);
  EXPECT_FALSE(first.glb == other.glb);
}

TEST(SlowDrawnScenes, LoadWithoutWarnings) {
  for (const SceneKind& kind : scene_kinds()) expect_clean(kind.name, 1);
}

TEST(SlowDrawnScenes, SizeAndSensorLeaveTheSceneAlone) {
  const Drawn small = draw("chart", 2), large = draw("chart", 2, {"width_px=256", "lens=phone_thin"});
  EXPECT_TRUE(small.glb == large.glb);
  EXPECT_NE(small.json, large.json);
}

TEST(SlowDrawnScenes, FieldsOfTheSceneFileCanBeSet) {
  const Drawn drawn = draw("chart", 2, {"burst.frames=3", "lens=phone_thin", "lens.f_number=2.4"});
  const nlohmann::json scene = nlohmann::json::parse(drawn.json);
  EXPECT_EQ(scene["burst"]["frames"], 3);
  EXPECT_EQ(scene["lens"]["f_number"], 2.4);
  EXPECT_EQ(refusal_of("chart", {"burst.frames=0"}), "chart: /burst/frames: 0: must be an integer in [1, 1000]");
}

TEST(DrawnScenes, RefusalsNameParameterValueAndRange) {
  const std::string range = refusal_of("still_life", {"objects=900"});
  for (const char* word : {"still_life", "objects", "900", "[1, 60]"})
    EXPECT_NE(range.find(word), std::string::npos) << range;
  EXPECT_NE(refusal_of("still_life", {"objects=2.5"}).find("integer"), std::string::npos);
  EXPECT_NE(refusal_of("still_life", {"distance_m=nan"}).find("distance_m: nan"), std::string::npos);
  EXPECT_NE(refusal_of("still_life", {"light=moon"}).find("'window', 'lamp'"), std::string::npos);
  EXPECT_NE(refusal_of("still_life", {"width_px=100"}).find("multiple of 16"), std::string::npos);
  const std::string unknown = refusal_of("still_life", {"objcets=3"});
  EXPECT_NE(unknown.find("did you mean 'objects'"), std::string::npos) << unknown;
  EXPECT_NE(refusal_of("still_life", {"objects"}).find("NAME=VALUE"), std::string::npos);
  EXPECT_THROW(scene_kind("stil_life"), InputError);
}

TEST(DrawnScenes, TablesHoldWhatTheyDraw) {
  for (const SceneKind& kind : scene_kinds()) {
    std::set<std::string> names;
    for (const Parameter& p : parameters_of(kind)) {
      EXPECT_TRUE(names.insert(p.name).second) << p.name;
      EXPECT_EQ(std::string(p.name).find('.'), std::string::npos) << "taken for a field of the scene file";
      if (!p.choices.empty()) continue;
      EXPECT_LE(p.low, p.drawn_low) << kind.name << ' ' << p.name;
      EXPECT_LE(p.drawn_low, p.drawn_high) << kind.name << ' ' << p.name;
      EXPECT_LE(p.drawn_high, p.high) << kind.name << ' ' << p.name;
    }
  }
}

TEST(DrawnScenes, SettingOneParameterLeavesTheOthers) {
  const std::vector<Parameter> table = parameters_of(scene_kind("still_life"));
  const Parameters drawn = draw_parameters("still_life", table, {}, 5),
                   set = draw_parameters("still_life", table, {"objects=33"}, 5);
  EXPECT_EQ(set.integer("objects"), 33);
  for (const auto& [name, value] : drawn.numbers()) {
    EXPECT_EQ(set.number(name), name == "objects" ? 33 : value) << name;
  }
  EXPECT_EQ(set.choices(), drawn.choices());
}

// `experiment scenes` takes any number of them, and renders them, too.
TEST(SweepDrawnScenes, SixOfEachKind) {
  for (const SceneKind& kind : scene_kinds()) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) expect_clean(kind.name, seed);
  }
}

}  // namespace
}  // namespace dualpixel::scenes
