#include "pipeline/calibration/calibration.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "capture/error.h"
#include "pipeline/calibration/flow.h"
#include "pipeline/calibration/meters.h"
#include "pipeline/calibration/nodes.h"
#include "pipeline/calibration/tilt.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kColumns = kCalibrationColumns, kRows = kCalibrationRows;
constexpr int kFewestTargets = 3;
constexpr double kSmallestSpan_per_m = 0.2;  ///< of the targets' inverse depth
constexpr double kMostMismatch = 0.5;
/// Matches end before the border at either side: by this share of the width, at least by two blocks, which lack
/// neighbors.
constexpr double kUnmatched = 0.01, kUnmatchedBlocks = 2;
constexpr double kTiltWarning_deg = 0.7;

using Targets = std::vector<const TargetMeasurement*>;

/// The value at (0, 0) of the quadratic surface through weighted values around it.
class LocalQuadratic {
 public:
  void add(double u, double v, double weight, double value) {
    const Terms terms{1, u, v, u * u, u * v, v * v};
    normal_ += weight * terms * terms.transpose();
    wanted_ += weight * value * terms;
  }
  double at_origin() const {
    // decides where there are so few values that no such surface goes through them
    Matrix normal = normal_;
    normal.diagonal().array() += 1e-6 * normal(0, 0);
    return normal.ldlt().solve(wanted_)[0];
  }

 private:
  using Terms = Eigen::Matrix<double, 6, 1>;
  using Matrix = Eigen::Matrix<double, 6, 6>;
  Matrix normal_ = Matrix::Zero();
  Terms wanted_ = Terms::Zero();
};

double tent(double u, double v) { return std::max(1 - std::abs(u), 0.0) * std::max(1 - std::abs(v), 0.0); }

/// The flow around one node.
struct NodeReading {
  double disparity_dp_px = 0, mismatch = 0;
};

/// `x` and `y` are the node's position in blocks, `reach_x` and `reach_y` how far the next nodes are.
NodeReading read_flow(const Flow& flow, double x, double y, double reach_x, double reach_y) {
  LocalQuadratic surface;
  double mismatch = 0, seen = 0;
  const int width = flow.mismatch.width, height = flow.mismatch.height;
  const double unmatched = std::max(kUnmatched * width, kUnmatchedBlocks);
  for (int j = std::max(static_cast<int>(y - reach_y), 0); j < height && j + 0.5 < y + reach_y; ++j) {
    for (int i = std::max(static_cast<int>(x - reach_x), 0); i < width && i + 0.5 < x + reach_x; ++i) {
      const double u = (i + 0.5 - x) / reach_x, v = (j + 0.5 - y) / reach_y, weight = tent(u, v);
      surface.add(u, v, weight, flow.disparity_dp_px.at(i, j));
      if (i + 0.5 < unmatched || i + 0.5 > width - unmatched) continue;
      mismatch += weight * flow.mismatch.at(i, j);
      seen += weight;
    }
  }
  return {surface.at_origin(), seen > 0 ? mismatch / seen : 2};
}

/// Slopes smoothed by a quadratic surface through the nodes around that have one, which reduces errors from noise and
/// texture. Slopes change slowly over the field, even where intercepts do not.
Image smoothed_slopes(const Image& slopes) {
  constexpr int kNodeReach = 3;  // nodes; the weight is 0 there
  Image smooth = slopes;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      if (slopes.at(column, row) == 0) continue;
      LocalQuadratic surface;
      for (int j = std::max(row - kNodeReach, 0); j <= std::min(row + kNodeReach, kRows - 1); ++j) {
        for (int i = std::max(column - kNodeReach, 0); i <= std::min(column + kNodeReach, kColumns - 1); ++i) {
          if (slopes.at(i, j) == 0) continue;
          const double u = 1.0 * (i - column) / kNodeReach, v = 1.0 * (j - row) / kNodeReach;
          surface.add(u, v, tent(u, v), slopes.at(i, j));
        }
      }
      smooth.at(column, row) = static_cast<float>(surface.at_origin());
    }
  }
  return smooth;
}

