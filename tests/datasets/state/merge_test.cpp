#include "datasets/state/merge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "capture/json_fields.h"
#include "datasets/plan/plan.h"
#include "datasets/render/render.h"
#include "datasets/state/webdataset.h"
#include "tests/datasets/small_recipe.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;
using testing::small_recipe;

void make(const std::string& folder, const json& recipe) {
  const Recipe read = read_recipe(recipe, "r.json");
  write_plan(make_plan(read), read, folder);
  EXPECT_EQ(render_shard({.dataset = folder}).failed, 0);
}

TEST(SlowMerge, IndexesWhatIsThere) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  make(set, small_recipe(3));
  std::filesystem::remove_all(set + "/samples/000001");
  const std::vector<json> index = merge_samples(set);
  ASSERT_EQ(index.size(), 2U);
  EXPECT_EQ(index[1]["name"], "000002");
  EXPECT_EQ(index[1]["files"].size(), 5U);
  const json& disparity = index[1]["statistics"]["disparity_dp_px"];
  ASSERT_EQ(disparity.size(), 21U);
  EXPECT_TRUE(std::is_sorted(disparity.begin(), disparity.end()));
  const std::string text = read_bytes(set + "/index.jsonl");
  EXPECT_EQ(text, index[0].dump() + "\n" + index[1].dump() + "\n");
  std::filesystem::remove_all(set + "/samples");
  EXPECT_EQ(message_of<InputError>([&] { merge_samples(set); }), set + ": nothing is rendered yet");
}

TEST(Merge, SaysWhereRenderingIsNoisierThanTheSensor) {
  const auto warning = [](const json& fractions) {
    std::vector<json> index;
    for (const json& fraction : fractions) index.push_back({{"noise_fraction", fraction}});
    return noise_warning(index);
  };
  EXPECT_EQ(warning({0.25, 2.0, nullptr}), "");
  EXPECT_TRUE(
      warning({0.25, 2.3, 2.1, nullptr})
          .starts_with("rendering noise is more than 2 times the sensor's in 2 of 4 samples, 2.3 times at most"));
}

// A data set that somebody else has made must not reach what lies beside it.
TEST(SlowMerge, ReadsNoFileThatThePlanDoesNotKeep) {
  const TemporaryFolder folder;
  const std::string set = folder / "set", file = set + "/samples/000000/sample.json";
  make(set, small_recipe(1));
  folder.write("secret", "private");
  json sample = json::parse(read_bytes(file));
  sample["files"][0]["path"] = "../../../secret";
  write_bytes(file, sample.dump());
  EXPECT_EQ(message_of<InputError>([&] { write_webdataset(merge_samples(set), set); }),
            file +
                ": /files: must name left.npy, right.npy, view_disparity_dp_px.npy, depth_m.npy, preview.png, as the "
                "plan has it");
  EXPECT_FALSE(std::filesystem::exists(set + "/webdataset"));
}

json dpdd_recipe(int count) {
  json recipe = small_recipe(count);
  recipe.erase("keep");
  recipe["layout"] = "dpdd";
  recipe["set"]["sensor.dp_downsample_x"] = recipe["set"]["sensor.dp_downsample_y"] = 1;
  return recipe;
}

// Whether a sample is gone, whose picture would be removed, or there, whose picture would be replaced.
TEST(SlowMerge, TouchesNothingBehindALinkedFolder) {
  const TemporaryFolder folder;
  const std::string set = folder / "set", link = set + "/dpdd/train_c/source";
  make(set, dpdd_recipe(2));
  folder.write("victim/000000.png", "mine");
  folder.write("victim/000001.png", "mine");
  std::filesystem::create_directories(set + "/dpdd/train_c");
  std::filesystem::create_directory_symlink("../../../victim", link);
  for (const bool gone : {false, true}) {
    if (gone) std::filesystem::remove_all(set + "/samples/000001");
    const auto before = testing::bytes_under(folder.path);
    EXPECT_EQ(message_of<InputError>([&] { merge_samples(set); }), link + ": is a link: must be a folder");
    EXPECT_TRUE(testing::bytes_under(folder.path) == before);
  }
}

