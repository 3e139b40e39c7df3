// `experiment methods` goes on with what it finds in its folder, which anybody may have altered since.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "capture/image/image_io.h"
#include "evaluation/comparison/compare_methods.h"
#include "evaluation/comparison/comparison_scenes.h"
#include "pipeline/segmentation/network.h"
#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

constexpr int kWidth = 96, kHeight = 72;

class KeptMethods : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
    std::filesystem::create_directories(scene);
    write_bytes(out + "/methods.json", "{}\n");
    for (const std::string& method : evaluation::compared_names()) {
      figures.methods.push_back({method, {30, 0.9, 0.1}, {29, 0.8, 0.2}});
    }
    write_pictures(kWidth, kHeight);
  }

  void write_pictures(int width, int height) const {
    write_png8(scene + "/photograph.png", Image(width, height, 3, 0.5f));
    for (std::size_t i = 1; i <= figures.methods.size(); ++i) {
      write_png8(scene + "/method_" + std::to_string(i) + ".png", Image(width, height, 3, 0.4f));
    }
  }

  Outcome outcome() {
    replace_file(scene + "/figures.json", to_json(figures).dump());
    return run_command("experiment methods --scenes 1 -o '" + out + "'");
  }

  const TemporaryFolder folder;
  const std::string out = folder / "methods", name = evaluation::comparison_scenes()[0].name;
  const std::string scene = out + "/results/" + name;
  evaluation::SceneComparison figures{name, true, true, false, 0.9, {{kWidth - 64, kHeight - 64, 64}}, {}};
};

TEST_F(KeptMethods, MakeTheirPage) {
  const Outcome first = outcome();
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_NE(read_file(out + "/methods.html").find(name), std::string::npos);
}

TEST_F(KeptMethods, MayBeOfTinyPictures) {
  figures.crops.clear();
  write_pictures(2, 1);
  const Outcome made = outcome();
  EXPECT_EQ(made.status, 0) << made.err;
}

TEST_F(KeptMethods, OfAnotherSceneOrOtherMethodsAreRefused) {
  const evaluation::SceneComparison whole = figures;
  figures.scene = "another";
  const Outcome of_scene = outcome();
  expect_one_line_refusal(of_scene);
  EXPECT_NE(of_scene.err.find("figures.json: /scene: another: must be " + name), std::string::npos) << of_scene.err;
  figures = whole;
  figures.methods[1].method = "dp";
  const Outcome of_methods = outcome();
  expect_one_line_refusal(of_methods);
  EXPECT_NE(of_methods.err.find("figures.json: /methods/1/method: dp: must be seg"), std::string::npos)
      << of_methods.err;
}

TEST_F(KeptMethods, ACropBesideThePhotographIsRefused) {
  figures.crops[0].x += 1;
  const Outcome refused = outcome();
  expect_one_line_refusal(refused);
  EXPECT_NE(refused.err.find("figures.json: /crops: [33, 8]"), std::string::npos) << refused.err;
}

TEST_F(KeptMethods, APictureOfAnotherSizeIsRefused) {
  const std::pair<Image, std::string> others[] = {
      {Image(kWidth + 1, kHeight, 3, 0.4f), "method_3.png: must be of the photograph's size, 96 x 72"},
      {Image(kWidth, kHeight, 1, 0.4f), "method_3.png: must be RGB"}};
  for (const auto& [other, message] : others) {
    write_png8(scene + "/method_3.png", other);
    const Outcome refused = outcome();
    expect_one_line_refusal(refused);
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace dualpixel
