#include "simulator/sensor/sensor.h"
#include "simulator/sampling/mosaic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

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

/// 14 bits: read noise of 5 DN, so that quantization noise is the 1/12 DN^2 that the profile says.
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
TEST(SlowSensor, MeanAndVarianceFollowTheProfileOverFiveDecades) {
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

// Per photosite over 100 frames: the temporal mean holds the pattern, whose deviation over the photosites is prnu (of
// sensitivity) and dark_offset (of darkness). 16384 photosites: a deviation has a standard error of 0.55 %, to which
// the temporal noise left in the means adds (taken out below); 3 % is five of these.
TEST(SlowSensor, FixedPatternIsTheCamerasOwnAndStaysFromFrameToFrame) {
  SensorOptions sensor = fine_sensor();
  sensor.width_px = sensor.height_px = 128;
  sensor.prnu = 0.01;
  sensor.dark_offset_dn = 4;
  const ExposureOptions exposure{0.01, 100};
  constexpr int kFrames = 100;
  const auto mean_frame = [&](float electrons) {
    std::vector<double> mean(3 * 128 * 128);
    for (int i = 0; i < kFrames; ++i) {
      const Frame frame = expose(Image(128, 128, 2, electrons / 2), sensor, exposure, 50 + i);
      for (std::size_t j = 0; j < frame.mosaic.data.size(); ++j) mean[j] += frame.mosaic.data[j] / (1.0 * kFrames);
      for (std::size_t j = 0; j < frame.left.data.size(); ++j) {
        mean[128 * 128 + j] += frame.left.data[j] / (1.0 * kFrames);
        mean[2 * 128 * 128 + j] += frame.right.data[j] / (1.0 * kFrames);
      }
    }
    return mean;
  };
  const auto deviation = [](const std::vector<double>& v, std::size_t first, std::size_t count, double noise_variance) {
    double sum = 0, squares = 0;
    for (std::size_t i = first; i < first + count; ++i) sum += v[i], squares += v[i] * v[i];
    return std::sqrt(squares / count - sum / count * (sum / count) - noise_variance / kFrames);
  };
  const Exposure described = describe_exposure(sensor, exposure);
  const NoiseProfile& noise = described.mosaic_noise;
  const std::vector<double> dark = mean_frame(0);
  EXPECT_NEAR(deviation(dark, 0, 16384, noise.read_dn2) / 4, 1, 0.03);
  std::vector<double> light = mean_frame(3000);
  const double signal = gain_dn_per_electron(sensor, 100) * 3000;
  for (std::size_t i = 0; i < light.size(); ++i) light[i] -= dark[i];
  EXPECT_NEAR(deviation(light, 0, 16384, noise.shot_dn * signal + 2 * noise.read_dn2) / (0.01 * signal), 1, 0.03);
  // A DP pixel is the mean of four halves, each of which varies by sqrt(2) prnu, 2048 pixels: 1.6 %. Left and right
  // vary apart: their correlation is 0 within four of 1/sqrt(2048).
  const NoiseProfile& dp = described.dp_noise;
  const double dp_variance = dp.shot_dn * signal / 2 + 2 * dp.read_dn2;
  EXPECT_NEAR(deviation(light, 16384, 2048, dp_variance) / (0.01 * std::sqrt(0.5) * signal / 2), 1, 0.08);
  double product = 0, left = 0, right = 0;
  for (int j = 0; j < 2048; ++j) left += light[16384 + j] / 2048, right += light[2 * 16384 + j] / 2048;
  for (int j = 0; j < 2048; ++j) product += (light[16384 + j] - left) * (light[2 * 16384 + j] - right) / 2048;
  EXPECT_NEAR(product / std::pow(deviation(light, 16384, 2048, 0), 2), 0, 4 / std::sqrt(2048.0));

  const Image gray(128, 128, 2, 1500);
  const Frame one = expose(gray, sensor, exposure, 1);
  sensor.fixed_pattern_seed = 2;
  EXPECT_NE(expose(gray, sensor, exposure, 1).mosaic.data, one.mosaic.data);
}

// As MeanAndVarianceFollowTheProfile, for the parts that it leaves out; 1 % is seven standard errors.
TEST(Sensor, NoiseBehindTheGainIsInTheProfileAndDoesNotGrowWithIso) {
  SensorOptions sensor = fine_sensor();
  sensor.read_noise_after_gain_dn = 7;
  for (const double iso : {100.0, 800.0}) {
    const Exposure described = describe_exposure(sensor, {0.01, iso});
    const double gain = gain_dn_per_electron(sensor, iso);
    EXPECT_NEAR(described.mosaic_noise.read_dn2, 4 * gain * gain + 49 + 1.0 / 12, 1e-9);
    const Frame frame = expose(Image(1024, 512, 2, 2), sensor, {0.01, iso}, 3);
    const double expected = described.mosaic_noise.shot_dn * gain * 4 + described.mosaic_noise.read_dn2;
    EXPECT_NEAR(statistics(frame.mosaic).variance, expected, 0.01 * expected);
    const double expected_dp = described.dp_noise.shot_dn * gain * 2 + described.dp_noise.read_dn2;
    EXPECT_NEAR(statistics(frame.left).variance, expected_dp, 0.02 * expected_dp);  // 65536 pixels: 0.55 %
  }
}

// 10, 12 and 14 bits: black where there is no light, the signal of half a full well in between, white at the top.
TEST(Sensor, BlackMiddleAndWhiteAtEveryBitDepth) {
  for (const int bits : {10, 12, 14}) {
    SensorOptions sensor;
    sensor.width_px = sensor.height_px = 128;
    sensor.bits = bits;
    sensor.black_level_dn = std::exp2(bits - 4);
    const double white = std::exp2(bits) - 1, gain = (white - sensor.black_level_dn) / 6000;
    const auto mean = [&](float electrons) {
      return statistics(expose(Image(128, 128, 2, electrons / 2), sensor, {0.01, 100}, 1).mosaic).mean;
    };
    // 16384 photosites; four standard errors
    EXPECT_NEAR(mean(0), sensor.black_level_dn, 4 * std::hypot(2 * gain, 0.29) / 128);
    EXPECT_NEAR(mean(3000), sensor.black_level_dn + 3000 * gain, 4 * std::sqrt(3004.0) * gain / 128);
    const Frame bright = expose(Image(128, 128, 2, 1e6f), sensor, {0.01, 200}, 1);
    for (const auto v : bright.mosaic.data) ASSERT_EQ(v, white);
    // each half has half of the well
    const double half = sensor.black_level_dn + 2 * 3000 * gain;
    EXPECT_NEAR(statistics(bright.left).mean, half, 0.01 * half);
  }
}

// The overflow of a half's well is lost, or goes to the other half's as far as that has room: counted by hand,
// electrons.
TEST(Sensor, EachHalfHasAWellOfItsOwn) {
  SensorOptions sensor = fine_sensor();
  sensor.width_px = sensor.height_px = 64;
  sensor.read_noise_e = 0;
  const double gain = gain_dn_per_electron(sensor, 100);
  struct Case {
    double spill, left_in, right_in, left, right;
  };
  for (const Case& c : {Case{0, 5000, 1000, 3000, 1000},
                        {0.5, 5000, 1000, 3000, 2000},
                        {1, 5500, 1000, 3000, 3000},
                        {1, 1000, 4500, 2500, 3000},
                        {1, 9000, 8000, 3000, 3000},
                        {1, 2500, 2900, 2500, 2900}}) {
    sensor.well_spill = c.spill;
    Image light(64, 64, 2);
    for (std::size_t i = 0; i < light.data.size(); i += 2) {
      light.data[i] = static_cast<float>(c.left_in), light.data[i + 1] = static_cast<float>(c.right_in);
    }
    const Frame frame = expose(light, sensor, {0.01, 100}, 1);
    // shot noise over 2048 photosites of a color, four standard errors, where the well is not full
    const double tolerance = gain * 4 * std::sqrt((c.left_in + c.right_in) / 2048) + 0.5;
    EXPECT_NEAR(statistics(frame.left).mean - 256, gain * c.left, tolerance) << c.spill << ' ' << c.left_in;
    EXPECT_NEAR(statistics(frame.right).mean - 256, gain * c.right, tolerance) << c.spill << ' ' << c.left_in;
    EXPECT_NEAR(statistics(frame.mosaic).mean - 256, gain * (c.left + c.right), tolerance);
  }
}

// A view's white: half of the range at ISO 100, the digital limit from ISO 200 on; and what full wells read.
TEST(Sensor, AViewsWhiteLevelIsWhereItsWellIsFull) {
  SensorOptions sensor;
  sensor.width_px = sensor.height_px = 64;
  for (const auto& [iso, white] :
       {std::pair{50.0, 64 + 959 / 4.0}, {100.0, 64 + 959 / 2.0}, {200.0, 1023.0}, {800.0, 1023.0}}) {
    const Exposure described = describe_exposure(sensor, {0.01, iso});
    ASSERT_TRUE(described.dp_white_level_dn);
    EXPECT_NEAR(*described.dp_white_level_dn, white, 1e-9);
    const Frame frame = expose(Image(64, 64, 2, 9000.0f), sensor, {0.01, iso}, 1);
    EXPECT_NEAR(statistics(frame.left).mean, white, 1);
  }
}

// What a full photosite reads: its well below ISO 100, less the dark charge that fills it and whose mean is taken off;
// the digital limit, which goes without saying, from there on. Of 4096 photosites: four standard errors of the read
// noise.
TEST(Sensor, TheMosaicsWhiteLevelIsWhereItsWellIsFull) {
  SensorOptions sensor = fine_sensor();
  sensor.width_px = sensor.height_px = 64;
  EXPECT_FALSE(describe_exposure(sensor, {0.01, 100}).mosaic_white_level_dn);
  EXPECT_FALSE(describe_exposure(sensor, {0.01, 800}).mosaic_white_level_dn);
  sensor.dark_current_e_per_s = 6000;
  for (const auto& [time_s, iso, white] : {std::tuple{1e-7, 50.0, 256 + 16127 / 2.0},
                                           {0.2, 50.0, 256 + 16127 * 0.4},
                                           {0.2, 100.0, 256 + 16127 * 0.8},
                                           {0.2, 250.0, 16383.0}}) {
    const Exposure described = describe_exposure(sensor, {time_s, iso});
    EXPECT_NEAR(described.mosaic_white_level_dn.value_or(16383), white, 1e-3);
    const Frame frame = expose(Image(64, 64, 2, 9000.0f), sensor, {time_s, iso}, 1);
    if (white < 16000) {
      EXPECT_NEAR(statistics(frame.mosaic).mean, white,
                  4 * std::hypot(2 * gain_dn_per_electron(sensor, iso), 0.29) / 64);
    } else {
      EXPECT_GE(statistics(frame.mosaic).mean, white - 1);
    }
  }
}

double covariance(const ImageU16& a, const ImageU16& b) {
  const double mean_a = statistics(a).mean, mean_b = statistics(b).mean;
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += (a.data[i] - mean_a) * (b.data[i] - mean_b);
  return sum / static_cast<double>(a.data.size());
}

SensorOptions fine_dense_sensor() {
  SensorOptions s = fine_sensor();
  s.dp_downsample_x = s.dp_downsample_y = 1;
  return s;
}

// Of read-outs sum + n and left + m, each rounded: right = sum - left + n - m. 524288 photosites: a variance has a
// standard error of 0.2 %, a covariance of 0.2 % of the variances' geometric mean; 1 % is five of these.
TEST(Sensor, RightAsSumLessLeftHasCorrelatedNoise) {
  SensorOptions sensor = fine_dense_sensor();
  sensor.readout = Readout::sum_and_left;
  const ExposureOptions exposure{0.01, 100};
  const Frame frame = expose(Image(1024, 512, 2, 0.0f), sensor, exposure, 3);
  const double read = std::pow(gain_dn_per_electron(sensor, 100) * 2, 2) + 1.0 / 12;
  EXPECT_NEAR(statistics(frame.left).variance, read, 0.01 * read);
  EXPECT_NEAR(statistics(frame.right).variance, 2 * read, 0.01 * 2 * read);
  EXPECT_NEAR(covariance(frame.left, frame.right), -read, 0.015 * read);
  EXPECT_NEAR(covariance(frame.mosaic, frame.right), read, 0.015 * read);
  EXPECT_NEAR(covariance(frame.mosaic, frame.left), 0, 0.01 * read);
  for (std::size_t i = 0; i < frame.left.data.size(); ++i) {
    ASSERT_EQ(frame.left.data[i] + frame.right.data[i], frame.mosaic.data[i] + 256);
  }
  // what matchers see is the difference
  const Exposure described = describe_exposure(sensor, exposure);
  EXPECT_NEAR(described.dp_noise.read_dn2, 2.5 * read, 1e-9);
  // where the sum clips, both views are at their white level and beyond
  const double view_white = *describe_exposure(sensor, {0.01, 800}).dp_white_level_dn;
  EXPECT_NEAR(view_white, 256 + (16383 - 256) / 2.0, 1e-9);
  const Frame clipped = expose(Image(8, 8, 2, 1e5f), sensor, {0.01, 800}, 3);
  EXPECT_GE(clipped.left.at(3, 3), view_white);
  EXPECT_GE(clipped.right.at(3, 3), view_white);

  sensor.readout = Readout::independent;
  const Frame apart = expose(Image(1024, 512, 2, 0.0f), sensor, exposure, 3);
  EXPECT_NEAR(covariance(apart.left, apart.right), 0, 0.01 * read);
  EXPECT_EQ(apart.mosaic.data, frame.mosaic.data);
  EXPECT_EQ(apart.left.data, frame.left.data);
}

/// Variance of left - right within rows, and that of the rows' means.
struct RowStatistics {
  double within = 0, between = 0;
};

RowStatistics difference_by_rows(const Frame& frame) {
  RowStatistics s;
  double mean = 0;
  const int width = frame.left.width, height = frame.left.height;
  for (int y = 0; y < height; ++y) {
    double sum = 0, squares = 0;
    for (int x = 0; x < width; ++x) {
      const double difference = frame.left.at(x, y) - frame.right.at(x, y);
      sum += difference, squares += difference * difference;
    }
    s.within += (squares - sum * sum / width) / (width - 1) / height;
    s.between += sum / width * (sum / width) / height;
    mean += sum / width / height;
  }
  s.between -= mean * mean;
  return s;
}

// The views' profile is half of the variance of left - right, of what each read-out adds and of dark current, which no
// way of reading out doubles. Right as sum - left makes it 2 left - sum: five read-outs and five rows' noise. A DP
// pixel of 2 x 4 is a mean of four, one of each row. 4096 rows of 64, or 1024 of 32: a variance within rows has a
// standard error of 0.3 or 0.8 %, one between them of 2.2 or 4.4 %; four of each.
TEST(Sensor, ViewNoiseIsHalfTheVarianceOfTheViewsDifference) {
  SensorOptions sensor = fine_sensor();
  sensor.width_px = 64;
  sensor.height_px = 4096;
  sensor.dark_current_e_per_s = 20;
  sensor.row_noise_dn = 3;
  const ExposureOptions exposure{1, 100};
  const double gain2 = std::pow(gain_dn_per_electron(sensor, 100), 2), read = gain2 * 4, dark = gain2 * 10, row = 9;
  for (const Readout readout : {Readout::independent, Readout::sum_and_left}) {
    for (const bool dense : {true, false}) {
      sensor.readout = readout;
      sensor.dp_downsample_x = dense ? 1 : 2;
      sensor.dp_downsample_y = dense ? 1 : 4;
      const double readouts = readout == Readout::independent ? 1 : 2.5, of = dense ? 1 : 4;
      const double within = (readouts * read + dark) / of + readouts / 12, between = readouts * row / of;
      EXPECT_NEAR(describe_exposure(sensor, exposure).dp_noise.read_dn2, within + between, 1e-9);
      const Frame frame = expose(Image(64, 4096, 2, 0.0f), sensor, exposure, 3);
      const RowStatistics found = difference_by_rows(frame);
      const double rows = frame.left.height, pixels = rows * frame.left.width;
      EXPECT_NEAR(found.within / (2 * within), 1, 4 * std::sqrt(2 / pixels));
      const double means = 2 * (between + within / frame.left.width);
      EXPECT_NEAR(found.between / means, 1, 4 * std::sqrt(2 / rows));
    }
  }
}

// A row's mean varies by the row noise (and by a 1024th of the read noise's variance); 512 rows: a deviation has a
// standard error of 3.1 %, and a correlation one of 4.4 %; four of each.
TEST(Sensor, RowsShareTheNoiseOfTheirReadOut) {
  SensorOptions sensor = fine_dense_sensor();
  sensor.row_noise_dn = 3;
  const ExposureOptions exposure{0.01, 100};
  const Frame frame = expose(Image(1024, 512, 2, 0.0f), sensor, exposure, 3);
  const double read = std::pow(gain_dn_per_electron(sensor, 100) * 2, 2) + 1.0 / 12;
  std::vector<double> means[2];
  for (int y = 0; y < 512; ++y) {
    for (int i = 0; i < 2; ++i) {
      const std::uint16_t* row = (i == 0 ? frame.mosaic : frame.left).row(y);
      means[i].push_back(std::accumulate(row, row + 1024, 0.0) / 1024 - 256);
    }
  }
  double squares = 0, product = 0;
  for (int y = 0; y < 512; ++y) squares += means[0][y] * means[0][y] / 512, product += means[0][y] * means[1][y] / 512;
  EXPECT_NEAR(std::sqrt(squares - read / 1024) / 3, 1, 4 * 0.031);
  EXPECT_NEAR(product / 9, 0, 4 * 0.044);
  EXPECT_NEAR(statistics(frame.mosaic).variance - squares, read, 0.01 * read);
  EXPECT_NEAR(describe_exposure(sensor, exposure).mosaic_noise.read_dn2, read + 9, 1e-9);
  EXPECT_NE(expose(Image(1024, 512, 2, 0.0f), sensor, exposure, 4).mosaic.data, frame.mosaic.data);
}

// 20 e/s at 25 C doubled every 8 degrees, half a second at 41 C: 40 electrons of a photosite, 20 of each half. Their
// mean is taken off, their shot noise stays. 1 % as above.
TEST(Sensor, DarkCurrentGrowsWithTimeAndTemperatureAndLeavesItsShotNoise) {
  SensorOptions sensor = fine_dense_sensor();
  sensor.dark_current_e_per_s = 20;
  sensor.temperature_c = 41;
  const ExposureOptions exposure{0.5, 100};
  EXPECT_NEAR(dark_electrons(sensor, exposure), 40, 1e-12);
  const Frame frame = expose(Image(1024, 512, 2, 0.0f), sensor, exposure, 3);
  const double gain2 = std::pow(gain_dn_per_electron(sensor, 100), 2), photosites = 1024 * 512;
  const double whole = gain2 * (40 + 4) + 1.0 / 12, half = gain2 * (20 + 4) + 1.0 / 12;
  EXPECT_NEAR(statistics(frame.mosaic).mean, 256, 4 * std::sqrt(whole / photosites));
  EXPECT_NEAR(statistics(frame.left).mean, 256, 4 * std::sqrt(half / photosites));
  EXPECT_NEAR(statistics(frame.mosaic).variance, whole, 0.01 * whole);
  EXPECT_NEAR(statistics(frame.right).variance, half, 0.01 * half);
  EXPECT_NEAR(describe_exposure(sensor, exposure).mosaic_noise.read_dn2, whole, 1e-9);
  EXPECT_NEAR(describe_exposure(sensor, exposure).dp_noise.read_dn2, half, 1e-9);
  // it frees electrons without light: sensitivity has no part in it
  sensor.prnu = 0.1;
  EXPECT_EQ(expose(Image(1024, 512, 2, 0.0f), sensor, exposure, 3).mosaic.data, frame.mosaic.data);
}

// 1 % of the photosites leak 2000 e/s on the average, exponentially: after 0.1 s the share beyond 400 electrons is
// exp(-2) of them. 709 are expected, give or take 27; the mean of all, 2 electrons, has a standard error of 2 %.
TEST(Sensor, HotPixelsLeakInTheSamePlacesOfEveryFrame) {
  SensorOptions sensor = fine_dense_sensor();
  sensor.hot_pixel_share = 0.01;
  sensor.hot_pixel_e_per_s = 2000;
  const Image dark(1024, 512, 2, 0.0f);
  const Frame first = expose(dark, sensor, {0.1, 100}, 3), second = expose(dark, sensor, {0.1, 100}, 4);
  const double gain = gain_dn_per_electron(sensor, 100), photosites = 1024 * 512;
  EXPECT_NEAR((statistics(first.mosaic).mean - 256) / gain / 2, 1, 0.08);
  sensor.fixed_pattern_seed = 2;
  const Frame other = expose(dark, sensor, {0.1, 100}, 3);
  sensor.fixed_pattern_seed = 1;
  int hot = 0, left_hot = 0, stayed = 0, of_other = 0;
  for (std::size_t i = 0; i < first.mosaic.data.size(); ++i) {
    if (first.mosaic.data[i] < 256 + 400 * gain) continue;
    ++hot;
    left_hot += first.left.data[i] > 256 + 200 * gain;
    EXPECT_NE(first.left.data[i] > 256 + 200 * gain, first.right.data[i] > 256 + 200 * gain);
    stayed += second.mosaic.data[i] > 256 + 250 * gain;
    of_other += other.mosaic.data[i] > 256 + 250 * gain;
  }
  EXPECT_NEAR(hot, photosites * 0.01 * std::exp(-2), 4 * 27);
  EXPECT_NEAR(left_hot, hot / 2, 4 * std::sqrt(hot) / 2);
  EXPECT_EQ(stayed, hot);
  // another camera's lie elsewhere: by chance .01 exp(-1.25) of the places, 2 of 709, and four times the root of that
  EXPECT_LT(of_other, 8);
  // 8 degrees more double the leakage
  sensor.temperature_c = 33;
  EXPECT_EQ(expose(dark, sensor, {0.05, 100}, 3).mosaic.data, first.mosaic.data);
}

// What a filter sees is its row of the matrix; the capture's white balance and matrix lead back to the scene's colors,
// with what the illuminant makes white at 1, 1, 1.
TEST(Sensor, StatesHowToUndoItsColors) {
  SensorOptions sensor;
  sensor.width_px = sensor.height_px = 4;
  sensor.color_matrix = {0.7, 0.25, 0.05, 0.2, 0.7, 0.1, 0.02, 0.28, 0.7};
  sensor.illuminant = {1.3, 1, 0.6};
  const double reflectance[3] = {0.5, 0.2, 0.8};
  Image half(4, 4, 3);
  for (int i = 0; i < 16; ++i) {
    for (int c = 0; c < 3; ++c) half.data[3 * i + c] = static_cast<float>(reflectance[c] * sensor.illuminant[c]);
  }
  const Image electrons = expected_electrons(half, half, sensor, {0.01, 100}, 1);
  const Exposure described = describe_exposure(sensor, {0.01, 100});
  double balanced[3];
  const std::pair<int, int> photosites[3] = {{0, 0}, {1, 0}, {1, 1}};
  for (int c = 0; c < 3; ++c) {
    const auto [x, y] = photosites[c];
    double seen = 0;
    for (int k = 0; k < 3; ++k) seen += sensor.color_matrix[3 * c + k] * half.data[k];
    EXPECT_NEAR(electrons.at(x, y, 0), 0.01 * sensor.electrons_per_lux_s[c] * seen, 1e-4);
    balanced[c] = 2 * electrons.at(x, y, 0) * described.white_balance[c];
  }
  ASSERT_TRUE(described.color_matrix);
  // one electron of green is 1 / 6000 of full scale, which stands for lux_s_per_unit of the scene's white
  for (int c = 0; c < 3; ++c) {
    double rgb = 0;
    for (int k = 0; k < 3; ++k) rgb += (*described.color_matrix)[3 * c + k] * balanced[k];
    EXPECT_NEAR(rgb / 6000 * described.lux_s_per_unit, 2 * 0.01 * reflectance[c], 1e-6) << c;
  }
  EXPECT_FALSE(describe_exposure(fine_sensor(), {0.01, 100}).color_matrix);
}

// A filter whose row takes more of a color than it sees gathers nothing, not what would be missing.
TEST(Sensor, AFilterNeverSeesLessThanNothing) {
  SensorOptions sensor;
  sensor.width_px = sensor.height_px = 4;
  sensor.color_matrix = {1.5, -0.5, 0, 0, 1, 0, 0, 0, 1};
  Image green(4, 4, 3);
  for (int i = 0; i < 16; ++i) green.data[3 * i + 1] = 1;
  const Image electrons = expected_electrons(green, green, sensor, {0.01, 100}, 1);
  EXPECT_EQ(electrons.at(0, 0, 0), 0);
  EXPECT_EQ(electrons.at(0, 0, 1), 0);
  EXPECT_FLOAT_EQ(electrons.at(1, 0, 0), 40);
}

// Dense DP: every half-photosite on its own; and what is binned is the mean of the same read-outs.
TEST(Sensor, DenseViewsHoldEveryHalfPhotosite) {
  SensorOptions sensor = fine_sensor();
  sensor.width_px = sensor.height_px = 64;
  Image light(64, 64, 2, 400.0f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) light.at(x, y, 0) = 100.0f * (1 + cfa_color(x, y));
  }
  const Frame binned = expose(light, sensor, {0.01, 100}, 9);
  sensor.dp_downsample_y = 2;
  const Frame twice = expose(light, sensor, {0.01, 100}, 9);
  sensor.dp_downsample_x = sensor.dp_downsample_y = 1;
  const Frame dense = expose(light, sensor, {0.01, 100}, 9);
  EXPECT_EQ(dense.mosaic.data, binned.mosaic.data);
  ASSERT_EQ(dense.left.width, 64);
  ASSERT_EQ(twice.left.height, 32);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      double sum = 0;
      for (int j = 0; j < 4; ++j) sum += dense.left.at(2 * x + ((j & 1) ? 0 : 1), 4 * y + j);
      EXPECT_NEAR(binned.left.at(x, y), sum / 4, 1);  // five roundings
      EXPECT_NEAR(binned.left.at(x, y), (twice.left.at(x, 2 * y) + twice.left.at(x, 2 * y + 1)) / 2.0, 1.01);
    }
  }
  const Exposure described = describe_exposure(sensor, {0.01, 100});
  EXPECT_EQ(described.dp_noise.shot_dn, described.mosaic_noise.shot_dn);
}

}  // namespace
}  // namespace dualpixel::simulator
