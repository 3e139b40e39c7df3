#include "simulator/sensor/sensor.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dualpixel::simulator {
namespace {

struct Statistics {
  double mean = 0, variance = 0;
};

Statistics statistics(const ImageU16& image) {
  Statistics s;
  for (auto v : image.data) s.mean += v;
  s.mean /= static_cast<double>(image.data.size());
  for (auto v : image.data) s.variance += (v - s.mean) * (v - s.mean);
  s.variance /= static_cast<double>(image.data.size());
  return s;
}

/// 14 bits: read noise of 5 DN, so that quantisation noise is the 1/12 DN^2 that the profile says.
SensorOptions fine_sensor() {
  SensorOptions s;
  s.width_px = 1024;
  s.height_px = 512;
  s.bits = 14;
  s.black_level_dn = 256;
  return s;
}

// Five decades of light, from 0.05 to 5000 electrons a photosite. n = 524288 photosites and 65536 DP pixels: a
// variance has standard error sqrt(2/n) (0.2 % and 0.55 %; Poisson's kurtosis adds under 0.1 % here since read noise
// rules where counts are small), 0.1 % and 0.28 % over the four frames: 1 % is ten and 3.6 of
// these. A mean has sigma/sqrt(n); read noise bounds what "within 1 %" can mean below one electron, so the mean's
// tolerance is 1 % or four standard errors, whichever is more.
TEST(Sensor, MeanAndVarianceFollowTheProfileOverFiveDecades) {
  const SensorOptions sensor = fine_sensor();
  const ExposureOptions exposure{0.01, 100};
  const Exposure described = describe_exposure(sensor, exposure);
  const double gain = gain_dn_per_electron(sensor, 100);
  for (double electrons : {0.05, 0.5, 5.0, 35.0, 50.0, 500.0, 5000.0}) {
    Image light(sensor.width_px, sensor.height_px, 2, static_cast<float>(electrons / 2));
    Statistics left, mosaic;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      const Frame frame = expose(light, sensor, exposure, 100 + seed);
      const Statistics m = statistics(frame.mosaic), l = statistics(frame.left);
      mosaic.mean += m.mean / 4, mosaic.variance += m.variance / 4;
      left.mean += l.mean / 4, left.variance += l.variance / 4;
    }
    const double signal = gain * electrons;
    const double expected = described.mosaic_noise.shot_dn * signal + described.mosaic_noise.read_dn2;
    EXPECT_NEAR(mosaic.variance, expected, 0.01 * expected) << electrons << " e";
    EXPECT_NEAR(mosaic.mean - 256, signal, std::max(0.01 * signal, 4 * std::sqrt(expected / (4 * 524288))));
    const double expected_dp = described.dp_noise.shot_dn * signal / 2 + described.dp_noise.read_dn2;
    EXPECT_NEAR(left.variance, expected_dp, 0.01 * expected_dp) << electrons << " e, left";
    EXPECT_NEAR(left.mean - 256, signal / 2, std::max(0.01 * signal / 2, 4 * std::sqrt(expected_dp / (4 * 65536))));
  }
}

TEST(Sensor, ClipsAtFullWellAndNeverLeavesItsBits) {
  SensorOptions sensor;
  sensor.width_px = 64;
  sensor.height_px = 64;
  Image light(64, 64, 2, 20000.0f);
  const Frame bright = expose(light, sensor, {0.01, 100}, 1);
  for (auto v : bright.mosaic.data) EXPECT_GE(v, 1023 - 8);  // full well +- read noise, clamped at the top
  const Frame overexposed = expose(light, sensor, {0.01, 800}, 1);
  for (auto v : overexposed.mosaic.data) EXPECT_EQ(v, 1023);
  const Frame dark = expose(Image(64, 64, 2, 0.0f), sensor, {0.01, 100}, 1);
  EXPECT_NEAR(statistics(dark.mosaic).mean, 64, 0.05);
}

// E = L pi/4 (L/z_i)^2 lux for L nits; at infinity focus this is pi L / (4 N^2).
TEST(Sensor, CountsElectronsPhotometrically) {
  SensorOptions sensor;
  sensor.width_px = 4;
  sensor.height_px = 4;
  const Image half(4, 4, 3, 50.0f);  // 50 + 50 nits
  const double lux_per_nit = M_PI / (4 * 1.8 * 1.8);
  const Image electrons = expected_electrons(half, half, sensor, {0.01, 100}, lux_per_nit);
  const double lux_s = 100 * lux_per_nit * 0.01;
  EXPECT_NEAR(electrons.at(0, 0, 0) + electrons.at(0, 0, 1), 3600 * lux_s, 1e-3);  // R
  EXPECT_NEAR(electrons.at(1, 0, 0) + electrons.at(1, 0, 1), 4000 * lux_s, 1e-3);  // G
  EXPECT_NEAR(electrons.at(1, 1, 0) + electrons.at(1, 1, 1), 3200 * lux_s, 1e-3);  // B
}

// Both views' shot noise is in the mosaic: the DP sum of a block equals the green mosaic but for read noise.
TEST(Sensor, MosaicAndViewsShareTheirPhotons) {
  SensorOptions sensor = fine_sensor();
  sensor.read_noise_e = 0;
  sensor.width_px = 64;
  sensor.height_px = 64;
  const Frame frame = expose(Image(64, 64, 2, 400.0f), sensor, {0.01, 100}, 9);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      double green = 0;
      for (int j = 0; j < 4; ++j) green += frame.mosaic.at(2 * x + ((j & 1) ? 0 : 1), 4 * y + j) / 4.0;
      EXPECT_NEAR(frame.left.at(x, y) + frame.right.at(x, y) - 256, green, 1.6);  // three roundings
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator
