#include "pipeline/portrait/disparity_settings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <tuple>

#include "capture/error.h"
#include "tests/temporary_folder.h"

namespace dualpixel::pipeline {
namespace {

constexpr Megapixels kPhone = {5.4, 5.4 / 8};

TEST(DisparitySettings, MoreTimeErrsLess) {
  const auto all = disparity_settings();
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_GT(cpu_ms(all[i], kPhone), cpu_ms(all[i - 1], kPhone)) << all[i].name;
    EXPECT_LT(all[i].error_dp_px, all[i - 1].error_dp_px) << all[i].name;
  }
}

TEST(DisparitySettings, TheLastThatFitsIsTheBest) {
  const auto all = disparity_settings();
  ASSERT_GT(all.size(), 2U);
  for (const DisparitySetting& setting : all) {
    EXPECT_EQ(&best_setting(cpu_ms(setting, kPhone), kPhone), &setting);
    EXPECT_EQ(&fastest_setting(setting.error_dp_px), &setting);
  }
  EXPECT_EQ(&best_setting(1e9, kPhone), &all.back());
  EXPECT_EQ(&fastest_setting(1e9), &all.front());
  EXPECT_EQ(message_of<InputError>([] {
              best_setting(1, {2, 0.25});
            }),
            "--auto 1: must be at least 52.0, ms of the fastest setting for 2 megapixels");
  EXPECT_EQ(message_of<InputError>([] { fastest_setting(0.01); }),
            "--auto-error 0.01: must be at least 0.245, DP px of the most accurate setting on offer");
}

// Matching takes its time by DP pixels, which are eight times as many where each is one photosite.
TEST(DisparitySettings, CostFollowsBothSizes) {
  const DisparitySetting& split = disparity_settings().back();
  EXPECT_NEAR(cpu_ms(split, {2, 2}) - cpu_ms(split, {2, 0.25}), 1.75 * split.matching_ms, 1e-9);
  EXPECT_NEAR(cpu_ms(split, {0, 0}), split.fixed_ms, 1e-9);
  Capture capture;
  capture.camera.width_px = 1000;
  capture.camera.height_px = 2000;
  capture.frames.resize(1);
  for (const auto& [x, y, mosaic, view] : {std::tuple{2, 4, true, 0.25}, {1, 1, false, 2.0}, {1, 1, true, 0.5}}) {
    capture.camera.dp_downsample_x = x;
    capture.camera.dp_downsample_y = y;
    capture.frames[0].mosaic = mosaic ? ImageU16(1, 1) : ImageU16();
    EXPECT_NEAR(megapixels_of(capture).picture, 2, 1e-12);
    EXPECT_NEAR(megapixels_of(capture).view, view, 1e-12);  // dense ones by their green photosites, at half the size
  }
}

TEST(DisparitySettings, ReplaceMatcherAndSmoothingAlone) {
  PortraitOptions options;
  options.mode = Mode::dp_seg;
  options.smooth.solver.iterations = 3;
  options.display.exposure_ev = 2;
  options.matching.split_match.alpha = 0.3f;
  for (const DisparitySetting& setting : disparity_settings()) {
    const PortraitOptions chosen = with_setting(options, setting);
    EXPECT_NO_THROW(check(chosen));
    EXPECT_EQ(chosen.matcher, setting.matcher);
    EXPECT_EQ(changed_fields(chosen).size(), setting.assignments.size() + 2) << changed_fields(chosen).dump();
    EXPECT_EQ(chosen.mode, Mode::dp_seg);
    EXPECT_EQ(chosen.display.exposure_ev, 2);
  }
}

TEST(DisparitySettings, SayWhatTheyChoose) {
  EXPECT_EQ(command_line(disparity_settings().back()), fmt::format("--matcher {}", kDefaultMatcher));
  EXPECT_NE(command_line(disparity_settings().front()).find("--matcher paper --set smooth.divisor=16 --set "),
            std::string::npos);
  EXPECT_EQ(message_of<InputError>([] { require_not_chosen("smooth.divisor=8"); }),
            "smooth.divisor=8: smoothing is chosen by --auto and --auto-error; leave one of them out");
  EXPECT_NO_THROW(require_not_chosen("split_match.alpha=.2"));
}

}  // namespace
}  // namespace dualpixel::pipeline
