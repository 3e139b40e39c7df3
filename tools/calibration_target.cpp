#include "tools/calibration_target.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "simulator/lens/disparity_field.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::tools {
namespace {

using simulator::kPacket;

constexpr int kTexelPx = 2;    ///< width of a texel on the sensor, photosites
constexpr int kTexels = 1024;  ///< a side of the texture, which repeats
constexpr int kOctaves = 3;

/// Noise in cells of `cell` texels, smooth in between, added to `texture`.
void add_octave(Image& texture, int cell, std::uint64_t seed) {
  const int cells = kTexels / cell;
  const auto level = [&](int i, int j) {
    const auto bits = simulator::hash(seed, static_cast<std::uint64_t>(cell), (j % cells) * cells + i % cells);
    return simulator::unit_float(static_cast<std::uint32_t>(bits >> 32)) - 0.5f;
  };
  const auto ease = [](float t) { return t * t * t * (t * (6 * t - 15) + 10); };
  tbb::parallel_for(0, kTexels, [&](int y) {
    const int j = y / cell;
    const float v = ease((static_cast<float>(y % cell) + 0.5f) / static_cast<float>(cell));
    for (int x = 0; x < kTexels; ++x) {
      const int i = x / cell;
      const float u = ease((static_cast<float>(x % cell) + 0.5f) / static_cast<float>(cell));
      const float top = level(i, j) + u * (level(i + 1, j) - level(i, j));
      const float bottom = level(i, j + 1) + u * (level(i + 1, j + 1) - level(i, j + 1));
      texture.at(x, y) += top + v * (bottom - top);
    }
  });
}

constexpr int kLightDegree = 8;
constexpr int kLightNodes = 41;  ///< a side, where the shading is traced

/// Terms x^i y^j, i + j <= kLightDegree, of a place in half widths and half heights from the middle.
std::vector<double> light_terms(double x, double y) {
  std::vector<double> terms;
  for (int i = 0; i <= kLightDegree; ++i) {
    for (int j = 0; i + j <= kLightDegree; ++j) terms.push_back(std::pow(x, i) * std::pow(y, j));
  }
  return terms;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Mean 0.5, within 0.1 .. 0.9.
Image make_texture(const CalibrationTarget& target) {
  Image texture(kTexels, kTexels);
  for (int octave = 0; octave < kOctaves; ++octave)
    add_octave(texture, target.finest_px / kTexelPx << octave, target.texture_seed);
  for (float& value : texture.data) value = std::clamp(0.5f + 0.4f * value, 0.1f, 0.9f);
  return texture;
}

}  // namespace

TargetCamera make_target_camera(const simulator::LensSampler& lens, int width, int height) {
  const simulator::SensorGrid& sensor = lens.sensor();
  Eigen::MatrixXd terms(kLightNodes * kLightNodes, light_terms(0, 0).size());
  Eigen::MatrixXd light(kLightNodes * kLightNodes, 2);
  tbb::parallel_for(0, kLightNodes * kLightNodes, [&](int k) {
    const int x = (k % kLightNodes) * (sensor.width_px - 1) / (kLightNodes - 1);
    const int y = (k / kLightNodes) * (sensor.height_px - 1) / (kLightNodes - 1);
    const std::vector<double> row =
        light_terms(2 * (x + 0.5) / sensor.width_px - 1, 2 * (y + 0.5) / sensor.height_px - 1);
    terms.row(k) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), static_cast<Eigen::Index>(row.size()));
    const simulator::DisparityCoefficients c = simulator::trace_disparity(lens, x, y, 1024);
    light.row(k) << c.left_light, c.right_light;
  });
  const Eigen::MatrixXd fit = terms.colPivHouseholderQr().solve(light);
  const auto column = [&](int k) { return std::vector<double>(fit.col(k).begin(), fit.col(k).end()); };
  return {lens, width, height, column(0), column(1)};
}

