// What is kept of a capture, against an even light of known color.
#include "datasets/pictures/pictures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "datasets/pictures/developed.h"
#include "datasets/pictures/statistics.h"
#include "simulator/sensor/sensor.h"

namespace dualpixel::datasets {
namespace {

using simulator::SensorOptions;

/// So large a well that noise hardly shows: of a signal below 1, a half's is below .001.
SensorOptions quiet_sensor(int dp_x, int dp_y) {
  SensorOptions sensor;
  sensor.width_px = 16, sensor.height_px = 16;
  sensor.full_well_e = 1e6;
  sensor.electrons_per_lux_s = {3.6e5, 4e5, 3.2e5};
  sensor.bits = 14;
  sensor.dp_downsample_x = dp_x, sensor.dp_downsample_y = dp_y;
  return sensor;
}

/// Before an even light that truth's pictures have as `signal`, half of it in either view.
Capture even_light(const SensorOptions& sensor, double iso, const std::array<float, 3>& signal) {
  const simulator::ExposureOptions exposure{.time_s = 0.01, .iso = iso};
  Capture capture;
  describe_sensor(sensor, capture.camera);
  capture.exposure = describe_exposure(sensor, exposure);
  Image nits(sensor.width_px, sensor.height_px, 3), picture = nits;
  for (std::size_t i = 0; i < nits.data.size(); ++i) {
    picture.data[i] = signal[i % 3];
    nits.data[i] = 0.5f * signal[i % 3] *
                   static_cast<float>(sensor.illuminant[i % 3] * capture.exposure.lux_s_per_unit / exposure.time_s);
  }
  capture.frames = {expose(expected_electrons(nits, nits, sensor, exposure, 1), sensor, exposure, 1)};
  Truth& truth = capture.truth.emplace();
  truth.all_in_focus = picture;
  truth.left = truth.right = scaled(picture, 0.5f);
  truth.depth_m = truth.disparity_dp_px = truth.person_mask = truth.valid = Image(picture.width, picture.height);
  return capture;
}

Image made(const Capture& capture, const char* name) { return find_named(pictures(), name)->make(capture); }

constexpr Matrix3 kTinted = {0.7, 0.4, -0.1, 0.2, 0.9, -0.1, 0, 0.3, 0.7};
constexpr double kNoise = 0.005;  // five deviations

// Truth is in the scene's colors, which no filter sees by itself.
TEST(Pictures, NoiselessViewsAreWhatTheFiltersSee) {
  for (const auto& [dp_x, dp_y] : {std::pair{1, 1}, {2, 4}}) {
    SensorOptions sensor = quiet_sensor(dp_x, dp_y);
    sensor.color_matrix = kTinted;
    sensor.illuminant = {1.2, 1, 0.8};
    const Capture capture = even_light(sensor, 100, {0.6f, 0.2f, 0.1f});
    for (const char* view : {"left", "right"}) {
      const Image noisy = made(capture, view), noiseless = made(capture, (view + std::string("_noiseless")).c_str());
      ASSERT_EQ(noisy.data.size(), noiseless.data.size());
      for (std::size_t i = 0; i < noisy.data.size(); ++i) ASSERT_NEAR(noisy.data[i], noiseless.data[i], kNoise) << i;
    }
  }
}

TEST(Pictures, DpddsGrayTargetIsTheGreenThatItsSourcesAre) {
  SensorOptions sensor = quiet_sensor(2, 4);
  sensor.color_matrix = kTinted;
  const DpddPictures p = dpdd_pictures(even_light(sensor, 100, {0.6f, 0.2f, 0.1f}));
  for (std::size_t i = 0; i < p.target.data.size(); ++i) ASSERT_NEAR(p.combined.data[i], p.target.data[i], kNoise);
}

// Red filters that let most light through are white first, and the others are made as white as they.
TEST(Pictures, DpddsDenseTargetIsAsWhiteAsItsSources) {
  SensorOptions sensor = quiet_sensor(1, 1);
  sensor.electrons_per_lux_s = {8e5, 4e5, 3.2e5};
  for (const Matrix3& matrix : {kIdentity3, kTinted}) {
    sensor.color_matrix = matrix;
    const Capture capture = even_light(sensor, 100, {3, 3, 3});
    ASSERT_LT(capture.exposure.white_balance[0], 0.7);
    const DpddPictures p = dpdd_pictures(capture);
    for (std::size_t i = 0; i < p.target.data.size(); ++i) {
      ASSERT_NEAR(p.target.data[i], capture.exposure.white_balance[0], kNoise);
      ASSERT_NEAR(p.combined.data[i], p.target.data[i], kNoise);
    }
  }
}

// Views are white where their wells are full: below the digital range at ISO 50, above it at ISO 400.
TEST(Pictures, ClippedIsWhatFillsWellsOrTheDigitalRange) {
  SensorOptions sensor = quiet_sensor(2, 4);
  sensor.full_well_e = 6000;  // a phone's, so that noise shows
  sensor.electrons_per_lux_s = {3600, 4000, 3200};
  for (const double iso : {50.0, 100.0, 400.0}) {
    const auto white = static_cast<float>(std::min(1.0, iso / 100));
    const auto clipped = [&](float signal) {
      const auto share = statistics_of(even_light(sensor, iso, {signal, signal, signal}))["clipped_share"];
      return share.get<double>();
    };
    EXPECT_EQ(clipped(2 * white), 1) << iso;
    EXPECT_EQ(clipped(0.8f * white), 0) << iso;
  }
}

}  // namespace
}  // namespace dualpixel::datasets
