#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/metrics/score_people.h"
#include "pipeline/portrait/result_io.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/pipeline/segmentation/toy_network.h"
#include "tests/pipeline/texture.h"
#include "tests/scenes/people/toy_people.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

TEST(MaskMetrics, AreTheirFormulas) {
  Image a(8, 4), b(8, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      a.at(x, y) = x < 4 ? 1 : 0;            // the left half
      b.at(x, y) = x >= 2 && x < 6 ? 1 : 0;  // the middle half
    }
  }
  EXPECT_EQ(evaluation::mask_iou(a, b), 2.0 / 6);
  EXPECT_EQ(evaluation::mask_iou(a, a), 1);
  EXPECT_EQ(evaluation::mask_iou(Image(8, 4), Image(8, 4)), 1);
  EXPECT_EQ(evaluation::mask_iou(a, Image(8, 4)), 0);
  EXPECT_EQ(evaluation::mask_gradient_error(a, Image(8, 4)), 1.0 / 8);  // one step of 1 in each row of 8
  EXPECT_EQ(evaluation::mask_gradient_error(a, b), 3.0 / 8);            // and two more
  EXPECT_EQ(evaluation::mask_gradient_error(Image(8, 4, 1, 0.7F), Image(8, 4)), 0);
}

/// A held-out set of two: gray pictures whose masks are what the toy network draws, but for two squares in the second:
/// one of 10 x 10 beside the right wrist, and one of 6 x 6 over the head. The second is a composite with another
/// person, and holds something.
void write_followed(const std::string& folder) {
  constexpr std::size_t kSide = scenes::kPictureSide_px, n = 2;
  scenes::PeopleArrays arrays;
  arrays.faces = {100, 60, 30, 30, 50, 90, 40, 40};
  arrays.pictures.assign(n * kSide * kSide * 3, 0x80);
  arrays.masks.resize(n * kSide * kSide);
  arrays.keypoints.resize(n * scenes::kKeypoints * 3);
  pipeline::PersonNetwork network(pipeline::face_follower());
  for (std::size_t i = 0; i < n; ++i) {
    const float* const f = arrays.faces.data() + 4 * i;
    const Image drawn = network(pipeline::network_input(Image(kSide, kSide, 3, 0.2F), {f[0], f[1], f[2], f[3]}));
    for (std::size_t p = 0; p < drawn.data.size(); ++p) {
      arrays.masks[i * kSide * kSide + p] = static_cast<std::uint8_t>(std::lround(255 * drawn.data[p]));
    }
  }
  const auto square = [&](std::size_t x0, std::size_t y0, std::size_t size) {
    for (std::size_t y = y0; y < y0 + size; ++y) {
      for (std::size_t x = x0; x < x0 + size; ++x) arrays.masks[(kSide + y) * kSide + x] = 255;
    }
  };
  square(200, 200, 10);
  square(20, 60, 6);
  const float wrist[3] = {205, 205, 2};
  std::copy_n(wrist, 3, arrays.keypoints.begin() + (scenes::kKeypoints + 10) * 3);
  arrays.samples_json = R"([{"people": 1, "composite": false, "tags": ["hair:long"], "seed": 1},)"
                        R"( {"people": 2, "composite": true, "tags": ["hair:long", "held:cup"], "seed": 2}])";
  scenes::write_people_arrays(folder, arrays, 1, true);
}

