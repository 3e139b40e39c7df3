// What diffraction does to disparity near the focus, where blur is no wider than the Airy pattern.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/tile_disparity.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel {
namespace {

/// A wall of random cells across the view; the finest is two photosites wide at 0.9 m.
simulator::Scene textured_plane(double depth_m) {
  simulator::Texture texture{1024, 1024};
  for (int y = 0; y < 1024; ++y) {
    for (int x = 0; x < 1024; ++x) {
      double sum = 0;
      for (const int cell : {2, 4, 8, 16}) {
        const auto value = simulator::hash(9, cell, (y / cell) * 1024 + x / cell);
        sum += simulator::unit_float(static_cast<std::uint32_t>(value >> 32)) - 0.5;
      }
      const auto level = static_cast<std::uint8_t>(std::lround(255 * std::clamp(0.5 + 0.3 * sum, 0.0, 1.0)));
      texture.rgba.insert(texture.rgba.end(), {level, level, level, 255});
    }
  }
  simulator::Scene scene = simulator::testing::shining_picture(std::move(texture), 600);
  const auto half = static_cast<float>(512 * 1.4e-6 * 0.9 / 4.464e-3), z = static_cast<float>(-depth_m);
  scene.meshes = {simulator::testing::make_quad({-half, -half, z}, {2 * half, 0, 0}, {0, 2 * half, 0}, 0)};
  return scene;
}

struct Error {
  double truth = 0;  ///< the wall's disparity
  double mean = 0, rms = 0;
  double contrast = 0;  ///< of the left view before noise: standard deviation over mean
};

double contrast_of(const Image& rgb) {
  double sum = 0, squares = 0, count = 0;
  for (std::size_t i = 1; i < rgb.data.size(); i += 3)
    sum += rgb.data[i], squares += rgb.data[i] * rgb.data[i], ++count;
  return std::sqrt(squares / count - sum / count * (sum / count)) / (sum / count);
}

Capture capture_of_wall(double depth_m, bool diffraction) {
  const nlohmann::json document = {
      {"version", 1},
      {"gltf", "none"},
      {"camera", {{"focus_distance_m", 0.9}}},
      {"lens", {{"diffraction", diffraction}}},
      {"sensor", {{"width_px", 512}, {"height_px", 384}}},
      {"exposure", {{"time_s", 0.004}}},
      {"burst", {{"frames", 1}}},
      {"render",
       {{"samples_per_pixel", 64}, {"photograph_samples_per_pixel", 1}, {"all_in_focus_samples_per_pixel", 1}}}};
  return simulate(simulator::read_simulation(document, "test.json"), textured_plane(depth_m));
}

/// Of the tiles away from the border.
Error disparity_error(const Capture& capture, const pipeline::Matcher& matcher) {
  const Frame& frame = capture.frames[0];
  const pipeline::TileDisparity tiles =
      matcher.match(normalized(frame.left, capture.exposure), normalized(frame.right, capture.exposure),
                    pipeline::view_sensor(capture.exposure), {});
  const double truth = capture.truth->disparity_dp_px.at(256, 192);
  Error error;
  double count = 0;
  for (int row = 1; row + 1 < tiles.disparity_dp_px.height; ++row) {
    for (int column = 2; column + 2 < tiles.disparity_dp_px.width; ++column) {
      const double e = tiles.disparity_dp_px.at(column, row) - truth;
      error.mean += e, error.rms += e * e, count += 1;
    }
  }
  return {truth, error.mean / count, std::sqrt(error.rms / count), contrast_of(capture.truth->left)};
}

// The figures of docs/camera_effects.md. The Airy pattern is narrower than a DP pixel at f/1.8: it takes contrast, and
// pulls what is measured towards 0 by some hundredths of a pixel, as blur that both views have in common does: always
// that way where there is disparity to speak of. How far is a regression: the largest of the document's figures,
// rounded up.
TEST(SweepDiffraction, CostsLittleDisparityNearTheFocus) {
  for (const double depth_m : {0.7, 0.8, 0.86, 0.9, 0.95, 1.1, 1.3}) {
    const Capture without = capture_of_wall(depth_m, false), with = capture_of_wall(depth_m, true);
    for (const pipeline::Matcher& matcher : pipeline::matchers()) {
      const Error off = disparity_error(without, matcher), on = disparity_error(with, matcher);
      std::printf("%-10s %.2f m: without %+.3f, %.3f; with %+.3f, %.3f\n", matcher.name.data(), depth_m, off.mean,
                  off.rms, on.mean, on.rms);
      // In focus the finest cells, 2.8 um wide, hold a quarter of the variance; at their 0.18 cycles/um the Airy
      // pattern's transfer is 0.78 (cutoff 1.03). So contrast falls by 1 - sqrt(1 - (1 - .78^2)/4) = 5 % or more;
      // rays without diffraction would leave it within the 64 samples' noise.
      if (depth_m == 0.9) {
        EXPECT_LT(on.contrast, 0.97 * off.contrast) << matcher.name;
      }
      if (std::abs(off.truth) > 0.15) {
        EXPECT_GT((off.mean - on.mean) * off.truth, 0) << matcher.name << ' ' << depth_m;
      }
      EXPECT_LT(on.rms, off.rms + (depth_m == 0.9 ? 0.006 : 0.037)) << matcher.name << ' ' << depth_m;
      EXPECT_LT(std::abs(on.mean - off.mean), 0.047) << matcher.name << ' ' << depth_m;
    }
  }
}

}  // namespace
}  // namespace dualpixel
