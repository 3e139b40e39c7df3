#include "evaluation/study/study.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "evaluation/study/crops.h"
#include "evaluation/study/votes.h"
#include "pipeline/portrait/result_io.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kPictureWidth = 600, kPictureHeight = 400;

/// Pictures that differ in squares of 20 pixels around these places, the first most.
std::vector<Image> pictures_that_differ_at(const std::vector<std::pair<int, int>>& places) {
  std::vector<Image> pictures(3, Image(kPictureWidth, kPictureHeight, 3, 0.5f));
  float difference = 0.3f;
  for (const auto& [x, y] : places) {
    for (int dy = -10; dy < 10; ++dy) {
      for (int dx = -10; dx < 10; ++dx) pictures[1].at(x + dx, y + dy, 1) += difference;
    }
    difference /= 2;
  }
  return pictures;
}

bool holds(const Crop& crop, int x, int y) {
  return x - 10 >= crop.x && y - 10 >= crop.y && x + 10 <= crop.x + crop.side && y + 10 <= crop.y + crop.side;
}

TEST(StudyCrops, AreWherePicturesDifferMostAndDoNotOverlap) {
  const std::vector<Crop> crops = crops_that_differ(pictures_that_differ_at({{540, 60}, {60, 340}, {60, 40}}), {});
  ASSERT_EQ(crops.size(), 3U);
  EXPECT_TRUE(holds(crops[0], 540, 60));
  EXPECT_TRUE(holds(crops[1], 60, 340));
  EXPECT_TRUE(holds(crops[2], 60, 40));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(crops[i].side, 128);
    const Crop &a = crops[i], &b = crops[(i + 1) % 3];
    EXPECT_TRUE(std::abs(a.x - b.x) >= 128 || std::abs(a.y - b.y) >= 128);
  }
}

TEST(StudyCrops, LieOnTheOutlineWhereThereIsAPerson) {
  Image mask(kPictureWidth, kPictureHeight);
  for (int y = 150; y < kPictureHeight; ++y) {
    for (int x = 0; x < 200; ++x) mask.at(x, y) = 1;
  }
  // far from the outline; near it
  const std::vector<Crop> crops = crops_that_differ(pictures_that_differ_at({{340, 30}, {100, 160}}), mask);
  EXPECT_TRUE(holds(crops.at(0), 100, 160));
  for (const Crop& crop : crops) {
    const Image part = cropped(mask, crop);
    EXPECT_NE(*std::max_element(part.data.begin(), part.data.end()),
              *std::min_element(part.data.begin(), part.data.end()));
  }
  // nobody: anywhere
  EXPECT_TRUE(holds(crops_that_differ(pictures_that_differ_at({{340, 30}}), Image(kPictureWidth, kPictureHeight)).at(0),
                    340, 30));
}

TEST(StudyCrops, AreAsLargeAsFit) {
  const std::vector<Crop> crops = crops_that_differ({Image(200, 40, 3, 0.1f), Image(200, 40, 3, 0.2f)}, {});
  ASSERT_EQ(crops.size(), 3U);
  EXPECT_EQ(crops[0].side, 40);
}

/// A study of so many methods and scenes whose pictures are stored in the methods' order.
Study plain_study(int methods, int scenes) {
  Study study{"0123456789abcdef", {}, {}};
  std::vector<int> order;
  for (int i = 0; i < methods; ++i) {
    study.methods.push_back("m" + std::to_string(i));
    order.push_back(i);
  }
  for (int i = 0; i < scenes; ++i) study.scenes.push_back({"s" + std::to_string(i), order});
  return study;
}

/// All others lose to `winner`, one after the other.
Votes::Scene scene_won_by(int winner, int methods, int scene) {
  Votes::Scene won{scene, {}};
  for (int other = 0; other < methods; ++other) {
    if (other != winner) won.comparisons.push_back({other, winner, winner});
  }
  return won;
}

// Wadhwa et al. 2018, Table 3: six participants, five methods, 64 scenes.
TEST(StudyVotes, AreCountedAsInThePapersTable) {
  const std::vector<std::vector<int>> table = {{0, 2, 0, 0, 0, 0},
                                               {7, 6, 9, 3, 0, 7},
                                               {10, 11, 16, 15, 14, 8},
                                               {13, 22, 17, 19, 18, 22},
                                               {34, 23, 22, 27, 32, 27}};
  const std::vector<double> mean = {0.3, 5.3, 12.3, 18.5, 27.5}, deviation = {0.8, 3.3, 3.1, 3.4, 4.8};
  std::vector<Votes> votes;
  for (int participant = 0; participant < 6; ++participant) {
    Votes own{std::string(1, static_cast<char>('A' + participant)), {}};
    for (int method = 0; method < 5; ++method) {
      for (int i = 0; i < table[method][participant]; ++i) {
        own.scenes.push_back(scene_won_by(method, 5, static_cast<int>(own.scenes.size())));
      }
    }
    ASSERT_EQ(own.scenes.size(), 64U);
    votes.push_back(own);
  }
  const VoteTable counted = count_votes(plain_study(5, 64), votes);
  for (int method = 0; method < 5; ++method) {
    EXPECT_EQ(counted.rows[method].votes, table[method]);
    EXPECT_NEAR(counted.rows[method].mean, mean[method], 0.05001);
    EXPECT_NEAR(counted.rows[method].deviation, deviation[method], 0.05001);
  }
  EXPECT_EQ(counted.rows[4].preferred, 4 * (34 + 23 + 22 + 27 + 32 + 27));
}