TEST(PeopleScores, AreTheirFormulas) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  const TemporaryFolder folder;
  write_followed(folder / "set");
  const scenes::PeopleSet set({folder / "set"}, true);
  pipeline::PersonNetwork network(pipeline::face_follower());
  const evaluation::PeopleScores scores = evaluation::score_people(set, network);
  const auto row = [&](const std::string& name) {
    for (const auto* rows : {&scores.samples, &scores.regions}) {
      for (const evaluation::PeopleRow& r : *rows) {
        if (r.name == name) return r;
      }
    }
    ADD_FAILURE() << name;
    return evaluation::PeopleRow();
  };
  int drawn = 0;
  for (int i = 0; i < 256 * 256; ++i) drawn += set[1].mask[i] > 127 ? 1 : 0;
  const double second = (drawn - 136.0) / drawn;
  // The squares' outlines are 40 and 24 steps of 1. What else there is comes of masks in 255ths: at most half a one,
  // squared, in both directions.
  constexpr double kStep = 2 * 1.0 / (255 * 255), kArea = 256 * 256;
  EXPECT_DOUBLE_EQ(row("rendered").iou, 1);
  EXPECT_DOUBLE_EQ(row("one person").iou, 1);
  EXPECT_NEAR(row("rendered").gradient_error, 0, kStep);
  for (const char* name : {"composites", "groups", "held:cup"}) {
    EXPECT_EQ(row(name).samples, 1U);
    EXPECT_DOUBLE_EQ(row(name).iou, second);
    EXPECT_NEAR(row(name).gradient_error, 64 / kArea, kStep);
  }
  for (const char* name : {"all", "hair:long"}) {
    EXPECT_EQ(row(name).samples, 2U);
    EXPECT_DOUBLE_EQ(row(name).iou, (1 + second) / 2);
    EXPECT_NEAR(row(name).iou_error, (1 - second) / 2, 1e-12);  // of two draws: half of what they differ by
    EXPECT_EQ(row(name).iou_without_face, 0);                   // the toy network ignores the picture
    EXPECT_NEAR(row(name).gradient_error, 32 / kArea, kStep);
  }
  // From a face's width around the boxes down to the chin: 90 x 60 and 120 x 80 pixels, but for those left of 0.
  EXPECT_NEAR(row("hair").gradient_error, 24.0 / (90 * 60 + 120 * 80), kStep);
  // A hand is a disc of 0.75 * 40 px: its area in pixels within its outline's length of the exact one.
  const double disc = M_PI * 30 * 30;
  for (const char* name : {"hands", "hands that hold"}) {
    EXPECT_EQ(row(name).samples, 1U);
    EXPECT_NEAR(row(name).gradient_error, 40 / disc, 40 / disc * (2 * M_PI * 30 / disc) + kStep);
  }
  ASSERT_EQ(scores.filtered_iou.size(), 2U);
  EXPECT_DOUBLE_EQ(row("all").filtered_iou, (scores.filtered_iou[0] + scores.filtered_iou[1]) / 2);
  EXPECT_DOUBLE_EQ(scores.filtered_iou[1],
                   evaluation::mask_iou(evaluation::filtered_mask_of(set[1], network), evaluation::mask_of(set[1])));
  EXPECT_DOUBLE_EQ(
      row("groups").filtered_gradient_error,
      evaluation::mask_gradient_error(evaluation::filtered_mask_of(set[1], network), evaluation::mask_of(set[1])));

  EXPECT_TRUE(std::isnan(row("groups").iou_error));  // one draw says nothing of its error
  // Another two samples of the same two scenes, with the same scores, do not reduce the standard error.
  const evaluation::PeopleScores twice =
      evaluation::score_people(scenes::PeopleSet({folder / "set", folder / "set"}, true), network);
  EXPECT_EQ(twice.samples.front().samples, 4U);
  EXPECT_NEAR(twice.samples.front().iou_error, row("all").iou_error, 1e-12);
}

/// A linear picture as an 8-bit file.
void write_picture(const std::string& path, Image picture) {
  for (float& value : picture.data) value = srgb_from_linear(value);
  write_png8(path, picture);
}

class SlowSegmentationExperiment : public testing::Test {
 protected:
  SlowSegmentationExperiment() {
    std::filesystem::create_directory(folder / "images");
    std::filesystem::create_directory(folder / "masks");
    write_bytes(folder / "toy.safetensors", pipeline::as_safetensors(pipeline::face_follower()));
  }
  Outcome run() {
    return run_command("experiment segmentation --images '" + (folder / "images") + "' --masks '" + (folder / "masks") +
                       "' --weights '" + (folder / "toy.safetensors") + "' -o '" + (folder / "out") + "'");
  }
  TemporaryFolder folder;
};

