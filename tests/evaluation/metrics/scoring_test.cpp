#include "evaluation/metrics/scoring.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::synthetic_capture;
using pipeline::synthetic_stored;

using Json = nlohmann::ordered_json;

// synthetic.h: 64 x 48, the bottom row not valid; a jump of 1.5 DP px between columns 31 and 32.
constexpr int kValid = 64 * 47;

Json score(const Capture& capture, const pipeline::StoredResult& stored) {
  return to_json(score_result(capture, "c", stored, "r"));
}

TEST(Score, OfAnAffineImageOfTheTruth) {
  const Capture capture = synthetic_capture();
  const Json figures = score(capture, synthetic_stored(capture))["disparity"]["everything"];
  EXPECT_EQ(figures["pixels"], kValid);
  EXPECT_EQ(figures["coverage"], 1);
  // estimate - truth = -(truth + 0.2) / 2; the truth is -1 on the left, uniform in 32 steps on 0.5..1.5 on the right.
  EXPECT_NEAR(figures["bias_px"].get<double>(), -0.1, 1e-6);
  const double step_variance = (32.0 * 32 - 1) / 12 / (31.0 * 31);
  EXPECT_NEAR(figures["rmse_px"].get<double>(), std::sqrt((0.64 + 1.44 + step_variance) / 2) / 2, 1e-6);
  EXPECT_EQ(figures["bad_0p1"], 1);
  EXPECT_NEAR(figures["affine_scale"].get<double>(), 2, 1e-6);
  EXPECT_NEAR(figures["affine_offset_px"].get<double>(), 0.2, 1e-6);
  EXPECT_NEAR(figures["rmse_affine_px"].get<double>(), 0, 1e-6);
  EXPECT_EQ(figures["aiwe2"], figures["rmse_affine_px"]);
  EXPECT_NEAR(figures["aiwe1"].get<double>(), 0, 1e-6);
  EXPECT_EQ(figures["bad_0p1_affine"], 0);
  EXPECT_NEAR(figures["one_minus_rho_average_ranks"].get<double>(), 0, 1e-12);
}

TEST(Score, CutsRegionsAsDefined) {
  const Capture capture = synthetic_capture();
  const Json regions = score(capture, synthetic_stored(capture))["disparity"];
  EXPECT_EQ(regions["confident"]["pixels"], 64 * 24);
  EXPECT_NEAR(regions["confident"]["coverage"].get<double>(), 24.0 / 47, 1e-12);
  EXPECT_EQ(regions["depth_edges"]["pixels"], 16 * 47);
  EXPECT_EQ(regions["person"]["pixels"], 32 * 24);
}

// A result that shows a later frame, where all is 2.5 photosites to the right and 3 further down, is scored where the
// first frame's points are: all figures stay but for the columns and rows that left the picture.
TEST(Score, LooksUpALaterBaseFrameAlongTheMotion) {
  Capture capture = synthetic_capture();
  capture.frames.push_back(capture.frames.front());
  pipeline::StoredResult stored = synthetic_stored(capture);
  for (Image* image : {&stored.result.disparity_dp_px, &stored.result.input, &stored.result.portrait}) {
    const Image still = *image;
    for (int y = 3; y < 48; ++y) {
      for (int x = 3; x < 64; ++x) {
        for (int c = 0; c < image->channels; ++c) {
          image->at(x, y, c) = 0.5f * (still.at(x - 3, y - 3, c) + still.at(x - 2, y - 3, c));
        }
      }
    }
  }
  const double before = score(capture, stored)["disparity"]["everything"]["rmse_affine_px"];
  EXPECT_GT(before, 0.2);
  stored.result.base_frame = 1;
  EXPECT_EQ(score(capture, stored)["disparity"]["everything"]["rmse_affine_px"], before);  // no motion: static
  capture.truth->motion = {Image(64, 48, 2, 3.0f)};
  for (std::size_t i = 0; i < capture.truth->motion[0].data.size(); i += 2) capture.truth->motion[0].data[i] = 2.5f;
  const Json figures = score(capture, stored);
  EXPECT_EQ(figures["disparity"]["everything"]["pixels"], 62 * 45);
  // smeared twice by half a pixel: at the jump of 1.5 two columns err by a quarter of it
  EXPECT_NEAR(figures["disparity"]["everything"]["rmse_affine_px"].get<double>(), 0.375 * std::sqrt(2.0 / 62), 0.01);
  EXPECT_NEAR(figures["disparity"]["everything"]["bad_0p1_affine"].get<double>(), 2.0 / 62, 1e-6);
  EXPECT_EQ(figures["disparity"]["person"]["pixels"], 32 * 24);
  stored.result.base_frame = 2;
  EXPECT_THROW(score(capture, stored), InputError);
}