TEST(SlowMerge, LeavesAllAsItWasWhereItIsRefused) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  make(set, dpdd_recipe(3));
  merge_samples(set);
  std::filesystem::remove_all(set + "/samples/000000");
  write_bytes(set + "/samples/000002/sample.json", "{}");
  const auto before = testing::bytes_under(set);
  EXPECT_NE(message_of<InputError>([&] { merge_samples(set); }), "");
  EXPECT_TRUE(testing::bytes_under(set) == before);
  for (const char* name : {"000001", "000002"}) std::filesystem::remove_all(set + "/samples/" + name);
  const auto linked = testing::bytes_under(set + "/dpdd");
  EXPECT_EQ(message_of<InputError>([&] { merge_samples(set); }), set + ": nothing is rendered yet");
  EXPECT_TRUE(testing::bytes_under(set + "/dpdd") == linked);
}

double linear_mean(const std::string& path) {
  const ImageU16 picture = read_image_u16(path, 3);
  double sum = 0;
  for (const std::uint16_t value : picture.data) sum += linear_from_srgb(static_cast<float>(value) / 65535);
  return sum / static_cast<double>(picture.data.size());
}

TEST(SlowMerge, LaysDpddOut) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  json recipe = dpdd_recipe(2);
  recipe["set"]["exposure.time_s"] = 0.001;
  make(set, recipe);
  merge_samples(set);
  merge_samples(set);  // again
  const std::string file = "/source/000001.png", c = set + "/dpdd/train_c";
  EXPECT_EQ(read_image_u16(c + file, 3).width, 64);
  EXPECT_EQ(read_image_u16(c + "/target/000001.png", 3).height, 48);
  // nothing is clipped: the undivided picture is the mean of the views, which are twice as bright as half of it;
  // of 64 * 48 * 3 values, each rounded by 1 / 65535 of the sRGB curve, and clipped below at black's noise
  const double views = 0.5 * (linear_mean(set + "/dpdd/train_l" + file) + linear_mean(set + "/dpdd/train_r" + file));
  EXPECT_NEAR(linear_mean(c + file) / views, 1, 0.01);
  std::filesystem::remove_all(set + "/samples/000000");
  EXPECT_EQ(merge_samples(set).size(), 1U);
  const std::map<std::string, std::string> left = testing::bytes_under(set + "/dpdd");
  EXPECT_EQ(left.size(), 4U);
  for (const auto& [name, bytes] : left) EXPECT_TRUE(name.ends_with("/000001.png")) << name;
}

// As the release's loaders read it: views over 16 * 1023, black near 64 / 1023, depth from 8 bits, all upright after a
// quarter turn back.
TEST(SlowMerge, LaysGooglesDataOut) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  json recipe = small_recipe(2);
  recipe["keep"] = {"left", "depth_m", "valid"};
  make(folder / "ours", recipe);
  recipe.erase("keep");
  recipe["layout"] = "google";
  make(set, recipe);
  merge_samples(set);
  merge_samples(set);  // again
  const std::string train = set + "/google/train/";
  const ImageU16 view = read_image_u16(train + "raw_left_pd/000001/result_pd_left_center.png", 1);
  const Image left = read_npy(folder / "ours/samples/000001/left.npy");
  ASSERT_EQ(view.width, left.height);
  ASSERT_EQ(view.height, left.width);
  const json exposure = read_json_file(set + "/samples/000001/sample.json").at("exposure");
  const double black = exposure.at("black_level_dn"), white = exposure.at("white_level_dn");
  const double full = (1 << exposure.at("bits").get<int>()) - 1;
  const Image depth = read_image(train + "merged_depth/000001/result_merged_depth_center.png");
  const Image depth_m = read_npy(folder / "ours/samples/000001/depth_m.npy");
  const Image valid = read_npy(folder / "ours/samples/000001/valid.npy");
  const Image confidence = read_npy(train + "merged_conf/000001/result_merged_conf_center.npy");
  for (int y = 0; y < left.height; ++y) {
    for (int x = 0; x < left.width; ++x) {
      const double signal = (view.at(left.height - 1 - y, x) / 16.0 / 1023 * full - black) / (white - black);
      EXPECT_NEAR(signal, left.at(x, y), 0.51 * full / 1023 / (white - black));  // rounded to 10 bits
    }
  }
  for (int y = 0; y < depth_m.height; ++y) {
    for (int x = 0; x < depth_m.width; ++x) {
      const int u = depth_m.height - 1 - y;
      EXPECT_EQ(confidence.at(u, x), valid.at(x, y));
      if (valid.at(x, y) != 1) continue;
      // 8 bits of inverse depth: half a step is 1 / (2 * 255) of 1 / 0.2 - 1 / 100 per meter
      EXPECT_NEAR((100 - 99.8 * depth.at(u, x)) / 20, 1 / depth_m.at(x, y), 0.51 / 255 * (5 - 0.01));
    }
  }
  EXPECT_EQ(read_image(train + "scaled_images/000001/result_scaled_image_center.jpg").width, depth_m.height);
  std::filesystem::remove_all(set + "/samples/000000");
  EXPECT_EQ(merge_samples(set).size(), 1U);
  EXPECT_FALSE(std::filesystem::exists(train + "merged_conf/000000"));
  EXPECT_TRUE(std::filesystem::exists(train + "merged_conf/000001"));
  recipe["set"]["sensor.dp_downsample_x"] = recipe["set"]["sensor.dp_downsample_y"] = 1;
  EXPECT_NE(message_of<InputError>([&] { make(folder / "dense", recipe); }).find("holds green views"),
            std::string::npos);
}