/// `counts` are the usable targets of each node.
FocusCalibration fit_lines(const Targets& targets, std::size_t principal, std::vector<int>& counts) {
  FocusCalibration fit{targets.front()->focus_distance_m, 0, node_image(), node_image(), node_image()};
  counts.assign(fit.slope_dp_px_m.data.size(), 0);
  struct Means {
    double x = 0, y = 0;  // 1 / m, DP px
  };
  std::vector<Means> means(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (const TargetMeasurement* target : targets) {
      if (target->usable.data[i] == 0) continue;
      const double inverse = 1 / target->target_distance_m, d = target->disparity_dp_px.data[i];
      n += 1, x += inverse, y += d, xx += inverse * inverse, xy += inverse * d, yy += d * d;
      low = std::min(low, inverse), high = std::max(high, inverse);
    }
    counts[i] = static_cast<int>(n);
    if (n < kFewestTargets || high - low < kSmallestSpan_per_m) continue;
    xx -= x * x / n, xy -= x * y / n, yy -= y * y / n;
    const double slope = xy / xx;
    const double left = std::max(yy - slope * xy, 0.0);
    means[i] = {x / n, y / n};
    fit.slope_dp_px_m.data[i] = static_cast<float>(slope);
    fit.residual_dp_px.data[i] = static_cast<float>(std::sqrt(left / n));
    if (i == principal && yy > 0) fit.r_squared = 1 - left / yy;
  }
  fit.slope_dp_px_m = smoothed_slopes(fit.slope_dp_px_m);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double slope = fit.slope_dp_px_m.data[i];
    if (slope != 0) fit.intercept_dp_px.data[i] = static_cast<float>(means[i].y - slope * means[i].x);
  }
  return fit;
}

/// Each once, ascending.
std::vector<double> inverse_distances(const Targets& targets) {
  std::vector<double> inverse;
  for (const TargetMeasurement* target : targets) inverse.push_back(1 / target->target_distance_m);
  std::sort(inverse.begin(), inverse.end());
  inverse.erase(std::unique(inverse.begin(), inverse.end()), inverse.end());
  return inverse;
}

void require_span(const Targets& targets) {
  const std::vector<double> inverse = inverse_distances(targets);
  const std::string focus = "calibration: focus distance " + meters(targets.front()->focus_distance_m);
  if (inverse.size() < kFewestTargets) {
    throw InputError(
        fmt::format("{}: {} target distances: a line needs at least {}", focus, inverse.size(), kFewestTargets));
  }
  if (inverse.back() - inverse.front() < kSmallestSpan_per_m) {
    throw InputError(
        fmt::format("{}: targets from {} to {}: too close together; their inverses must differ by {:g} / m", focus,
                    meters(1 / inverse.back()), meters(1 / inverse.front()), kSmallestSpan_per_m));
  }
}

void require_line(const FocusCalibration& fit, const Targets& targets, std::size_t principal, int count) {
  if (fit.slope_dp_px_m.data[principal] != 0) return;
  const std::string where =
      fmt::format("calibration: focus distance {}: at the principal point ", meters(fit.focus_distance_m));
  if (count < kFewestTargets) {
    throw InputError(
        fmt::format("{}the views of only {} targets match; {} are needed: is the target textured and within range?",
                    where, count, kFewestTargets));
  }
  Targets usable = targets;
  usable.erase(std::remove_if(usable.begin(), usable.end(),
                              [&](const TargetMeasurement* target) { return target->usable.data[principal] == 0; }),
               usable.end());
  const std::vector<double> inverse = inverse_distances(usable);
  const double span = inverse.back() - inverse.front();
  if (span < kSmallestSpan_per_m) {
    throw InputError(
        fmt::format("{}the {} targets whose views match are too close together: their inverses differ by {:.3g} / m; "
                    "must be {:g} / m",
                    where, count, span, kSmallestSpan_per_m));
  }
  throw InputError(where + "disparity does not change with distance: are the two views the same picture?");
}

