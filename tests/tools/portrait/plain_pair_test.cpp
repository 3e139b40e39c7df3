#include "pipeline/portrait/plain_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "capture/json_fields.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "pipeline/calibration/calibration.h"
#include "pipeline/calibration/nodes.h"
#include "pipeline/portrait/result_io.h"
#include "tests/pipeline/ramp_pair.h"
#include "tests/pipeline/texture.h"
#include "tests/shared_folder.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

/// 8-bit sRGB file of a linear signal.
void write_view(const std::string& path, Image view) {
  for (float& value : view.data) value = srgb_from_linear(value);
  write_png8(path, view);
}

TEST(PlainPair, ViewsAreLinearLightAndThePictureTheirMean) {
  const TemporaryFolder folder;
  Image left(3, 3, 3, 0.1f), right(3, 3, 3, 0.2f);
  left.at(2, 1, 0) = 0.5f;
  write_view(folder / "l.png", left);
  write_view(folder / "r.png", right);
  const pipeline::PlainPairCapture pair =
      pipeline::read_plain_pair({.left = folder / "l.png", .right = folder / "r.png"});
  const Capture& capture = pair.capture;
  const Image& picture = pair.picture;
  EXPECT_EQ(capture.camera.width_px, 4);  // odd sides are made even by their last row and column
  EXPECT_EQ(capture.camera.height_px, 4);
  const Frame& frame = capture.frames.at(0);
  // 8 bits of sRGB: half a step is 0.0018 at 0.1, 0.0028 at 0.2
  EXPECT_NEAR(frame.left.at(0, 0) / 65535.0, 0.1, 0.002);
  EXPECT_NEAR(frame.left.at(2, 1) / 65535.0, 0.1 + 0.4 / 4, 0.002);
  EXPECT_EQ(frame.left.at(3, 1), frame.left.at(2, 1));
  EXPECT_NEAR(frame.right.at(3, 3) / 65535.0, 0.2, 0.003);
  EXPECT_TRUE(frame.mosaic.empty());
  EXPECT_NEAR(picture.at(2, 1, 0), 0.35, 0.004);
  EXPECT_NEAR(picture.at(2, 1, 1), 0.15, 0.003);
  EXPECT_EQ(picture.at(3, 1, 0), picture.at(2, 1, 0));
  EXPECT_GT(capture.exposure.dp_noise.shot_dn, 0);
}

TEST(PlainPair, FilesThatDeclareLinearLightAreLinear) {
  const TemporaryFolder folder;
  for (const char* name : {"l.png", "r.png"}) write_png16(folder / name, ImageU16(4, 4, 1, 16384), false);
  pipeline::PlainPair files{.left = folder / "l.png", .right = folder / "r.png"};
  const pipeline::PlainPairCapture linear = pipeline::read_plain_pair(files);
  EXPECT_NEAR(linear.picture.at(1, 1), 0.25, 1e-4);
  EXPECT_EQ(linear.assumed, (std::vector<std::string>{"the views' noise is what they show", "the focus is at 1 m"}));
  write_bytes(folder / "m.json", R"({"encoding": "srgb", "noise": {"shot": 0, "read": 0}, "focus_distance_m": 2})");
  files.metadata = folder / "m.json";
  const pipeline::PlainPairCapture stated = pipeline::read_plain_pair(files);
  EXPECT_NEAR(stated.picture.at(1, 1), linear_from_srgb(0.25f), 1e-4);
  EXPECT_TRUE(stated.assumed.empty());
  write_png16(folder / "r.png", ImageU16(4, 4, 1, 16384), true);
  EXPECT_NEAR(pipeline::read_plain_pair(files).picture.at(1, 1), linear_from_srgb(0.25f), 1e-4);
  files.metadata = "";
  const std::string refusal = message_of<InputError>([&] { pipeline::read_plain_pair(files); });
  EXPECT_NE(refusal.find("r.png: does not declare linear light, unlike the left view"), std::string::npos) << refusal;
}