/// Names and bytes of a tar file's entries, in order, as GNU tar reads them.
std::vector<std::pair<std::string, std::string>> untar(const std::string& tar, const TemporaryFolder& folder) {
  const std::string to = folder / "untarred";
  std::filesystem::remove_all(to);
  std::filesystem::create_directories(to);
  EXPECT_EQ(std::system(("tar -xf '" + tar + "' -C '" + to + "' && tar -tf '" + tar + "' > '" + to + ".txt'").c_str()),
            0);
  std::vector<std::pair<std::string, std::string>> entries;
  std::ifstream names(to + ".txt");
  for (std::string name; std::getline(names, name);) entries.emplace_back(name, read_bytes(to + "/" + name));
  return entries;
}

TEST(SlowMerge, PacksWebDatasets) {
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  json recipe = small_recipe(3);
  recipe["split"] = {{"train", 0.5}, {"test", 0.5}};
  make(set, recipe);
  const std::vector<json> index = merge_samples(set);
  write_webdataset(index, set);
  EXPECT_EQ(write_webdataset(index, set, 1), 3);  // each of the three is more than a byte: a file each
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(set + "/webdataset")) {
    if (entry.path().extension() != ".tar") continue;
    const auto files = untar(entry.path(), folder);
    ASSERT_EQ(files.size(), 6U);
    const std::string name = files[0].first.substr(0, 6), sample = set + "/samples/" + name + "/";
    EXPECT_EQ(files[0].first, name + ".left.npy");
    EXPECT_TRUE(files[0].second == read_bytes(sample + "left.npy"));
    EXPECT_EQ(files[5].first, name + ".json");
    EXPECT_TRUE(files[5].second == read_bytes(sample + "sample.json"));
    const std::string split = json::parse(files[5].second)["line"]["split"];
    EXPECT_TRUE(entry.path().filename().string().starts_with(split + "-")) << entry.path();
    ++count;
  }
  EXPECT_EQ(count, 3);
}

/// OpenCV reads channels of other names as zeros, without a word.
TEST(SlowExr, IsReadByOpenCv) {
  if (std::system("/usr/bin/python3 -c 'import cv2' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-opencv is not installed";
  const TemporaryFolder folder;
  const std::string set = folder / "set";
  json recipe = small_recipe(1);
  recipe["layout"] = "exr";
  recipe["keep"] = {"depth_m", "normal"};
  make(set, recipe);
  const std::string sample = set + "/samples/000000/";
  const Image depth = read_exr(sample + "depth_m.exr", {"Y"})[0];
  const std::vector<Image> normal = read_exr(sample + "normal.exr", {"R", "G", "B"});
  std::string script =
      "import os\nos.environ['OPENCV_IO_ENABLE_OPENEXR'] = '1'\nimport cv2\n"
      "d = cv2.imread('" +
      sample +
      "depth_m.exr', cv2.IMREAD_UNCHANGED)\n"
      "n = cv2.imread('" +
      sample +
      "normal.exr', cv2.IMREAD_UNCHANGED)\n"
      "print(repr(float(d.reshape(48, 64, -1)[30, 40, 0])), *[repr(float(v)) for v in n[30, 40]])\n";
  write_bytes(folder / "read.py", script);
  ASSERT_EQ(std::system(("/usr/bin/python3 '" + (folder / "read.py") + "' > '" + (folder / "out") + "'").c_str()), 0);
  double d = 0, bgr[3] = {};
  std::ifstream(folder / "out") >> d >> bgr[0] >> bgr[1] >> bgr[2];
  EXPECT_EQ(static_cast<float>(d), depth.at(40, 30));
  for (int c = 0; c < 3; ++c) EXPECT_EQ(static_cast<float>(bgr[2 - c]), normal[static_cast<std::size_t>(c)].at(40, 30));
  EXPECT_GT(depth.at(40, 30), 0);
}

}  // namespace
}  // namespace dualpixel::datasets