TEST(StudyVotes, BelongToTheMethodWhosePictureWasChosen) {
  Study study = plain_study(3, 1);
  study.scenes[0].method_of_picture = {2, 0, 1};
  const VoteTable counted = count_votes(study, {{"A", {{0, {{1, 0, 0}, {2, 0, 2}}}}}});
  EXPECT_EQ(counted.rows[1].votes[0], 1);
  EXPECT_EQ(counted.rows[2].preferred, 1);
  EXPECT_EQ(counted.rows[2].shown, 2);
  EXPECT_EQ(counted.rows[0].shown, 1);
}

TEST(StudyVotes, AreRefusedWhereTheyAreNoneOfTheStudys) {
  const TemporaryFolder folder;
  const Study study = plain_study(3, 2);
  const auto message = [&](const std::string& scenes, const std::string& id = "0123456789abcdef") {
    write_bytes(folder / "v.json", R"({"format": "dualpixel votes", "version": 1, "study": ")" + id +
                                       R"(", "participant": "A", "scenes": )" + scenes + "}");
    return message_of<InputError>([&] { read_votes(folder / "v.json", study); });
  };
  EXPECT_EQ(message(R"([{"scene": 1, "comparisons": [[0, 1, 1], [1, 2, 2]]},
                        {"scene": 0, "comparisons": [[2, 1, 1], [1, 0, 0]]}])"),
            "");
  EXPECT_NE(message("[]", "ffff").find("/study: \"ffff\": must be \"0123456789abcdef\""), std::string::npos);
  const std::pair<const char*, const char*> bad[] = {
      {R"([{"scene": 2, "comparisons": []}])", "must be an integer in [0, 1]"},
      {R"([{"scene": 0, "comparisons": [[0, 1, 1]]}])", "1: must be 2, one less"},
      {R"([{"scene": 0, "comparisons": [[0, 1, 2], [1, 2, 2]]}])", "must be two pictures and the preferred one"},
      {R"([{"scene": 0, "comparisons": [[0, 1, 1], [0, 2, 2]]}])", "must show picture 1"},
      {R"([{"scene": 0, "comparisons": [[0, 1, 1], [1, 0, 1]]}])", "not shown yet"},
      {R"([{"scene": 0, "comparisons": [[0, 1], [1, 2, 2]]}])", "[0,1]: must be three integers in [0, 2]"},
      {R"([{"scene": 0, "comparisons": [[0, 3, 3], [3, 2, 2]]}])", "must be three integers in [0, 2]"},
      {R"([{"scene": 0, "comparisons": [[0, 1, 1], [1, 2, 2]]}, {"scene": 0, "comparisons": [[0, 1, 1], [1, 2, 2]]}])",
       "is there twice"},
      {"[]", "/scenes: 0: must be 2, all of the study's"},
      {R"([{"scene": 0, "comparisons": {"x": [0, 1, 1]}}])", "/comparisons: must be an array"}};
  for (const auto& [scenes, part] : bad) EXPECT_NE(message(scenes).find(part), std::string::npos) << message(scenes);
}

void write_portrait(const std::string& folder, float level, int width = 160) {
  pipeline::PortraitResult result;
  result.input = result.portrait = result.portrait_srgb = Image(width, 140, 3, level);
  result.disparity_dp_px = result.confidence = result.blur_radius_px = Image(width, 140, 1, 0.5f);
  result.matched_disparity_dp_px = result.matched_confidence = Image(width / 2, 70, 1, 0.5f);
  pipeline::write_result(result, {{"mode", "dp"}}, folder);
}

TEST(Study, PageHoldsPicturesAndNoNames) {
  const TemporaryFolder folder;
  for (const char* scene : {"apple", "pear"}) {
    write_portrait(folder / "a" + std::string("/") + scene, 0.2f);
    write_portrait(folder / "b" + std::string("/") + scene, 0.6f);
  }
  const std::vector<MethodFolder> methods = {{"methodA", folder / "a"}, {"methodB", folder / "b"}};
  const StudyFiles files = make_study(methods, 3);
  EXPECT_EQ(files.study.methods, (std::vector<std::string>{"methodA", "methodB"}));
  ASSERT_EQ(files.study.scenes.size(), 2U);
  EXPECT_EQ(files.study.scenes[1].name, "pear");
  for (const char* secret : {"methodA", "methodB", "apple", "pear", "method_of_picture"}) {
    EXPECT_EQ(files.page_html.find(secret), std::string::npos) << secret;
  }
  EXPECT_EQ(make_study(methods, 3).page_html, files.page_html);
  write_bytes(folder / "study.json", to_json(files.study).dump());
  const Study read = read_study(folder / "study.json");
  EXPECT_EQ(read.id, files.study.id);
  EXPECT_EQ(read.scenes[0].method_of_picture, files.study.scenes[0].method_of_picture);

  const auto message = [&] { return message_of<InputError>([&] { make_study(methods, 3); }); };
  write_portrait(folder / "b/pear", 0.6f, 170);
  EXPECT_NE(message().find("b/pear: 170 x 140 pixels; must be 160 x 140"), std::string::npos) << message();
  std::filesystem::remove_all(folder / "b/pear");
  EXPECT_NE(message().find("b: lacks 'pear'"), std::string::npos) << message();
}

}  // namespace
}  // namespace dualpixel::evaluation