TEST_F(SlowSegmentationExperiment, ScoresWhatItFinds) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without";
  Image picture(640, 480, 3, 0.2F), truth(640, 480);
  pipeline::draw_face(picture, 300, 220, 160);
  const pipeline::Face face = pipeline::find_faces(picture).at(0);
  // The toy's mask: where the Gaussian of sigma 21 px of 256 is above a half.
  const double radius = 21 * std::sqrt(2 * std::log(2.0)) * 640 / 256;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const double dx = x + 0.5 - face.x - face.width / 2, dy = y + 0.5 - face.y - face.height / 2;
      truth.at(x, y) = std::hypot(dx, dy) < radius ? 1 : 0;
    }
  }
  write_picture(folder / "images/face.png", picture);
  write_png8(folder / "masks/face.png", truth);
  write_picture(folder / "images/wall.png", Image(64, 48, 3, 0.2F));
  write_png8(folder / "masks/wall.png", Image(64, 48, 1, 1));
  const Outcome outcome = run();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("mean IoU, 2 pictures"), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(read_bytes(folder / "out/segmentation.json"));
  EXPECT_EQ(json["count"], 2);
  EXPECT_EQ(json["without_face"], 1);
  // A disc of radius 25 px that lies half a pixel off has 1 - 2 / (pi * 25) = 97 % of itself in common; twice that off
  // in both directions: the network's pixels are pairs.
  EXPECT_GT(json["mean_iou_where_found"], 0.92);
  EXPECT_NEAR(json["mean_iou"].get<double>(), json["mean_iou_where_found"].get<double>() / 2, 1e-9);
  EXPECT_NE(read_bytes(folder / "out/segmentation.html").find("wall"), std::string::npos);
  const nlohmann::json &face_png = json["pictures"][0], &wall_png = json["pictures"][1];
  for (const nlohmann::json* each : {&face_png, &wall_png}) EXPECT_GT(each->at("find_cpu_ms"), 0);
  EXPECT_EQ(json["median_find_cpu_ms"], std::max(face_png["find_cpu_ms"], wall_png["find_cpu_ms"]));
  EXPECT_EQ(wall_png["faces"], 0);
  EXPECT_TRUE(face_png.contains("gradient_error"));
  EXPECT_FALSE(wall_png.contains("gradient_error"));  // of no mask
}

// Both layouts in which the set goes round; faces.json moves the toy network's disc.
TEST_F(SlowSegmentationExperiment, PortraitsHaveThePapersTable) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  Image picture(256, 256, 3, 0.2F), truth(256, 256);
  pipeline::draw_face(picture, 120, 100, 70);
  const double radius = 21 * std::sqrt(2 * std::log(2.0));  // where the toy's Gaussian is above a half
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) truth.at(x, y) = std::hypot(x + 0.5 - 60, y + 0.5 - 180) < radius ? 1 : 0;
  }
  Image of_255ths = truth;
  for (float& value : of_255ths.data) value /= 255;
  const auto run_set = [&](const std::string& set) {
    return run_command("experiment segmentation --portraits '" + (folder / set) + "' --weights '" +
                       (folder / "toy.safetensors") + "'");
  };
  const auto write_set = [&](const std::string& pictures, const std::string& masks, const std::string& mask_suffix,
                             const Image& mask) {
    for (const std::string& name : {pictures, masks}) std::filesystem::create_directories(folder / name);
    for (const char* name : {"00001", "00002"}) {
      write_picture(folder / (pictures + "/" + name + ".png"), picture);
      write_png8(folder / (masks + "/" + name + mask_suffix + ".png"), mask);
    }
  };
  write_set("a/Images", "a/Labels", "", of_255ths);
  write_bytes(folder / "a/faces.json", R"({"00001": [50, 170, 20, 20], "00002": [50, 170, 20, 20]})");
  write_set("b/images_data_crop", "b/GT_png", "_mask", truth);
  write_bytes(folder / "b/eg1800_test.txt", "00002.png\r\n");
  write_bytes(folder / "b/faces.json", R"({"00002": [50, 170, 20, 20]})");
  const Outcome found = run_set("a"), given = run_set("b");
  EXPECT_EQ(found.status, 0) << found.err;
  EXPECT_EQ(given.status, 0) << given.err;
  EXPECT_NE(found.out.find("PortraitFCN+ (Shen et al. 2016)"), std::string::npos);
  const auto row = [&](const Outcome& outcome, const std::string& name) {
    std::istringstream line(outcome.out.substr(outcome.out.find(name) + name.size()));
    std::string that, of, weights, percent;
    double iou = 0, count = 0;
    line >> that >> of >> weights >> iou >> percent >> count;
    return std::pair{iou, count};
  };
  EXPECT_EQ(row(found, "dualpixel, faces found "), (std::pair{0.0, 2.0}));  // the drawn face is elsewhere
  // A disc of radius 25 px of pixels in pairs has 96 % in common with one of single pixels.
  EXPECT_EQ(row(found, "dualpixel, faces given ").second, 2);
  EXPECT_EQ(row(given, "dualpixel, faces given ").second, 1);
  for (const Outcome* outcome : {&found, &given}) EXPECT_GT(row(*outcome, "dualpixel, faces given ").first, 94);

  for (const char* box : {"[50, 170, 0, 20]", "[5000, 0, 10, 10]", "7"}) {
    write_bytes(folder / "b/faces.json", std::string(R"({"00002": )") + box + "}");
    const Outcome no_box = run_set("b");
    expect_one_line_refusal(no_box);
    EXPECT_NE(no_box.err.find("faces.json: /00002"), std::string::npos) << no_box.err;
  }
  write_bytes(folder / "b/faces.json", "{}");
  expect_one_line_refusal(run_set("b"));
  for (const char* list : {"00003\n", "00002\n00002.png\n", " \n"}) {
    write_bytes(folder / "b/eg1800_test.txt", list);
    expect_one_line_refusal(run_set("b"));
  }
  expect_one_line_refusal(run_set("masks"));
}

TEST_F(SlowSegmentationExperiment, WithoutAnyFaceThereIsNoMeanOfThoseFound) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without";
  write_picture(folder / "images/wall.png", Image(64, 48, 3, 0.2F));
  write_png8(folder / "masks/wall.png", Image(64, 48, 1, 1));
  const Outcome outcome = run();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("no face was found"), std::string::npos);
  EXPECT_EQ(outcome.out.find("gradient error"), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(read_bytes(folder / "out/segmentation.json"));
  EXPECT_EQ(json["mean_iou"], 0);
  for (const char* name : {"mean_iou_where_found", "gradient_error"}) EXPECT_FALSE(json.contains(name)) << name;
}

TEST_F(SlowSegmentationExperiment, ScoresPeopleSets) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  write_followed(folder / "set");
  const std::string command = "experiment segmentation --weights '" + (folder / "toy.safetensors") + "' ";
  const Outcome outcome = run_command(command + "--people '" + (folder / "set") + "' -o '" + (folder / "out") + "'");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("near hands that hold"), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(read_bytes(folder / "out/segmentation.json"));
  EXPECT_EQ(json["samples"][0]["name"], "all");
  EXPECT_EQ(json["samples"][0]["samples"], 2);
  EXPECT_NE(read_bytes(folder / "out/segmentation.html").find("held:cup"), std::string::npos);
  for (const std::string& bad :
       {std::string(), "--images '" + (folder / "images") + "'",
        "--people '" + (folder / "set") + "' --images x --masks x", "--people '" + (folder / "images") + "'"}) {
    expect_one_line_refusal(run_command(command + bad));
  }
}

