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
    write_png8(scene + "/photograph.png", Image(kWidth, kHeight, 3, 0.5f));
    std::vector<std::string> names = evaluation::compared_methods();
    names.insert(names.end(), {"true disparity", "not blurred"});
    for (std::size_t i = 0; i < names.size(); ++i) {
      figures.methods.push_back({names[i], {30, 0.9, 0.1}, {29, 0.8, 0.2}});
      write_png8(scene + "/method_" + std::to_string(i + 1) + ".png", Image(kWidth, kHeight, 3, 0.4f));
    }
  }

  Outcome outcome() {
    replace_file(scene + "/figures.json", to_json(figures).dump());
    return run_command("experiment methods --scenes 1 -o '" + out + "'");
  }

  const TemporaryFolder folder;
  const std::string out = folder / "methods", scene = out + "/results/" + evaluation::comparison_scenes()[0].name;
  evaluation::SceneComparison figures{"kept", true, true, false, 0.9, {{kWidth - 64, kHeight - 64, 64}}, {}};
};

TEST_F(KeptMethods, MakeTheirPage) {
  const Outcome first = outcome();
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_NE(read_file(out + "/methods.html").find("kept"), std::string::npos);
}

TEST_F(KeptMethods, ACropBesideThePhotographIsRefused) {
  figures.crops[0].x += 1;
  const Outcome refused = outcome();
  expect_one_line_refusal(refused);
  EXPECT_NE(refused.err.find("figures.json: /crops: [33, 8]"), std::string::npos) << refused.err;
}

TEST_F(KeptMethods, APictureOfAnotherSizeIsRefused) {
  for (const Image& other : {Image(kWidth + 1, kHeight, 3, 0.4f), Image(kWidth, kHeight, 1, 0.4f)}) {
    write_png8(scene + "/method_3.png", other);
    const Outcome refused = outcome();
    expect_one_line_refusal(refused);
    EXPECT_NE(refused.err.find("method_3.png: must be RGB"), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace dualpixel