// Blurred parts get the noise of the picture that is shown, half of one view's in each of its colors.
TEST(PlainPair, ColoredPicturesHaveTheNoiseOfTheirColors) {
  constexpr double kSigma = 0.01, kMean = 0.3;
  const TemporaryFolder folder;
  write_bytes(folder / "m.json", R"({"encoding": "linear"})");
  std::mt19937 random(3);
  std::normal_distribution<double> normal(kMean, kSigma);
  for (const char* name : {"l.png", "r.png"}) {
    ImageU16 view(256, 192, 3);
    for (std::uint16_t& value : view.data) value = static_cast<std::uint16_t>(std::lround(65535 * normal(random)));
    write_png16(folder / name, view);
  }
  const Capture capture = pipeline::read_plain_pair({folder / "l.png", folder / "r.png", folder / "m.json"}).capture;
  // A quartile of 768 tiles of 64 pixels, each off by a quarter: 1.2 %, of which four
  EXPECT_NEAR(capture.exposure.mosaic_noise.shot_dn / 65535 * kMean / (kSigma * kSigma / 2), 1, 0.05);
}

TEST(PlainPair, MetadataSaysWhatTheNumbersMean) {
  const TemporaryFolder folder;
  write_png16(folder / "l.png", ImageU16(4, 4, 1, 16384));
  write_png16(folder / "r.png", ImageU16(4, 4, 1, 65535));
  write_bytes(folder / "m.json",
              R"({"encoding": "linear", "black_level": 0.125, "white_level": 0.75, "focus_distance_m": 0.7,
                  "noise": {"shot": 0.001, "read": 1e-6}, "face_px": [1, 0, 2, 3]})");
  const pipeline::PlainPair pair{folder / "l.png", folder / "r.png", folder / "m.json", true};
  const Capture capture = pipeline::read_plain_pair(pair).capture;
  EXPECT_NEAR(capture.frames[0].left.at(1, 2) / 65535.0, 0.2, 1e-4);  // (1/4 - 1/8) / (3/4 - 1/8)
  EXPECT_EQ(capture.frames[0].right.at(1, 2), 65535);
  EXPECT_NEAR(capture.exposure.dp_noise.shot_dn / 65535, 0.001, 1e-9);
  EXPECT_NEAR(capture.exposure.dp_noise.read_dn2 / 65535 / 65535, 1e-6, 1e-12);
  EXPECT_EQ(capture.camera.focus_distance_m, 0.7);
  EXPECT_EQ(*capture.face_px, (std::array<double, 4>{0, 1, 3, 2}));  // of the transposed picture
}

TEST(PlainPair, RefusesWhatCannotBeUsed) {
  const TemporaryFolder folder;
  write_view(folder / "a.png", Image(8, 8, 3, 0.5f));
  write_view(folder / "narrow.png", Image(7, 8, 3, 0.5f));
  write_view(folder / "single.png", Image(8, 8, 1, 0.5f));
  const Image plane(8, 8, 1, NAN);
  write_exr(folder / "a.exr", {{"Y", &plane}}, false);
  write_bytes(folder / "field.json", R"({"focus_distance": 1})");
  write_bytes(folder / "levels.json", R"({"black_level": 0.5, "white_level": 0.5})");
  const auto message = [&](const std::string& right, const std::string& metadata = "") {
    return message_of<InputError>([&] {
      pipeline::read_plain_pair({folder / "a.png", folder / right, metadata.empty() ? "" : folder / metadata});
    });
  };
  EXPECT_EQ(message("a.png"), "");
  EXPECT_NE(message("narrow.png").find("7 x 8"), std::string::npos) << message("narrow.png");
  EXPECT_NE(message("single.png").find("8 x 8 pixels in gr"), std::string::npos) << message("single.png");
  EXPECT_NE(message("a.exr").find("PNG, TIFF or JPEG"), std::string::npos);
  EXPECT_NE(message("none.png").find("none.png"), std::string::npos);
  EXPECT_NE(message("a.png", "field.json").find("focus_distance"), std::string::npos);
  EXPECT_NE(message("a.png", "levels.json").find("white_level"), std::string::npos);

  const std::string views = "--left '" + (folder / "a.png") + "' --right '" + (folder / "a.png") + "'";
  const std::set<std::string> before = folder.names();
  for (const std::string& arguments :
       {std::string(), "--left '" + (folder / "a.png") + "'", views + " '" + (folder / "a.png") + "'",
        "--left '" + (folder / "a.png") + "' --right '" + (folder / "narrow.png") + "'", views + " --split diagonal",
        std::string("--metadata x.json"), views + " --mode dp+seg --true-mask"}) {
    SCOPED_TRACE(arguments);
    expect_one_line_refusal(run_command("portrait " + arguments + " -o '" + (folder / "out") + "'"));
    EXPECT_EQ(folder.names(), before);
  }
}

