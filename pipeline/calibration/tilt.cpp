#include "pipeline/calibration/tilt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "pipeline/calibration/nodes.h"

namespace dualpixel::pipeline {
namespace {

using Targets = std::vector<const TargetMeasurement*>;

/// Disparity's slope against inverse depth at one node by all targets but one; 0 where it cannot be estimated.
double slope_without(const Targets& targets, std::size_t node, const TargetMeasurement* left_out) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const TargetMeasurement* target : targets) {
    if (target == left_out || target->usable.data[node] == 0) continue;
    const double inverse = 1 / target->target_distance_m, d = target->disparity_dp_px.data[node];
    n += 1, x += inverse, y += d, xx += inverse * inverse, xy += inverse * d;
  }
  const double variance = n * xx - x * x;
  return n >= 2 && variance > 1e-9 * n * xx ? (n * xy - x * y) / variance : 0;
}

struct Tangents {
  double x = 0, y = 0;
};

Tangents tangents_without(const Camera& camera, const Targets& targets, const TargetMeasurement* left_out) {
  const double image_distance_mm =
      camera.focal_length_mm / (1 - 1e-3 * camera.focal_length_mm / targets.front()->focus_distance_m);
  const double per_px = 1e-3 * camera.pixel_pitch_um / image_distance_mm;
  const std::size_t last = static_cast<std::size_t>(kCalibrationColumns) * kCalibrationRows - 1;
  double uu = 0, uv = 0, vv = 0, ue = 0, ve = 0;
  for (std::size_t node = 0; node <= last / 2; ++node) {  // the other half are their mirror images
    const double here = slope_without(targets, node, left_out);
    const double opposite = slope_without(targets, last - node, left_out);
    if (here == 0 || opposite == 0) continue;
    const double even = 0.5 * (here + opposite), odd = 0.5 * (here - opposite);
    const int column = node % kCalibrationColumns, row = node / kCalibrationColumns;
    const double u = even * per_px * (column / (kCalibrationColumns - 1.0) - 0.5) * camera.width_px;
    const double v = even * per_px * (row / (kCalibrationRows - 1.0) - 0.5) * camera.height_px;
    uu += u * u, uv += u * v, vv += v * v, ue -= u * odd, ve -= v * odd;
  }
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-12 * uu * vv)) return {};
  return {(vv * ue - uv * ve) / determinant, (uu * ve - uv * ue) / determinant};
}

}  // namespace

TargetTilt estimate_tilt(const Camera& camera, const std::vector<TargetMeasurement>& measurements) {
  std::map<double, Targets> sweeps;
  for (const TargetMeasurement& m : measurements) sweeps[m.focus_distance_m].push_back(&m);
  Tangents sum, variance;
  int degrees_of_freedom = 0;
  for (const auto& [focus_distance_m, targets] : sweeps) {
    const Tangents all = tangents_without(camera, targets, nullptr);
    sum.x += all.x, sum.y += all.y;
    const auto n = static_cast<double>(targets.size());
    degrees_of_freedom += static_cast<int>(targets.size()) - 1;
    if (n < 3) variance.x = variance.y = std::numeric_limits<double>::infinity();
    Tangents mean, squares;
    for (const TargetMeasurement* target : targets) {
      const Tangents rest = tangents_without(camera, targets, target);
      mean.x += rest.x / n, mean.y += rest.y / n;
      squares.x += rest.x * rest.x / n, squares.y += rest.y * rest.y / n;
    }
    variance.x += (n - 1) * std::max(squares.x - mean.x * mean.x, 0.0);
    variance.y += (n - 1) * std::max(squares.y - mean.y * mean.y, 0.0);
  }
  const auto n = static_cast<double>(std::max<std::size_t>(sweeps.size(), 1));
  constexpr double kDegrees = 180 / std::numbers::pi;
  return {kDegrees * std::atan(sum.x / n), kDegrees * std::atan(sum.y / n), kDegrees * std::sqrt(variance.x) / n,
          kDegrees * std::sqrt(variance.y) / n, degrees_of_freedom};
}

double significant_errors(int degrees_of_freedom) {
  constexpr double kNormal = 3;
  if (degrees_of_freedom < 1) return std::numeric_limits<double>::infinity();
  const double n = degrees_of_freedom, z = kNormal * (8 * n + 3) / (8 * n + 1);
  return std::sqrt(n * std::expm1(z * z / n));
}

}  // namespace dualpixel::pipeline