void warn_of_tilt(const TargetTilt& tilt, std::vector<std::string>& warnings) {
  const double errors = significant_errors(tilt.degrees_of_freedom);
  // Each axis is tested against its own error. Noise that repeats in every row leaves y nearly 0 with an error of
  // nearly 0, so y can look significant; that must not make x's chance tilt count.
  const double x = std::abs(tilt.x_deg) > errors * tilt.x_error_deg ? tilt.x_deg : 0;
  const double y = std::abs(tilt.y_deg) > errors * tilt.y_error_deg ? tilt.y_deg : 0;
  if (std::hypot(x, y) < kTiltWarning_deg) return;
  warnings.push_back(fmt::format(
      "the target seems tilted: its right side is {:.1f} +- {:.1f} degrees farther, its lower side {:.1f} +- {:.1f} "
      "degrees (or the lens is not symmetric); straighten it and repeat the sweep",
      tilt.x_deg, tilt.x_error_deg, tilt.y_deg, tilt.y_error_deg));
}

}  // namespace

TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m) {
  return measure_target(left, right, focus_distance_m, target_distance_m, {});
}

TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m, const FlowOptions& options) {
  const Flow flow = match_target(left, right, options);
  TargetMeasurement m{focus_distance_m, target_distance_m, node_image(), node_image()};
  const int width = flow.mismatch.width, height = flow.mismatch.height;
  // two blocks at least, or a node of a very small picture would see none
  const double step_x = static_cast<double>(width) / (kColumns - 1), reach_x = std::max(step_x, 2.0);
  const double step_y = static_cast<double>(height) / (kRows - 1), reach_y = std::max(step_y, 2.0);
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const NodeReading reading = read_flow(flow, i * step_x, j * step_y, reach_x, reach_y);
      m.disparity_dp_px.at(i, j) = static_cast<float>(reading.disparity_dp_px);
      m.usable.at(i, j) = reading.mismatch <= kMostMismatch ? 1.0f : 0.0f;
    }
  }
  return m;
}

std::size_t principal_node(const Camera& camera) {
  const auto nearest = [](double fraction, int count) {
    return static_cast<std::size_t>(std::lround(std::clamp(fraction, 0.0, 1.0) * (count - 1)));
  };
  return nearest(camera.principal_point_px[1] / camera.height_px, kRows) * kColumns +
         nearest(camera.principal_point_px[0] / camera.width_px, kColumns);
}

Calibration fit_calibration(const Camera& camera, const std::vector<TargetMeasurement>& measurements) {
  if (measurements.empty()) throw InputError("calibration: no measurements");
  Calibration calibration;
  calibration.camera = camera;
  calibration.nearest_target_m = std::numeric_limits<double>::infinity();
  Targets sorted;
  for (const TargetMeasurement& m : measurements) {
    sorted.push_back(&m);
    calibration.nearest_target_m = std::min(calibration.nearest_target_m, m.target_distance_m);
    calibration.farthest_target_m = std::max(calibration.farthest_target_m, m.target_distance_m);
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto* a, const auto* b) { return a->focus_distance_m > b->focus_distance_m; });
  const std::size_t principal = principal_node(camera);
  std::vector<int> counts;
  for (auto first = sorted.begin(); first != sorted.end();) {
    const auto last = std::find_if(first, sorted.end(),
                                   [&](const auto* m) { return m->focus_distance_m != (*first)->focus_distance_m; });
    const Targets targets(first, last);
    require_span(targets);
    FocusCalibration fit = fit_lines(targets, principal, counts);
    require_line(fit, targets, principal, counts[principal]);
    calibration.focuses.push_back(std::move(fit));
    first = last;
  }
  warn_of_tilt(estimate_tilt(camera, measurements), calibration.warnings);
  return calibration;
}

}  // namespace dualpixel::pipeline