/// The portrait of the views at `left` and `right`.
Image portrait_of(const TemporaryFolder& folder, const std::string& left, const std::string& right) {
  const Outcome outcome = run_command("portrait --mode dp --left '" + (folder / left) + "' --right '" +
                                      (folder / right) + "' -o '" + (folder / "out") + "'");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return read_image(folder / "out/portrait.png");
}

// Made into a mosaic and back, it would lose resolution.
TEST(SlowPlainPair, WhatIsInFocusStaysAsSharpAsItWas) {
  const TemporaryFolder folder;
  const Image view = pipeline::textured(pipeline::Texture(5, 0.2), 96, 96, 0);
  write_view(folder / "view.png", view);
  const Image before = read_image(folder / "view.png"), after = portrait_of(folder, "view.png", "view.png");
  ASSERT_EQ(after.channels, 3);
  for (std::size_t i = 0; i < after.data.size(); ++i) {
    ASSERT_NEAR(after.data[i], before.data[i / 3], 1.01 / 255) << i;  // both round
  }
}

// Neither a mosaic's speckle nor new noise colors it.
TEST(SlowPlainPair, GrayStaysGrayWhereItIsBlurred) {
  const TemporaryFolder folder;
  const pipeline::Texture texture(5, 0.2);
  for (const int channels : {1, 3}) {
    const auto view = [&](double shift) {
      const Image gray = pipeline::textured(texture, 256, 192, shift);
      Image stored(gray.width, gray.height, channels);
      for (std::size_t i = 0; i < stored.data.size(); ++i) stored.data[i] = gray.data[i / channels];
      return stored;
    };
    write_view(folder / "l.png", view(0));
    write_view(folder / "r.png", view(3));
    const Image portrait = portrait_of(folder, "l.png", "r.png");
    ASSERT_EQ(portrait.channels, 3);
    for (std::size_t i = 0; i < portrait.data.size(); i += 3) {
      ASSERT_EQ(portrait.data[i], portrait.data[i + 1]) << channels << " " << i;
      ASSERT_EQ(portrait.data[i], portrait.data[i + 2]) << channels << " " << i;
    }
    const Image radius_px = pipeline::read_result(folder / "out").result.blur_radius_px;
    EXPECT_GT(*std::max_element(radius_px.data.begin(), radius_px.data.end()), 1.5f) << channels;
  }
}

struct ViewsOfPlane {
  Image left, right;
};

/// At a disparity of 1.4 px: shifted, or, for a matcher that knows no shift of that size but blur, as a phone's split
/// blurs them. (Of a pure shift of 1.4 px `split` finds 1.3: docs/disparity.md.)
ViewsOfPlane plane_for(const std::string& matcher) {
  constexpr int kWidth = 129, kHeight = 96;
  if (matcher == "split") {
    pipeline::RampPair pair =
        pipeline::ramp_pair(5, 1.4 / pipeline::kRampAlpha, 0, pipeline::kRampAlpha, 1, kWidth, kHeight);
    return {std::move(pair.left), std::move(pair.right)};
  }
  const pipeline::Texture texture(5, 0.2);
  return {pipeline::textured(texture, kWidth, kHeight, 0), pipeline::textured(texture, kWidth, kHeight, 1.4)};
}

