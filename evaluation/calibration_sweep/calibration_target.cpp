#include "evaluation/calibration_sweep/calibration_target.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::evaluation {
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

/// Terms x^i y^j, i + j <= kLightDegree, of a position in half widths and half heights from the center.
Eigen::RowVectorXd light_terms(double x, double y) {
  Eigen::RowVectorXd terms((kLightDegree + 1) * (kLightDegree + 2) / 2);
  int k = 0;
  double power_x = 1;
  for (int i = 0; i <= kLightDegree; ++i, power_x *= x) {
    double power = power_x;
    for (int j = 0; i + j <= kLightDegree; ++j, power *= y) terms[k++] = power;
  }
  return terms;
}

/// Bilinear between texels; u and v are in texels.
float texture_at(const Image& texture, float u, float v) {
  const float floor_u = std::floor(u), floor_v = std::floor(v);
  const int column = static_cast<int>(floor_u) & (kTexels - 1), row = static_cast<int>(floor_v) & (kTexels - 1);
  const int next_column = (column + 1) & (kTexels - 1), next_row = (row + 1) & (kTexels - 1);
  const float fu = u - floor_u, fv = v - floor_v;
  const float* texels = texture.data.data();
  const float t00 = texels[row * kTexels + column], t10 = texels[row * kTexels + next_column];
  const float t01 = texels[next_row * kTexels + column], t11 = texels[next_row * kTexels + next_column];
  const float top = t00 + fu * (t10 - t00), bottom = t01 + fu * (t11 - t01);
  return top + fv * (bottom - top);
}

/// The target in camera axes.
struct Plane {
  float distance_m = 0, tangent = 0;  ///< z = distance + tangent x
  float texels_per_m = 0;

  /// What one of a packet's rays sees: along a ray, x = origin + slope z.
  float look_up(const Image& texture, const simulator::LensPacket& rays, int i) const {
    const float z = (distance_m + tangent * rays.origin_x[i]) / (1 - tangent * rays.slope_x[i]);
    return texture_at(texture, (rays.origin_x[i] + z * rays.slope_x[i]) * texels_per_m + 0.5f * kTexels,
                      (rays.origin_y[i] + z * rays.slope_y[i]) * texels_per_m + 0.5f * kTexels);
  }
};

}  // namespace

TargetPrint print_target(const CalibrationTarget& target, const simulator::LensSampler& lens) {
  Image texture(kTexels, kTexels);
  for (int octave = 0; octave < kOctaves; ++octave) {
    add_octave(texture, target.finest_px / kTexelPx << octave, target.texture_seed);
  }
  for (float& value : texture.data) value = std::clamp(0.5f + 0.4f * value, 0.1f, 0.9f);
  const double texel_on_sensor_m = kTexelPx * lens.sensor().pixel_pitch_m;
  return {std::move(texture), texel_on_sensor_m * target.distance_m / lens.lens().thin.image_distance_m()};
}

TargetCamera make_target_camera(const simulator::LensSampler& lens, int width, int height) {
  const simulator::SensorGrid& sensor = lens.sensor();
  Eigen::MatrixXd terms(kLightNodes * kLightNodes, light_terms(0, 0).size());
  Eigen::MatrixXd light(kLightNodes * kLightNodes, 2);
  tbb::parallel_for(0, kLightNodes * kLightNodes, [&](int k) {
    const int x = (k % kLightNodes) * (sensor.width_px - 1) / (kLightNodes - 1);
    const int y = (k / kLightNodes) * (sensor.height_px - 1) / (kLightNodes - 1);
    terms.row(k) = light_terms(2 * (x + 0.5) / sensor.width_px - 1, 2 * (y + 0.5) / sensor.height_px - 1);
    const simulator::DisparityCoefficients c = simulator::trace_disparity(lens, x, y, 1024);
    light.row(k) << c.left_light, c.right_light;
  });
  const Eigen::MatrixXd fit = terms.colPivHouseholderQr().solve(light);
  TargetCamera camera{lens, width, height, Image(width, height), Image(width, height)};
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::RowVector2d here = light_terms(2 * (x + 0.5) / width - 1, 2 * (y + 0.5) / height - 1) * fit;
      // a polynomial may overshoot beside a dark corner
      camera.left_light.at(x, y) = static_cast<float>(std::max(here[0], 0.0));
      camera.right_light.at(x, y) = static_cast<float>(std::max(here[1], 0.0));
    }
  });
  return camera;
}

TargetViews render_target(const TargetCamera& camera, const CalibrationTarget& target, int rays) {
  const simulator::LensSampler& lens = camera.lens;
  const simulator::SensorGrid& sensor = lens.sensor();
  const int width = camera.width, height = camera.height;
  const TargetPrint print = print_target(target, lens);
  const Plane plane = {static_cast<float>(target.distance_m),
                       static_cast<float>(std::tan(target.tilt_x_deg * std::numbers::pi / 180)),
                       static_cast<float>(1 / print.texel_m)};
  TargetViews views{Image(width, height), Image(width, height)};
  const float wide = static_cast<float>(sensor.width_px) / static_cast<float>(width);  // of a pixel, photosites
  const float high = static_cast<float>(sensor.height_px) / static_cast<float>(height);
  tbb::parallel_for(0, height, [&](int y) {
    alignas(64) float s[4][kPacket];
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
          if (packet.left[i] + packet.right[i] == 0) continue;  // blocked: where it would go may not be a number
          const float level = plane.look_up(print.texture, packet, i);
          left += packet.left[i] * level;
          right += packet.right[i] * level;
          left_weight += packet.left[i];
          right_weight += packet.right[i];
        }
      }
      views.left.at(x, y) = left_weight > 0 ? camera.left_light.at(x, y) * left / left_weight : 0;
      views.right.at(x, y) = right_weight > 0 ? camera.right_light.at(x, y) * right / right_weight : 0;
    }
  });
  return views;
}

}  // namespace dualpixel::evaluation