TEST(Score, LeavesOutPixelsWithoutTruthOrEstimate) {
  const Capture capture = synthetic_capture();
  pipeline::StoredResult stored = synthetic_stored(capture);
  std::fill_n(stored.result.disparity_dp_px.row(47), 64, 1e6f);  // the row without truth
  std::fill_n(stored.result.disparity_dp_px.row(0), 64, NAN);
  const Json figures = score(capture, stored)["disparity"]["everything"];
  EXPECT_EQ(figures["pixels"], kValid - 64);
  EXPECT_NEAR(figures["coverage"].get<double>(), 46.0 / 47, 1e-12);
  EXPECT_NEAR(figures["rmse_affine_px"].get<double>(), 0, 1e-6);
}

TEST(Score, SaysWhyFiguresAreNull) {
  const Capture capture = synthetic_capture();
  pipeline::StoredResult stored = synthetic_stored(capture);
  std::fill(stored.result.disparity_dp_px.data.begin(), stored.result.disparity_dp_px.data.end(), NAN);
  stored.result.portrait = capture.truth->photograph;
  const Json all_nan = score(capture, stored);
  EXPECT_TRUE(all_nan["disparity"]["everything"]["rmse_px"].is_null());
  EXPECT_TRUE(all_nan["disparity"]["person"]["ause"].is_null());
  EXPECT_TRUE(all_nan["image"]["psnr_db"].is_null());
  const std::string notes = all_nan["notes"].dump();
  EXPECT_NE(notes.find("disparity.everything: no pixel"), std::string::npos);
  EXPECT_NE(notes.find("image.psnr_db: infinite"), std::string::npos);
  EXPECT_NE(to_text(score_result(capture, "c", stored, "r")).find("note: disparity.everything: no pixel"),
            std::string::npos);

  std::fill(stored.result.disparity_dp_px.data.begin(), stored.result.disparity_dp_px.data.end(), 0.5f);
  const Json constant = score(capture, stored);
  EXPECT_TRUE(constant["disparity"]["everything"]["one_minus_rho_average_ranks"].is_null());
  EXPECT_TRUE(constant["disparity"]["everything"]["rmse_affine_px"].is_number());
  EXPECT_NE(constant["notes"].dump().find("average_ranks: undefined, the estimate or the truth is constant"),
            std::string::npos);
}

TEST(Score, ComparesPictures) {
  const Capture capture = synthetic_capture();
  const Json figures = score(capture, synthetic_stored(capture))["image"];
  EXPECT_NEAR(figures["psnr_linear_db"].get<double>(), 20, 1e-4);  // 0.1 everywhere, nothing clips
  EXPECT_NEAR(figures["psnr_linear_input_db"].get<double>(), -20 * std::log10(0.2), 1e-4);
  EXPECT_EQ(figures["psnr_db"], figures["psnr_srgb_db"]);
  EXPECT_GT(figures["ssim"], figures["ssim_input"]);
}

