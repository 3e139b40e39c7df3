#include "simulator/plan/match_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <tuple>

namespace dualpixel::simulator {
namespace {

/// A few waves, none shorter than 8 DP pixels, moved to the right by `shift`; all `stretch` times as long.
Image waves(double shift, double stretch = 1) {
  Image image(66, 32);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double at = (x - shift) / stretch;
      image.at(x, y) = static_cast<float>(300 + 40 * std::sin(0.7 * at + 0.3 * y) + 30 * std::cos(0.45 * at - 0.5 * y) +
                                          20 * std::sin(0.31 * at + 0.9 * y));
    }
  }
  return image;
}

Exposure noisy() {
  Exposure exposure;
  exposure.dp_noise = {0.05, 1};
  return exposure;
}

MatchWindows windows_of(const DpViews& reference) { return match_windows(reference, reference, noisy(), 1, 10); }

TEST(MatchError, FindsTheShiftThatWasMade) {
  const DpViews reference{waves(0), waves(0)};
  const MatchWindows windows = windows_of(reference);
  EXPECT_EQ(windows.total, 8);  // 64 of the 66 columns have both neighbors
  ASSERT_EQ(windows.textured.size(), 8u);
  constexpr double kShift = 0.02;
  for (const MatchWindow& w : windows.textured) {
    EXPECT_NEAR(w.shift_dp_px(reference), 0, 1e-6);
    // the central difference of sin(k x) is sin(k)/k short: up to 8 % at k = 0.7
    EXPECT_NEAR(w.shift_dp_px({waves(0), waves(kShift)}), kShift, 0.09 * kShift);
    EXPECT_NEAR(w.shift_dp_px({waves(-kShift), waves(0)}), kShift, 0.09 * kShift);
    EXPECT_NEAR(w.shift_dp_px({waves(kShift), waves(kShift)}), 0, 1e-6);
  }
}

// Photosites as DP pixels have the mosaic's pattern, which does not move with the picture.
TEST(MatchError, FindsTheShiftBehindAMosaic) {
  const auto behind = [](Image image) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (x % 2 == 0 && y % 2 == 0) image.at(x, y) *= 0.4f;
        if (x % 2 == 1 && y % 2 == 1) image.at(x, y) *= 0.6f;
      }
    }
    return image;
  };
  constexpr double kStretch = 2, kShift = 0.02;
  const DpViews reference{behind(waves(0, kStretch)), behind(waves(0, kStretch)), 2};
  const MatchWindows windows = windows_of(reference);
  EXPECT_EQ(windows.total, 6);  // 62 of the 66 columns have both neighbors of their color
  ASSERT_EQ(windows.textured.size(), 6u);
  for (const MatchWindow& w : windows.textured) {
    EXPECT_NEAR(w.shift_dp_px(reference), 0, 1e-6);
    // the difference over 4 pixels of waves twice as long is as short as that over 2 of the others
    EXPECT_NEAR(w.shift_dp_px({behind(waves(0, kStretch)), behind(waves(kShift, kStretch)), 2}), kShift, 0.09 * kShift);
  }
}

TEST(MatchError, BrightnessAndOffsetAreNoShift) {
  const DpViews reference{waves(0), waves(0)};
  DpViews brighter = reference;
  for (float& value : brighter.right.data) value = 1.5f * value - 20;
  for (const MatchWindow& w : windows_of(reference).textured) EXPECT_NEAR(w.shift_dp_px(brighter), 0, 1e-5);
}