TEST_F(SlowSegmentationExperiment, UnusableFoldersAreOneClearLine) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  expect_one_line_refusal(run());  // no pictures
  write_picture(folder / "images/a.png", Image(64, 48, 3, 0.2F));
  const Outcome no_mask = run();
  expect_one_line_refusal(no_mask);
  EXPECT_NE(no_mask.err.find("holds no mask of that name"), std::string::npos);
  write_png8(folder / "masks/a.png", Image(48, 64, 1, 1));
  const Outcome other_size = run();
  expect_one_line_refusal(other_size);
  EXPECT_NE(other_size.err.find("48 x 64 pixels"), std::string::npos);
  write_bytes(folder / "toy.safetensors", "nothing");
  expect_one_line_refusal(run());
  std::filesystem::remove_all(folder / "masks");
  expect_one_line_refusal(run());
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

/// Two views of the same, with a face where asked for.
std::string write_pair(const TemporaryFolder& folder, bool with_face) {
  Image picture = pipeline::Texture(5, 0.02).raster(320, 240, 0.5, 1, 0.5, 1);
  Image rgb(320, 240, 3);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = 0.25F * (1 + 0.3F * picture.data[i / 3]);
  if (with_face) pipeline::draw_face(rgb, 150, 110, 90);
  write_picture(folder / "l.png", rgb);
  write_picture(folder / "r.png", rgb);
  return "portrait --left '" + (folder / "l.png") + "' --right '" + (folder / "r.png") + "' -o '" + (folder / "out") +
         "' ";
}

TEST(SlowPortraitPeople, FacesOutsideThePictureAreRefused) {
  const TemporaryFolder folder;
  const std::string portrait = write_pair(folder, false);
  for (const char* bad : {"--face 1,2,3", "--face 400,10,20,20", "--face nan,1,2,3", "--tap -1,2"}) {
    expect_one_line_refusal(run_command(portrait + bad));
  }
}

bool has_trained_network() {
  try {
    pipeline::built_in_weights();
  } catch (const InputError&) {
    return false;
  }
  return pipeline::has_person_network();
}

TEST(SlowPortraitPeople, AreFoundWithoutAMask) {
  if (!has_trained_network()) GTEST_SKIP() << "built without";
  const auto result_of = [](const std::string& arguments, const TemporaryFolder& folder, bool warns) {
    const Outcome outcome = run_command(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("no face found") != std::string::npos, warns) << outcome.err;
    return nlohmann::json::parse(read_bytes(folder / "out/result.json"))["provenance"];
  };
  const TemporaryFolder folder;
  const std::string portrait = write_pair(folder, true);
  const nlohmann::json found = result_of(portrait + "--mode seg", folder, false);
  EXPECT_EQ(found["mode"], "seg");
  EXPECT_EQ(found["mask"], "found");
  EXPECT_EQ(found["person_weights_hash"],
            file_hash(DUALPIXEL_SOURCE_DIR "/pipeline/segmentation/weights/person.safetensors"));
  ASSERT_EQ(found["faces_px"].size(), 1U);
  EXPECT_NEAR(found["faces_px"][0][0].get<double>() + found["faces_px"][0][2].get<double>() / 2, 150, 12);
  // what the user points at wins, a face before a tap
  const nlohmann::json pointed = result_of(portrait + "--mode dp+seg --face 20,30,40,50 --tap 200,100", folder, false);
  EXPECT_EQ(pointed["faces_px"], nlohmann::json::parse("[[20,30,40,50]]"));
  EXPECT_EQ(result_of(portrait + "--mode dp+seg --split vertical --face 20,30,40,50", folder, false)["faces_px"],
            nlohmann::json::parse("[[20,30,40,50]]"));

  EXPECT_EQ(found["person_network"], "f32");
  expect_one_line_refusal(run_command(portrait + "--mode dp --bf16"));

  const nlohmann::json no_face = result_of(write_pair(folder, false) + "--mode dp+seg", folder, true);
  EXPECT_EQ(no_face["mode"], "dp");
  EXPECT_FALSE(no_face.contains("mask"));
}