// A photograph with noise of a known size, against a picture that is 0.1 off everywhere: the PSNR is lower than without
// the noise by what is stated.
TEST(Score, StatesWhatTheNoiseOfTheTruthTakes) {
  Capture capture = synthetic_capture();
  const pipeline::StoredResult stored = synthetic_stored(capture);
  const Json clean = score(capture, stored)["image"];
  EXPECT_TRUE(clean["truth_noise_db"].is_null());
  constexpr double kSigma = 0.03;
  capture.truth->noise = {.photograph = kSigma};
  int i = 0;
  for (float& value : capture.truth->photograph.data) value += static_cast<float>(++i % 2 ? kSigma : -kSigma);
  const Json noisy = score(capture, stored)["image"];
  // alternating signs: cross terms with the constant error cancel, and nothing clips
  EXPECT_NEAR(clean["psnr_linear_db"].get<double>() - noisy["psnr_linear_db"].get<double>(),
              noisy["truth_noise_db"].get<double>(), 1e-3);
  EXPECT_NEAR(noisy["truth_noise_db"].get<double>(), 10 * std::log10(1 + 0.09), 1e-3);
  capture.truth->noise = {.photograph = 1};  // more than the error that it is part of
  EXPECT_EQ(score(capture, stored)["image"]["truth_noise_db"], kTruthNoiseLimitDb);
}

TEST(Score, OfTheMaskAloneHasNoDisparity) {
  const Capture capture = synthetic_capture();
  pipeline::StoredResult stored = synthetic_stored(capture);
  stored.result.disparity_dp_px = stored.result.confidence = {};
  const Json figures = score(capture, stored);
  EXPECT_FALSE(figures.contains("disparity"));
  EXPECT_TRUE(figures["image"]["psnr_db"].is_number());
  EXPECT_NE(to_text(score_result(capture, "c", stored, "r")).find("Disparity: none"), std::string::npos);
}

TEST(Score, CarriesStages) {
  const Capture capture = synthetic_capture();
  const Json figures = score(capture, synthetic_stored(capture));
  EXPECT_EQ(figures["stages"]["merge"]["ms"], 12.5);
  EXPECT_EQ(figures["stages"]["blur"]["peak_rss_mb"], 350);
}

TEST(Score, RefusesWhatDoesNotFit) {
  Capture capture = synthetic_capture();
  const pipeline::StoredResult stored = synthetic_stored(synthetic_capture(32, 24));
  EXPECT_EQ(message_of<InputError>([&] { score(capture, stored); }), "r: 32 x 24 pixels; the capture c has 64 x 48");
  capture.truth.reset();
  EXPECT_EQ(message_of<InputError>([&] { score(capture, stored); }), "c: holds no truth to score against");
}

// DP pixels one photosite wide and four high: the views' maps are as wide as the sensor, and lower.
TEST(Score, OfViewsAsWideAsTheSensor) {
  Capture capture = synthetic_capture();
  capture.camera.dp_downsample_x = 1;
  capture.camera.dp_downsample_y = 4;
  Estimate estimate{Image(64, 12), {}, {}, {}};
  for (int y = 0; y < 12; ++y) std::copy_n(capture.truth->disparity_dp_px.row(0), 64, estimate.disparity_dp_px.row(y));
  const Json figures = to_json(score_estimate(capture, "c", estimate))["disparity"]["everything"];
  EXPECT_EQ(figures["pixels"], kValid);
  EXPECT_EQ(figures["rmse_px"], 0);
}

// What a stranger's program gives: a disparity alone, of the views' size.
TEST(ScoreEstimate, GivesFiguresOfWhatIsGivenAlone) {
  const Capture capture = synthetic_capture();
  const Camera& camera = capture.camera;
  Estimate estimate{.disparity_dp_px = Image(camera.dp_width(), camera.dp_height())};
  for (int y = 0; y < camera.dp_height(); ++y) {
    for (int x = 0; x < camera.dp_width(); ++x) {
      estimate.disparity_dp_px.at(x, y) = capture.truth->disparity_dp_px.at(2 * x, 4 * y);
    }
  }
  std::fill_n(estimate.disparity_dp_px.row(11), camera.dp_width(), NAN);  // of four rows of photosites
  const Score score = score_estimate(capture, "c", estimate);
  const Json figures = to_json(score);
  const Json& everything = figures["disparity"]["everything"];
  // The true disparity is -1 on the left half and a ramp of 32 steps over 1 on the right: odd columns err by one step.
  EXPECT_NEAR(everything["rmse_px"].get<double>(), 0.5 / 31, 1e-6);
  EXPECT_EQ(everything["pixels"], 64 * 44);
  for (const char* absent : {"ause", "sparsification", "within_one_sigma"}) EXPECT_FALSE(everything.contains(absent));
  for (const char* absent : {"image", "stages", "mode", "result"}) EXPECT_FALSE(figures.contains(absent)) << absent;
  EXPECT_FALSE(figures["disparity"].contains("confident"));
  const std::string text = to_text(score);
  for (const char* absent : {"photograph", "Stage", "confident", "sigma"}) {
    EXPECT_EQ(text.find(absent), std::string::npos) << text;
  }
}

