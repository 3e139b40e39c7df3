#include "pipeline/portrait/disparity_settings.h"

#include <gtest/gtest.h>

#include "capture/error.h"

namespace dualpixel::pipeline {
namespace {

template <typename Work>
std::string refusal_of(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DisparitySettings, MoreTimeErrsLess) {
  const auto all = disparity_settings();
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_GT(all[i].cpu_ms_per_megapixel, all[i - 1].cpu_ms_per_megapixel) << all[i].name;
    EXPECT_LT(all[i].error_dp_px, all[i - 1].error_dp_px) << all[i].name;
  }
}

TEST(DisparitySettings, TheLastThatFitsIsTheBest) {
  const auto all = disparity_settings();
  ASSERT_GT(all.size(), 2U);
  const double megapixels = 2;
  for (const DisparitySetting& setting : all) {
    EXPECT_EQ(&best_setting(setting.cpu_ms_per_megapixel * megapixels, megapixels), &setting);
    EXPECT_EQ(&fastest_setting(setting.error_dp_px), &setting);
  }
  EXPECT_EQ(&best_setting(1e9, megapixels), &all.back());
  EXPECT_EQ(&fastest_setting(1e9), &all.front());
  EXPECT_EQ(refusal_of([] { best_setting(1, 2); }),
            "--auto 1: the fastest setting takes 48 ms for 2 megapixels; allow that");
  EXPECT_EQ(refusal_of([] { fastest_setting(0.01); }),
            "--auto-error 0.01: the least error of any setting is 0.22 DP px; allow that");
}

TEST(DisparitySettings, ReplaceMatchingAndSmoothingAlone) {
  PortraitOptions options;
  options.mode = Mode::dp_seg;
  options.smooth.solver.iterations = 3;
  options.display.exposure_ev = 2;
  for (const DisparitySetting& setting : disparity_settings()) {
    const PortraitOptions chosen = with_setting(options, setting);
    EXPECT_NO_THROW(check(chosen));
    EXPECT_EQ(chosen.matcher, setting.matcher);
    EXPECT_EQ(changed_fields(chosen).size(), setting.assignments.size() + 1) << changed_fields(chosen).dump();
    EXPECT_EQ(chosen.mode, Mode::dp_seg);
    EXPECT_EQ(chosen.display.exposure_ev, 2);
  }
}

TEST(DisparitySettings, SayWhatTheyChoose) {
  EXPECT_EQ(command_line(disparity_settings().back()), "--matcher split --set smooth.divisor=8");
  for (const char* chosen : {"smooth.divisor", "split_match.alpha", "tile_upsample.spread_dp_px"}) {
    EXPECT_EQ(refusal_of([&] { require_not_chosen(chosen); }),
              std::string("--set ") + chosen + ": is chosen by --auto; leave one of them out");
  }
  EXPECT_NO_THROW(require_not_chosen("layers.bands"));
}

}  // namespace
}  // namespace dualpixel::pipeline
