#include "evaluation/comparison/comparison_table.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/comparison/comparison_scenes.h"
#include "scenes/kinds/kinds.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

/// PSNR as given for the five, 10 dB for the references; SSIM and FLIP follow it.
SceneComparison scene_of(const std::string& name, bool people, const std::vector<double>& psnr_db) {
  SceneComparison scene{name, people, people, false, 0.9, {{1, 2, 128}}, {}};
  std::vector<std::string> names = compared_methods();
  names.insert(names.end(), {"true disparity", "not blurred"});
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double db = i < psnr_db.size() ? psnr_db[i] : 10;
    const PictureFigures figures{db, db / 50, 1 - db / 50};
    scene.methods.push_back({names[i], figures, figures});
  }
  return scene;
}

TEST(ComparisonTable, CountsWinsAndMeans) {
  const std::vector<SceneComparison> scenes = {scene_of("a", true, {30, 28, 29, 25, 20}),
                                               scene_of("b", true, {26, 27, 25, 27, 20}),
                                               scene_of("c", false, {31, 10, 31, 10, 22})};
  const std::vector<ComparedGroup> groups = compare_scenes(scenes);
  ASSERT_EQ(groups.size(), 3u);
  EXPECT_EQ(groups[1].name, "people");
  EXPECT_EQ(groups[1].scenes, 2u);
  EXPECT_EQ(groups[2].scenes, 1u);
  const std::vector<double> wins = {1.5, 0.5, 0.5, 0.5, 0, 0, 0};
  for (std::size_t m = 0; m < wins.size(); ++m) {
    for (const ComparedFigure& figure : groups[0].methods[m].figures) EXPECT_EQ(figure.wins, wins[m]) << m;
  }
  const ComparedMethod& seg = groups[0].methods[1];
  EXPECT_EQ(seg.method, "seg");
  EXPECT_NEAR(seg.figures[0].mean.mean, (28 + 27 + 10) / 3.0, 1e-12);
  EXPECT_NEAR(seg.figures[0].lead.mean, (2 - 1 + 21) / 3.0, 1e-12);
  // FLIP is better where there is less of it
  EXPECT_NEAR(seg.figures[2].lead.mean, 22 / 3.0 / 50, 1e-12);
  EXPECT_NE(to_text(groups).find("people, crops, 2 scenes"), std::string::npos);
}

TEST(ComparisonTable, ASceneIsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "figures.json";
  const SceneComparison scene = scene_of("a", true, {30, 28, 29, 25, 20});
  nlohmann::ordered_json json = to_json(scene);
  write_file(path, json.dump());
  EXPECT_EQ(to_json(read_scene_comparison(path)), json);
  json["methods"][2]["crops"]["flip"] = 2;
  replace_file(path, json.dump());
  EXPECT_THROW(read_scene_comparison(path), InputError);
  json["methods"].erase(2);
  replace_file(path, json.dump());
  EXPECT_THROW(read_scene_comparison(path), InputError);
}

TEST(ComparisonScenes, CanAllBeDrawn) {
  std::set<std::string> names;
  int people = 0;
  for (const ComparisonScene& scene : comparison_scenes()) {
    names.insert(scene.name);
    people += std::string(scene.kind) == "portrait";
    EXPECT_NO_THROW(
        scenes::scene_file_start(scenes::scene_kind(scene.kind), {scene.kind, scene.seed, scene.assignments}))
        << scene.name;
  }
  EXPECT_EQ(names.size(), comparison_scenes().size());
  EXPECT_GE(names.size(), 24u);
  EXPECT_GE(people, 12);
  EXPECT_GE(names.size() - people, 8u);
}

}  // namespace
}  // namespace dualpixel::evaluation
