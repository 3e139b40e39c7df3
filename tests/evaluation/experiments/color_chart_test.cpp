// A color chart before a tinted sensor, developed by libraw from the DNG's tags and by the pipeline from the capture.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "capture/dng.h"
#include "capture/image/demosaic.h"
#include "capture/image/image_io.h"
#include "simulator/sensor/sensor.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

using Color = std::array<double, 3>;

/// The 24 patches of the ColorChecker, 8-bit sRGB, as its maker gives them.
constexpr double kChart[24][3] = {{115, 82, 68},   {194, 150, 130}, {98, 122, 157}, {87, 108, 67},   {133, 128, 177},
                                  {103, 189, 170}, {214, 126, 44},  {80, 91, 166},  {193, 90, 99},   {94, 60, 108},
                                  {157, 188, 64},  {224, 163, 46},  {56, 61, 150},  {70, 148, 73},   {175, 54, 60},
                                  {231, 199, 31},  {187, 86, 149},  {8, 133, 161},  {243, 243, 242}, {200, 200, 200},
                                  {160, 160, 160}, {122, 122, 121}, {85, 85, 85},   {52, 52, 52}};
constexpr int kColumns = 6, kRows = 4, kPatchPx = 48;

double linear(double srgb8) {
  const double v = srgb8 / 255;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

Color chart_color(int patch) { return {linear(kChart[patch][0]), linear(kChart[patch][1]), linear(kChart[patch][2])}; }

/// CIE L*a*b* 1976 of linear sRGB, D65.
Color lab(const Color& rgb) {
  constexpr double kXyz[3][3] = {{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}};
  double f[3];
  for (int i = 0; i < 3; ++i) {
    double value = 0, white = 0;
    for (int c = 0; c < 3; ++c) value += kXyz[i][c] * rgb[c], white += kXyz[i][c];
    const double t = value / white;
    f[i] = t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116;
  }
  return {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
}

double delta_e(const Color& a, const Color& b) {
  const Color p = lab(a), q = lab(b);
  return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

/// The chart, evenly lit by the sensor's illuminant so that a reflectance of 1 fills a green photosite.
Capture chart_capture(const simulator::SensorOptions& sensor) {
  Capture capture;
  capture.camera.name = "chart";
  capture.camera.focal_length_mm = 4.4, capture.camera.f_number = 1.8, capture.camera.focus_distance_m = 1;
  simulator::describe_sensor(sensor, capture.camera);
  const simulator::ExposureOptions exposure{0.01, 100};
  capture.exposure = describe_exposure(sensor, exposure);
  Image half(sensor.width_px, sensor.height_px, 3);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const Color color = chart_color(y / kPatchPx * kColumns + x / kPatchPx);
      for (int c = 0; c < 3; ++c) half.at(x, y, c) = static_cast<float>(0.5 * color[c] * sensor.illuminant[c]);
    }
  }
  const double lux_per_nit = capture.exposure.lux_s_per_unit / exposure.time_s;
  capture.frames = {expose(expected_electrons(half, half, sensor, exposure, lux_per_nit), sensor, exposure, 1)};
  return capture;
}

/// The largest difference of a patch's mean color from the chart's; `rgb` is linear.
double worst_difference(const Image& rgb) {
  constexpr int kMargin = 8;
  double worst = 0;
  for (int patch = 0; patch < kColumns * kRows; ++patch) {
    const int x0 = patch % kColumns * kPatchPx, y0 = patch / kColumns * kPatchPx;
    Color mean{};
    constexpr int kSide = kPatchPx - 2 * kMargin;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        for (int c = 0; c < 3; ++c) mean[c] += rgb.at(x0 + kMargin + x, y0 + kMargin + y, c) / (1.0 * kSide * kSide);
      }
    }
    worst = std::max(worst, delta_e(mean, chart_color(patch)));
  }
  return worst;
}

simulator::SensorOptions tinted_sensor() {
  simulator::SensorOptions sensor;
  sensor.width_px = kColumns * kPatchPx;
  sensor.height_px = kRows * kPatchPx;
  sensor.full_well_e = 60000;  // so that noise is none of what differs
  sensor.bits = 14;
  sensor.black_level_dn = 512;
  sensor.color_matrix = {0.70, 0.25, 0.05, 0.18, 0.72, 0.10, 0.03, 0.27, 0.70};
  return sensor;
}

constexpr double kIlluminants[][3] = {{1, 1, 1}, {1.35, 1, 0.55}};

TEST(ColorChart, ThePipelineUndoesTheSensorsColors) {
  for (const auto& white : kIlluminants) {
    simulator::SensorOptions sensor = tinted_sensor();
    sensor.illuminant = {white[0], white[1], white[2]};
    const Capture capture = chart_capture(sensor);
    const Image balanced = white_balanced(normalized(capture.frames[0].mosaic, capture.exposure), capture.camera.cfa,
                                          capture.exposure.white_balance);
    const Image rgb = demosaic(balanced, capture.camera.cfa);
    EXPECT_LT(worst_difference(in_srgb(rgb, capture.exposure.color_matrix)), 1);
    EXPECT_GT(worst_difference(rgb), 10);
  }
}

TEST(ColorChart, LibrawDevelopsItWithinTwoUnitsOfColorDifference) {
  if (std::system("command -v dcraw_emu >/dev/null 2>&1") != 0) GTEST_SKIP() << "dcraw_emu of libraw-bin is missing";
  for (const auto& illuminant : kIlluminants) {
    simulator::SensorOptions sensor = tinted_sensor();
    sensor.illuminant = {illuminant[0], illuminant[1], illuminant[2]};
    const Capture capture = chart_capture(sensor);
    const TemporaryFolder folder;
    const std::string file = folder / "chart.dng";
    write_dng(file, capture.frames[0].mosaic, capture, DngImage::mosaic);
    // camera white balance, linear 16 bits, sRGB primaries, bilinear; levels as the tags have them
    ASSERT_EQ(std::system(("dcraw_emu -4 -T -w -o 1 -q 0 -c 0 '" + file + "' >/dev/null 2>&1").c_str()), 0);
    Image rgb = read_image(file + ".tiff");
    // its white is where the first color clips: at the smallest gain
    const auto& gains = capture.exposure.white_balance;
    const auto white = static_cast<float>(*std::min_element(gains.begin(), gains.end()));
    for (float& value : rgb.data) value *= white;
    EXPECT_LT(worst_difference(rgb), 2);
  }
}

}  // namespace
}  // namespace dualpixel