// Errors of 0.1 everywhere; sigma 0.15 in the upper half and 0.06 in the lower: within one sigma are the upper rows, 24
// of the 47 with truth, within two sigma all.
TEST(ScoreEstimate, ComparesSigmaWithTheErrors) {
  const Capture capture = synthetic_capture();
  Estimate estimate{.disparity_dp_px = capture.truth->disparity_dp_px, .sigma_dp_px = Image(64, 48, 1, 0.06f)};
  for (float& d : estimate.disparity_dp_px.data) d += 0.1f;
  std::fill_n(estimate.sigma_dp_px.data.begin(), 64 * 24, 0.15f);
  const Json everything = to_json(score_estimate(capture, "c", estimate))["disparity"]["everything"];
  EXPECT_NEAR(everything["within_one_sigma"].get<double>(), 24.0 / 47, 1e-12);
  EXPECT_EQ(everything["within_two_sigma"], 1);
  EXPECT_TRUE(everything["ause"].is_number());
  // NaN is no sigma: the upper rows alone have one
  std::fill(estimate.sigma_dp_px.data.begin() + 64 * 24, estimate.sigma_dp_px.data.end(), NAN);
  const Json upper = to_json(score_estimate(capture, "c", estimate))["disparity"]["everything"];
  EXPECT_EQ(upper["within_one_sigma"], 1);
}

TEST(ScoreEstimate, ComparesAPortraitAlone) {
  const Capture capture = synthetic_capture();
  const Json figures = to_json(score_estimate(capture, "c", {.portrait = synthetic_stored(capture).result.portrait}));
  EXPECT_NEAR(figures["image"]["psnr_linear_db"].get<double>(), 20, 1e-4);
  EXPECT_FALSE(figures["image"].contains("psnr_input_db"));
  EXPECT_FALSE(figures.contains("disparity"));
}

TEST(ScoreEstimate, SaysAllThatIsWrongAtOnce) {
  Capture capture = synthetic_capture();
  const auto message = [&](const Estimate& estimate) {
    return message_of<InputError>([&] { score_estimate(capture, "c", estimate); });
  };
  EXPECT_EQ(message({}), "c: nothing to score: give a disparity or a portrait");
  EXPECT_EQ(message({.disparity_dp_px = Image(10, 9), .sigma_dp_px = Image(64, 48, 3), .portrait = Image(64, 48)}),
            "c: disparity: 10 x 9 pixels of 1 channel: must be one channel of 64 x 48 (the sensor) or 32 x 12 (the "
            "views); sigma: 64 x 48 pixels of 3 channels: must be one channel of 64 x 48 (the sensor) or 32 x 12 (the "
            "views); portrait: 64 x 48 pixels of 1 channel: must be 64 x 48 of 3");
  EXPECT_EQ(message({.confidence = Image(64, 48), .portrait = Image(64, 48, 3)}),
            "c: confidence and sigma: are those of a disparity, which is not given");
  EXPECT_EQ(message({.disparity_dp_px = Image(64, 48),
                     .confidence = Image(64, 48, 1, 1.5f),
                     .sigma_dp_px = Image(64, 48, 1, -2)}),
            "c: confidence: 1.5: must lie in [0, 1]; sigma: -2: must lie in [0, inf]");
}

TEST(Score, IsTheSameForAnyNumberOfThreads) {
  const Capture capture = synthetic_capture();
  const auto with_threads = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return score(capture, synthetic_stored(capture)).dump();
  };
  EXPECT_EQ(with_threads(1), with_threads(8));
}

}  // namespace
}  // namespace dualpixel::evaluation