TEST(PlainPair, PortraitFindsTheDisparityAlongTheSplit) {
  const TemporaryFolder folder;
  for (const std::string matcher : {"paper", "likelihood", "split"}) {
    const auto [left, right] = plane_for(matcher);
    write_view(folder / "l.png", left);
    write_view(folder / "r.png", right);
    write_view(folder / "l_down.png", pipeline::transposed(left));
    write_view(folder / "r_down.png", pipeline::transposed(right));
    for (const bool down : {false, true}) {
      SCOPED_TRACE(matcher + (down ? " down" : ""));
      const std::string view = down ? "_down.png'" : ".png'";
      const Outcome outcome =
          run_command("portrait --mode dp --left '" + (folder / "l") + view + " --right '" + (folder / "r") + view +
                      " -o '" + (folder / "out") + "' --matcher " + matcher + (down ? " --split vertical" : ""));
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      const pipeline::PortraitResult result = pipeline::read_result(folder / "out").result;
      const Image& d = result.matched_disparity_dp_px;
      EXPECT_EQ(d.width, down ? left.height : left.width + 1);
      EXPECT_EQ(result.portrait.width, d.width);
      double sum = 0;
      for (const float value : d.data) sum += value;
      EXPECT_NEAR(sum / static_cast<double>(d.data.size()), 1.4, 0.05);
    }
  }
}

TEST(PlainPair, SaysWhichSplitIsAssumed) {
  const TemporaryFolder folder;
  write_view(folder / "v.png", pipeline::textured(pipeline::Texture(5, 0.2), 64, 48, 0));
  const auto assumed = [&](const std::string& options, const std::string& metadata = "{}") {
    write_bytes(folder / "m.json", metadata);
    const std::string in = "'" + folder.path.string() + "/";
    const Outcome outcome = run_command("portrait --mode dp --left " + in + "v.png' --right " + in + "v.png' -o " + in +
                                        "out' --metadata " + in + "m.json' " + options);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json result = read_json_file(folder / "out/result.json");
    std::string alpha;
    for (const std::string sentence : result.at("provenance").at("assumed")) {
      if (sentence.find("(alpha)") != std::string::npos) alpha = sentence;
    }
    EXPECT_NE(outcome.err.find(alpha), std::string::npos) << outcome.err;
    return alpha;
  };
  EXPECT_EQ(assumed(""), "disparity over blur diameter (alpha) is 0.21, a phone's");
  EXPECT_EQ(assumed("", R"({"alpha": 7})"), "disparity over blur diameter (alpha) is 0.21, a phone's, not 7 as stated");
  EXPECT_EQ(assumed("", R"({"alpha": 0.3})"), "");
  EXPECT_EQ(assumed("--set split_match.alpha=0.3"), "");
  EXPECT_EQ(assumed("--matcher paper"), "");
}

TEST(PlainPair, EmptyPicturesHaveLowConfidence) {
  const TemporaryFolder folder;
  write_png8(folder / "white.png", Image(40, 24, 1, 1.0f));
  write_png8(folder / "line.png", Image(200, 1, 1, 0.3f));
  write_png8(folder / "pixel.png", Image(1, 1, 1, 0.3f));
  for (const std::string matcher : {"paper", "likelihood", "split"}) {
    for (const std::string name : {"white", "line", "pixel"}) {
      SCOPED_TRACE(matcher + " " + name);
      const std::string view = folder / (name + ".png");
      const Outcome outcome = run_command("portrait --mode dp --left '" + view + "' --right '" + view + "' -o '" +
                                          (folder / "out") + "' --matcher " + matcher);
      ASSERT_EQ(outcome.status, 0) << outcome.err;
      const pipeline::PortraitResult result = pipeline::read_result(folder / "out").result;
      for (const float confidence : result.confidence.data) ASSERT_EQ(confidence, 0);
      for (const Image* image : {&result.portrait, &result.disparity_dp_px, &result.matched_disparity_dp_px}) {
        for (const float value : image->data) ASSERT_TRUE(std::isfinite(value));
      }
    }
  }
}

TEST(PlainPair, IsReportedOn) {
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  write_view(folder / "l.png", pipeline::textured(pipeline::Texture(5, 0.2), 129, 95, 0));
  write_view(folder / "r.png", pipeline::textured(pipeline::Texture(5, 0.2), 129, 95, 1));
  write_bytes(folder / "m.json", R"({"encoding": "linear", "focus_distance_m": 0.7})");
  const std::string pair =
      "portrait --mode dp --left " + in + "l.png' --right " + in + "r.png' --metadata " + in + "m.json' ";
  ASSERT_EQ(run_command(pair + "-o " + in + "a'").status, 0);
  ASSERT_EQ(run_command(pair + "-o " + in + "b' --split vertical --matcher paper").status, 0);
  write_npy(folder / "d.npy", Image(129, 95, 1, 0.5f));
  ASSERT_EQ(run_command(pair + "-o " + in + "c' --disparity " + in + "d.npy'").status, 0);
  ASSERT_EQ(run_command(pair + "-o " + in + "z' --split vertical --zoom").status, 0);
  const std::string report = "report -o " + in + "report.html' " + in;
  const Outcome zoomed = run_command(report + "z'");
  EXPECT_EQ(zoomed.status, 0) << zoomed.err;
  const Outcome outcome = run_command(report + "a' " + in + "b' " + in + "c'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string page = read_bytes(folder / "report.html");
  for (const std::string& part :
       {std::string("plain pair: 130 × 96 photosites, focused at 0.7 m; 1 frame"),
        std::string("dp, disparity: matcher paper"), std::string("dp, disparity: matcher split"),
        std::string("dp, disparity: given, d.npy")}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  write_view(folder / "l.png", pipeline::textured(pipeline::Texture(6, 0.2), 129, 95, 0));
  const Outcome changed = run_command(report + "a'");
  expect_one_line_refusal(changed);
  EXPECT_NE(changed.err.find("l.png: was changed since "), std::string::npos) << changed.err;
  std::filesystem::remove(folder / "l.png");
  expect_one_line_refusal(run_command(report + "a'"));
}

// A pupil k times as wide blurs by sqrt(k^2 - 1) times the pair's own discs, whose radius is |d| / (2 alpha).
TEST(PlainPair, IsBlurredAsALensWould) {
  constexpr double kDisparity = 1.5, kAlpha = 0.3, kFocal_mm = 4.4, kFNumber = 1.8;
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  write_view(folder / "v.png", pipeline::textured(pipeline::Texture(5, 0.2), 160, 96, 0));
  write_npy(folder / "d.npy", Image(160, 96, 1, kDisparity));
  const std::string portrait = "portrait --mode dp --left " + in + "v.png' --right " + in + "v.png' --disparity " + in +
                               "d.npy' -o " + in + "out' --match-lens f/10@50mm-equivalent ";
  const Outcome bare = run_command(portrait);
  expect_one_line_refusal(bare);
  EXPECT_NE(bare.err.find("--metadata: /alpha, focal_length_mm, f_number: are required"), std::string::npos)
      << bare.err;
  write_bytes(folder / "m.json", R"({"alpha": 0.3, "focal_length_mm": 4.4})");
  expect_one_line_refusal(run_command(portrait + "--metadata " + in + "m.json'"));
  write_bytes(folder / "m.json", R"({"alpha": 0.3, "focal_length_mm": 4.4, "f_number": 1.8})");
  const Outcome outcome = run_command(portrait + "--metadata " + in + "m.json'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const double wider = (50.0 / 10) / (kFocal_mm / kFNumber);
  const Image radius = pipeline::read_result(folder / "out").result.blur_radius_px;
  // even disparity stays what it is through the solver, to its tolerance
  EXPECT_NEAR(radius.at(80, 48), std::sqrt(wider * wider - 1) * kDisparity / (2 * kAlpha), 0.02);
}

/// Of a camera whose views have 128 x 95 DP pixels; the intercept rises by 0.4 DP px from the middle to the right.
pipeline::Calibration slanted_calibration() {
  pipeline::FocusCalibration focus{0.8, 1, pipeline::node_image(-1), pipeline::node_image(), pipeline::node_image()};
  for (int j = 0; j < pipeline::kCalibrationRows; ++j) {
    for (int i = 0; i < pipeline::kCalibrationColumns; ++i) {
      focus.intercept_dp_px.at(i, j) = 0.8f * static_cast<float>(i) / (pipeline::kCalibrationColumns - 1) - 0.4f;
    }
  }
  Camera camera;
  camera.name = "phone";
  camera.width_px = 256;
  camera.height_px = 190;  // views of an odd height
  camera.dp_downsample_y = 2;
  camera.pixel_pitch_um = 1.4;
  camera.focal_length_mm = 4.4;
  camera.f_number = 1.8;
  camera.principal_point_px = {128, 95};
  return {camera, 0.25, 2.5, {focus}, {}};
}

TEST(PlainPair, IsCorrectedByTheCalibrationOfItsCamera) {
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  std::filesystem::create_directory(folder / "cal");
  pipeline::Calibration calibration = slanted_calibration();
  write_bytes(folder / "cal/calibration.json", to_json(calibration).dump());
  const Image view = pipeline::textured(pipeline::Texture(5, 0.2), 128, 95, 0);
  write_view(folder / "v.png", view);
  write_npy(folder / "d.npy", Image(128, 95, 1, 1.0f));
  const std::string portrait = "portrait --mode dp --left " + in + "v.png' --right " + in + "v.png' --disparity " + in +
                               "d.npy' -o " + in + "out' --calibration " + in + "cal' ";
  const Outcome unfocused = run_command(portrait);
  expect_one_line_refusal(unfocused);
  EXPECT_NE(unfocused.err.find("--metadata: /focus_distance_m: is required by --calibration"), std::string::npos)
      << unfocused.err;
  write_bytes(folder / "m.json", R"({"focus_distance_m": 0.8})");
  const Outcome outcome = run_command(portrait + "--metadata " + in + "m.json'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Image d = pipeline::read_result(folder / "out").result.matched_disparity_dp_px;
  for (const int x : {10, 64, 120}) EXPECT_NEAR(d.at(x, 48), 1 - 0.4 * ((x + 0.5) / 64 - 1), 1e-3) << x;

  write_view(folder / "v.png", pipeline::transposed(view));
  write_npy(folder / "d.npy", Image(95, 128, 1, 1.0f));
  const std::string transposed = portrait + "--metadata " + in + "m.json' --split vertical";
  ASSERT_EQ(run_command(transposed).status, 0);
  const Image turned = pipeline::read_result(folder / "out").result.matched_disparity_dp_px;
  for (const int y : {10, 64, 120}) EXPECT_EQ(turned.at(48, y), d.at(y, 48)) << y;

  const auto refusal = [&](const std::string& command) {
    const Outcome refused = run_command(command);
    expect_one_line_refusal(refused);
    return refused.err;
  };
  std::string refused = refusal(portrait + "--metadata " + in + "m.json'");
  EXPECT_NE(refused.find("v.png: 95 x 128 pixels: must be 128 x 95, as the views of the calibrated camera"),
            std::string::npos)
      << refused;
  write_bytes(folder / "m.json", R"({"focus_distance_m": 0.8, "focal_length_mm": 4.41, "f_number": 8})");
  refused = refusal(transposed);
  EXPECT_NE(refused.find("m.json: /f_number: 8: must be the calibrated camera's, 1.8"), std::string::npos) << refused;
  calibration.camera.height_px *= 2;
  calibration.camera.dp_downsample_y = 4;
  write_bytes(folder / "cal/calibration.json", to_json(calibration).dump());
  refused = refusal(transposed);
  EXPECT_NE(refused.find("DP pixels of 2 x 4 photosites: must be square"), std::string::npos) << refused;
  std::filesystem::remove(folder / "cal/calibration.json");
  refused = refusal(transposed);
  EXPECT_NE(refused.find("cal: holds no calibration.json"), std::string::npos) << refused;
}

/// What smoothed disparity makes of a real pair, against -1 / depth over its own range.
struct RealFigures {
  double rank, aiwe1;
};
struct RealSet {
  const char* folder;
  RealFigures paper, likelihood, split;  ///< as measured
};

class RealPair : public ::testing::TestWithParam<RealSet> {};

TEST_P(RealPair, DisparityFollowsDepth) {
  const std::filesystem::path set = shared_folder() / "data/dp119" / GetParam().folder;
  if (!std::filesystem::exists(set)) GTEST_SKIP() << set << " is not there: it needs the shared folder of real pairs";
  const Image depth = read_image((set / "d.png").string());
  const TemporaryFolder folder;
  for (const auto& [matcher, figures] : {std::pair<std::string, RealFigures>{"paper", GetParam().paper},
                                         {"likelihood", GetParam().likelihood},
                                         {"split", GetParam().split}}) {
    const Outcome outcome =
        run_command("portrait --mode dp --left '" + (set / "l.png").string() + "' --right '" +
                    (set / "r.png").string() + "' -o '" + (folder / "out") + "' --matcher " + matcher);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Image found = pipeline::read_result(folder / "out").result.disparity_dp_px;
    std::vector<float> disparity, truth;
    for (int y = 0; y < found.height; ++y) {
      for (int x = 0; x < found.width; ++x) {  // depth may have more pixels
        const float meters = 10 * depth.at((2 * x + 1) * depth.width / (2 * found.width),
                                           (2 * y + 1) * depth.height / (2 * found.height));
        if (!(meters > 0 && meters < 10)) continue;
        disparity.push_back(found.at(x, y));
        truth.push_back(-1 / meters);
      }
    }
    const auto [low, high] = std::minmax_element(truth.begin(), truth.end());
    const float range = *high - *low;
    for (float& value : truth) value /= range;
    EXPECT_NEAR(*evaluation::spearman(disparity, truth), figures.rank, 0.02) << matcher;
    EXPECT_NEAR(evaluation::aiwe1(disparity, truth), figures.aiwe1, 0.01) << matcher;
  }
}

INSTANTIATE_TEST_SUITE_P(SlowShared, RealPair,
                         ::testing::Values(RealSet{"box/001", {0.26, 0.134}, {0.35, 0.126}, {0.34, 0.129}},
                                           RealSet{"box/002", {0.87, 0.236}, {0.91, 0.126}, {0.88, 0.142}},
                                           RealSet{"box/003", {0.95, 0.097}, {0.95, 0.091}, {0.94, 0.093}},
                                           RealSet{"iphone/001", {0.92, 0.105}, {0.94, 0.084}, {0.94, 0.080}},
                                           RealSet{"iphone/002", {0.94, 0.077}, {0.97, 0.056}, {0.96, 0.062}},
                                           RealSet{"iphone/003", {0.59, 0.153}, {0.74, 0.135}, {0.75, 0.136}}),
                         [](const auto& set) {
                           std::string name = set.param.folder;
                           std::replace(name.begin(), name.end(), '/', '_');
                           return name;
                         });

}  // namespace
}  // namespace dualpixel::tools