TEST(SlowMatchError, ScattersUnderNoiseByTheStatedBound) {
  const DpViews reference{waves(0), waves(0)};
  const NoiseProfile noise = noisy().dp_noise;
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, std::sqrt(noise.shot_dn * 300 + noise.read_dn2));
  const MatchWindow w = windows_of(reference).textured[0];
  constexpr int kDraws = 4000;
  double sum2 = 0;
  for (int i = 0; i < kDraws; ++i) {
    DpViews drawn = reference;
    for (Image* view : {&drawn.left, &drawn.right}) {
      for (float& value : view->data) value += static_cast<float>(normal(random));
    }
    sum2 += std::pow(w.shift_dp_px(drawn), 2);
  }
  // a standard deviation from n draws is known to 1/sqrt(2 n); the window's light differs from 300 by at most 2 %
  EXPECT_NEAR(std::sqrt(sum2 / kDraws) / w.sensor_noise_dp_px, 1, 3 / std::sqrt(2.0 * kDraws) + 0.01);
}

TEST(MatchError, NoiseIsNoTexture) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(300, 10);
  DpViews flat[2];
  for (DpViews& views : flat) {
    views = {Image(66, 32), Image(66, 32)};
    for (Image* view : {&views.left, &views.right}) {
      for (float& value : view->data) value = normal(random);
    }
  }
  constexpr double kMostNoise = 0.03;
  // taken for texture, gradients of standard deviation 10/sqrt(2) would promise 4/sqrt(256)/7 sqrt(2) = 0.05 ...
  Exposure exposure = noisy();
  exposure.dp_noise = {0, 1};
  EXPECT_EQ(match_windows(flat[0], flat[0], exposure, 1, kMostNoise).textured.size(), 8u);
  EXPECT_EQ(match_windows(flat[0], flat[1], exposure, 1, kMostNoise).textured.size(), 0u);
}

TEST(MatchError, CorrelationTellsOtherPicturesFromTheSame) {
  const DpViews reference{waves(0), waves(0)};
  DpViews darker = reference;
  for (Image* view : {&darker.left, &darker.right}) {
    for (float& value : view->data) value = 0.1f * value + 3;
  }
  const DpViews black{Image(66, 32), Image(66, 32)};
  for (const MatchWindow& w : windows_of(reference).textured) {
    EXPECT_NEAR(w.correlation(darker, darker, reference, reference), 1, 1e-5);
    EXPECT_EQ(w.correlation(black, black, reference, reference), 0);
  }
}

TEST(MatchError, DpViewsAreTheMeanOfWhatTheSensorReads) {
  const ExposureOptions exposure{0.01, 100};
  // each DP pixel that there is, with a well that is half full, and one that overflows
  for (const auto& [dp_x, dp_y, fill] : {std::tuple{2, 4, 0.5}, {2, 4, 2.0}, {2, 2, 0.5}, {1, 1, 0.5}, {1, 1, 2.0}}) {
    SensorOptions sensor;
    sensor.dp_downsample_x = dp_x, sensor.dp_downsample_y = dp_y;
    const double nits =
        fill * sensor.full_well_e / sensor.electrons_per_lux_s[1] / exposure.time_s;  // at 1 lux per nit
    const Views views{Image(64, 64, 3, static_cast<float>(0.6 * nits)),
                      Image(64, 64, 3, static_cast<float>(0.4 * nits))};
    const DpViews dp = expected_dp_views(views, sensor, exposure, 1);
    const Frame frame = expose(expected_electrons(views.left, views.right, sensor, exposure, 1), sensor, exposure, 1);
    ASSERT_EQ(dp.left.width, frame.left.width);
    ASSERT_EQ(dp.left.height, frame.left.height);
    const NoiseProfile noise = describe_exposure(sensor, exposure).dp_noise;
    for (const auto& [expected, read] : {std::pair{&dp.left, &frame.left}, std::pair{&dp.right, &frame.right}}) {
      double sum = 0;
      for (std::uint16_t value : read->data) sum += value - sensor.black_level_dn;
      const double mean = std::accumulate(expected->data.begin(), expected->data.end(), 0.0) /
                          static_cast<double>(expected->data.size());
      const double error = std::sqrt((noise.shot_dn * mean + noise.read_dn2) / static_cast<double>(read->data.size()));
      EXPECT_NEAR(sum / static_cast<double>(read->data.size()), mean, 3 * error) << fill << ' ' << dp_x << ' ' << dp_y;
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator
