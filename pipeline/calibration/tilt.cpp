#include "pipeline/calibration/tilt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>

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

/// Nodes nearer to the border see their surroundings from one side: their slopes scatter three to six times as much.
constexpr int kBorder = 2;

bool inside(double column, double row) {
  return column >= kBorder && column <= kCalibrationColumns - 1 - kBorder && row >= kBorder &&
         row <= kCalibrationRows - 1 - kBorder;
}

/// Between the four nodes around; 0 where one of them has none.
double slope_at(const std::vector<double>& slopes, double column, double row) {
  const int i = static_cast<int>(column), j = static_cast<int>(row);
  const double u = column - i, v = row - j;
  double sum = 0;
  for (const auto& [di, dj, weight] :
       {std::tuple{0, 0, (1 - u) * (1 - v)}, {1, 0, u * (1 - v)}, {0, 1, (1 - u) * v}, {1, 1, u * v}}) {
    if (weight == 0) continue;
    const double slope = slopes[static_cast<std::size_t>((j + dj) * kCalibrationColumns + i + di)];
    if (slope == 0) return 0;
    sum += weight * slope;
  }
  return sum;
}

struct Tangents {
  double x = 0, y = 0;
};

/// None where too few nodes tell.
std::optional<Tangents> tangents_without(const Camera& camera, const Targets& targets,
                                         const TargetMeasurement* left_out) {
  const double image_distance_mm =
      camera.focal_length_mm / (1 - 1e-3 * camera.focal_length_mm / targets.front()->focus_distance_m);
  const double per_px = 1e-3 * camera.pixel_pitch_um / image_distance_mm;
  const double per_column = per_px * camera.width_px / (kCalibrationColumns - 1);
  const double per_row = per_px * camera.height_px / (kCalibrationRows - 1);
  const double middle_column = camera.principal_point_px[0] / camera.width_px * (kCalibrationColumns - 1);
  const double middle_row = camera.principal_point_px[1] / camera.height_px * (kCalibrationRows - 1);
  std::vector<double> slopes(static_cast<std::size_t>(kCalibrationColumns) * kCalibrationRows);
  for (std::size_t node = 0; node < slopes.size(); ++node) slopes[node] = slope_without(targets, node, left_out);
  double uu = 0, uv = 0, vv = 0, ue = 0, ve = 0;
  for (int row = 0; row < kCalibrationRows; ++row) {
    for (int column = 0; column < kCalibrationColumns; ++column) {
      const double opposite_column = 2 * middle_column - column, opposite_row = 2 * middle_row - row;
      if (!inside(column, row) || !inside(opposite_column, opposite_row)) continue;
      const double here = slope_at(slopes, column, row), opposite = slope_at(slopes, opposite_column, opposite_row);
      if (here == 0 || opposite == 0) continue;
      const double even = 0.5 * (here + opposite), odd = 0.5 * (here - opposite);
      const double u = even * per_column * (column - middle_column), v = even * per_row * (row - middle_row);
      uu += u * u, uv += u * v, vv += v * v, ue -= u * odd, ve -= v * odd;
    }
  }
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-12 * uu * vv)) return {};
  return Tangents{(vv * ue - uv * ve) / determinant, (uu * ve - uv * ue) / determinant};
}

}  // namespace

TargetTilt estimate_tilt(const Camera& camera, const std::vector<TargetMeasurement>& measurements) {
  std::map<double, Targets> sweeps;
  for (const TargetMeasurement& m : measurements) sweeps[m.focus_distance_m].push_back(&m);
  Tangents sum, variance;
  int degrees_of_freedom = 0;
  for (const auto& [focus_distance_m, targets] : sweeps) {
    const Tangents all = tangents_without(camera, targets, nullptr).value_or(Tangents{});
    sum.x += all.x, sum.y += all.y;
    const auto n = static_cast<double>(targets.size());
    degrees_of_freedom += std::max(static_cast<int>(targets.size()) - 2, 0);
    double inverse = 0, squares = 0;
    for (const TargetMeasurement* target : targets) {
      inverse += 1 / target->target_distance_m;
      squares += 1 / (target->target_distance_m * target->target_distance_m);
    }
    const double spread = squares - inverse * inverse / n;
    for (const TargetMeasurement* target : targets) {
      const std::optional<Tangents> rest = tangents_without(camera, targets, target);
      if (n < 3 || !rest || !(spread > 1e-9 * squares)) {
        variance.x = variance.y = std::numeric_limits<double>::infinity();
        break;
      }
      const double off = 1 / target->target_distance_m - inverse / n;
      // what the line through the targets leaves of this one's own error (Wu 1986)
      const double share = 1 - 1 / n - off * off / spread;
      variance.x += share * (rest->x - all.x) * (rest->x - all.x);
      variance.y += share * (rest->y - all.y) * (rest->y - all.y);
    }
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