TEST(SlowPortraitPeople, ATapOnAWallFindsNobody) {
  if (!has_trained_network()) GTEST_SKIP() << "built without";
  const TemporaryFolder folder;
  const auto result_of = [&](bool with_face) {
    const Outcome outcome = run_command(write_pair(folder, with_face) + "--mode dp+seg --tap 150,110");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    nlohmann::json provenance = nlohmann::json::parse(read_bytes(folder / "out/result.json"))["provenance"];
    EXPECT_EQ(outcome.err.find("no person found at the tap") == std::string::npos, provenance["mode"] == "dp+seg");
    return provenance;
  };
  const nlohmann::json wall = result_of(false);
  EXPECT_EQ(wall["mode"], "dp");
  EXPECT_FALSE(wall.contains("mask"));
  const nlohmann::json face = result_of(true);
  EXPECT_EQ(face["mode"], "dp+seg");
  ASSERT_EQ(face["faces_px"].size(), 1U);
  EXPECT_NEAR(face["faces_px"][0][0].get<double>() + face["faces_px"][0][2].get<double>() / 2, 150, 12);
}

TEST(SlowPortraitPeople, MasksHaveTheShapeOfThePictureAndAreNotEmpty) {
  const TemporaryFolder folder;
  const std::string portrait = write_pair(folder, true) + "--mode dp+seg --mask '" + (folder / "mask.png") + "'";
  const Image picture = read_image(folder / "l.png");
  const auto with_mask = [&](int width, int height, float value) {
    Image mask(width, height, 3);
    for (float& m : mask.data) m = value;
    write_png8(folder / "mask.png", mask);
    return run_command(portrait);
  };
  const int width = picture.width, height = picture.height;
  expect_one_line_refusal(with_mask(width, height * 3 / 2, 1));
  EXPECT_EQ(with_mask(width / 2, height / 2, 1).err.find("mask"), std::string::npos);
  const Outcome empty = with_mask(width, height, 0.9f);
  EXPECT_EQ(empty.status, 0);
  EXPECT_NE(empty.err.find("the person mask has no pixel above 0.94"), std::string::npos) << empty.err;
  EXPECT_NE(empty.err.find("nothing is blurred"), std::string::npos) << empty.err;  // in a picture so small
  EXPECT_EQ(pipeline::read_result(folder / "out").json["provenance"]["warnings"].size(), 2u);

  const auto of_views = [&](int view_width, int view_height, const std::string& options) {
    for (const char* view : {"l.png", "r.png"}) write_png8(folder / view, Image(view_width, view_height, 3, 0.5f));
    return run_command(portrait + options);
  };
  write_png8(folder / "mask.png", Image(33, 64, 3, 1.0f));
  EXPECT_EQ(of_views(33, 64, "").status, 0);  // pairs are made even
  write_png8(folder / "mask.png", Image(300, 200, 3, 1.0f));
  const Outcome lying = of_views(200, 300, " --split vertical");
  EXPECT_NE(lying.err.find("300 x 200 pixels; must have the shape of the picture, 200 x 300"), std::string::npos)
      << lying.err;
}

// In programs of their own: a process that has run the network in f32 keeps to AVX2.
TEST(SlowPortraitPeople, SixteenBitFloatsFindTheSame) {
  if (!has_trained_network()) GTEST_SKIP() << "built without";
  const TemporaryFolder folder;
  const std::string portrait = write_pair(folder, true) + "--mode dp+seg --face 105,65,90,90 ";
  const auto mask_of = [&](const std::string& option) {
    const Outcome outcome = run_command(portrait + option);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return pipeline::read_result(folder / "out").result.mask;
  };
  const Image mask = mask_of("");
  if (!__builtin_cpu_supports("avx512bw")) {
    expect_one_line_refusal(run_command(portrait + "--bf16"));
    return;
  }
  const Image rounded = mask_of("--bf16");
  ASSERT_TRUE(rounded.same_size(mask));
  double sum = 0, difference = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    sum += mask.data[i];
    difference += std::abs(mask.data[i] - rounded.data[i]);
  }
  EXPECT_GT(sum, 0.01 * static_cast<double>(mask.data.size()));
  EXPECT_LT(difference, 0.01 * sum);
  EXPECT_GT(difference, 0);
}

}  // namespace
}  // namespace dualpixel::tools