TargetViews render_target(const TargetCamera& camera, const CalibrationTarget& target, int rays) {
  const simulator::LensSampler& lens = camera.lens;
  const simulator::SensorGrid& sensor = lens.sensor();
  const int width = camera.width, height = camera.height;
  const Image texture = make_texture(target);
  // z = distance + a x + b y; along a ray, x = origin + slope z
  const auto a = static_cast<float>(std::tan(target.tilt_x_deg * M_PI / 180));
  const auto b = static_cast<float>(std::tan(target.tilt_y_deg * M_PI / 180));
  const auto distance = static_cast<float>(target.distance_m);
  const auto texels_per_m =
      static_cast<float>(lens.lens().thin.image_distance_m() / (target.distance_m * kTexelPx * sensor.pixel_pitch_m));
  TargetViews views{Image(width, height), Image(width, height)};
  const float wide = static_cast<float>(sensor.width_px) / static_cast<float>(width);  // of a pixel, photosites
  const float high = static_cast<float>(sensor.height_px) / static_cast<float>(height);
  tbb::parallel_for(0, height, [&](int y) {
    alignas(64) float s[4][kPacket];
    alignas(64) float level[kPacket];
    simulator::LensPacket packet;
    const int middle_y = static_cast<int>((static_cast<float>(y) + 0.5f) * high);
    const float from_y = static_cast<float>(y) * high - static_cast<float>(middle_y);
    for (int x = 0; x < width; ++x) {
      const std::uint64_t key = simulator::hash(target.texture_seed, static_cast<std::uint64_t>(y) << 32 | x);
      // the rays of the photosite in the middle, spread over the pixel: the lens hardly changes within it
      const int middle_x = static_cast<int>((static_cast<float>(x) + 0.5f) * wide);
      const float from_x = static_cast<float>(x) * wide - static_cast<float>(middle_x);
      float left = 0, right = 0, left_weight = 0, right_weight = 0;
      for (int first = 0; first < rays; first += kPacket) {
        simulator::mirrored_samples(first / 2, key, s);
        for (int i = 0; i < kPacket; ++i) {
          s[0][i] = from_x + s[0][i] * wide;
          s[1][i] = from_y + s[1][i] * high;
        }
        lens.sample(middle_x, middle_y, 1, s, packet);
        for (int i = 0; i < kPacket; ++i) {
          const float t = (distance + a * packet.origin_x[i] + b * packet.origin_y[i]) /
                          (1 - a * packet.slope_x[i] - b * packet.slope_y[i]);
          const float u = (packet.origin_x[i] + t * packet.slope_x[i]) * texels_per_m + 0.5f * kTexels;
          const float v = (packet.origin_y[i] + t * packet.slope_y[i]) * texels_per_m + 0.5f * kTexels;
          const float floor_u = std::floor(u), floor_v = std::floor(v);
          const int column = static_cast<int>(floor_u) & (kTexels - 1), row = static_cast<int>(floor_v) & (kTexels - 1);
          const int next_column = (column + 1) & (kTexels - 1), next_row = (row + 1) & (kTexels - 1);
          const float fu = u - floor_u, fv = v - floor_v;
          const float* texels = texture.data.data();
          const float t00 = texels[row * kTexels + column], t10 = texels[row * kTexels + next_column];
          const float t01 = texels[next_row * kTexels + column], t11 = texels[next_row * kTexels + next_column];
          const float top = t00 + fu * (t10 - t00), bottom = t01 + fu * (t11 - t01);
          level[i] = top + fv * (bottom - top);
        }
        for (int i = 0; i < kPacket; ++i) {
          left += packet.left[i] * level[i];
          right += packet.right[i] * level[i];
          left_weight += packet.left[i];
          right_weight += packet.right[i];
        }
      }
      const std::vector<double> terms = light_terms(2 * (x + 0.5) / width - 1, 2 * (y + 0.5) / height - 1);
      views.left.at(x, y) =
          left_weight > 0 ? static_cast<float>(dot(terms, camera.left_light)) * left / left_weight : 0;
      views.right.at(x, y) =
          right_weight > 0 ? static_cast<float>(dot(terms, camera.right_light)) * right / right_weight : 0;
    }
  });
  return views;
}

}  // namespace dualpixel::tools
