#include "evaluation/camera_fit/camera_fit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/path_beside.h"
#include "evaluation/camera_fit/camera_figures.h"
#include "simulator/lens/lens_file.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kFitSamples = 4096, kScoreSamples = 16384;  ///< rays of each place
constexpr int kMostSteps = 60;
constexpr double kDifference = 2e-2;  ///< of a parameter's range: above the grain of the rays that a rim cuts
constexpr double kSmallestGain = 1e-4;
constexpr std::size_t kTriedStarts = 64, kOtherStarts = 3;  ///< points that are tried; of them, where a descent starts
constexpr double kBetter = 0.9;  ///< another minimum is kept where it is lower than this share of the first

double figure_of(const PointFigures& p, Figure figure, double unit_m) {
  const double light = p.left.light + p.right.light;
  switch (figure) {
    case Figure::light:
      return light;
    case Figure::left_share:
      return p.left.light / light;
    case Figure::disparity:
      return (p.right.centroid_m.x - p.left.centroid_m.x) / unit_m;
    case Figure::left_sigma_x:
      return p.left.sigma_m.x / unit_m;
    case Figure::right_sigma_x:
      return p.right.sigma_m.x / unit_m;
    case Figure::left_sigma_y:
      return p.left.sigma_m.y / unit_m;
    case Figure::right_sigma_y:
      return p.right.sigma_m.y / unit_m;
    case Figure::left_skew_x:
      return p.left.skew_x;
    case Figure::right_skew_x:
      return p.right.skew_x;
    case Figure::sum_sigma_ratio:
      return p.sum_sigma_m.x / p.sum_sigma_m.y;
  }
  return 0;
}

/// Scales light to what was measured at the places that are fitted, by least squares.
void scale_light(const std::vector<double>& measured, std::size_t columns, std::vector<double>& light) {
  double product = 0, square = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (std::isnan(measured[i]) || !is_fitted_place(i % columns, i / columns)) continue;
    product += measured[i] * light[i];
    square += light[i] * light[i];
  }
  for (double& value : light) value *= square > 0 ? product / square : 0;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  int count = 0;
  for (double v : values) {
    if (std::isnan(v)) continue;
    sum += v * v;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 1;
}

/// What an error of this figure counts in.
double scale_of(const FigureRow& row, const std::vector<double>& measured) {
  if (!row.relative) return 1;
  const double scale = root_mean_square(measured);
  return scale > 0 ? scale : 1;
}

/// Errors over tolerances at the fitted places; none where some place has no light.
std::optional<Eigen::VectorXd> weighted_errors(const CameraMeasurements& m, const PreparedCamera& camera) {
  std::vector<double> errors;
  for (std::size_t g = 0; g < m.grids.size(); ++g) {
    const MeasuredGrid& grid = m.grids[g];
    const std::vector<std::vector<double>> predicted = predict(m, camera, g, kFitSamples);
    for (std::size_t k = 0; k < grid.figures.size(); ++k) {
      const FigureRow& row = row_of(kFigures, grid.figures[k].figure);
      if (!row.fitted) continue;
      const double unit = scale_of(row, grid.figures[k].values) * row.tolerance;
      for (std::size_t i = 0; i < predicted[k].size(); ++i) {
        const double measured = grid.figures[k].values[i];
        if (std::isnan(measured) || !is_fitted_place(i % grid.x.size(), i / grid.x.size())) continue;
        const double error = (predicted[k][i] - measured) / unit;
        if (!std::isfinite(error)) return std::nullopt;
        errors.push_back(error);
      }
    }
  }
  return Eigen::VectorXd(Eigen::Map<Eigen::VectorXd>(errors.data(), static_cast<Eigen::Index>(errors.size())));
}

/// The lens with the fitted fields at `at`, each from 0 (low) to 1 (high).
nlohmann::json lens_at(const CameraMeasurements& m, const Eigen::VectorXd& at) {
  nlohmann::json lens = m.lens;
  for (std::size_t i = 0; i < m.fit.size(); ++i) {
    const FittedField& f = m.fit[i];
    lens[nlohmann::json::json_pointer(f.pointer)] = f.low + at[static_cast<Eigen::Index>(i)] * (f.high - f.low);
  }
  return lens;
}

/// A camera and its errors; none where the lens cannot be.
struct TriedCamera {
  PreparedCamera camera;
  Eigen::VectorXd errors;
};
std::optional<TriedCamera> try_at(const CameraMeasurements& m, const Eigen::VectorXd& at, const PreparedCamera* like) {
  try {
    PreparedCamera camera = prepare_camera(m, lens_at(m, at), like);
    std::optional<Eigen::VectorXd> errors = weighted_errors(m, camera);
    if (!errors) return {};
    return TriedCamera{std::move(camera), std::move(*errors)};
  } catch (const InputError&) {
    return {};
  }
}

/// Central differences, one-sided at a bound or where the lens cannot be.
Eigen::MatrixXd slopes_of(const CameraMeasurements& m, const Eigen::VectorXd& at, const TriedCamera& here) {
  Eigen::MatrixXd slopes(here.errors.size(), at.size());
  tbb::parallel_for(Eigen::Index{0}, at.size(), [&](Eigen::Index i) {
    Eigen::VectorXd ahead = at, behind = at;
    ahead[i] = std::min(1.0, at[i] + kDifference);
    behind[i] = std::max(0.0, at[i] - kDifference);
    const std::optional<TriedCamera> more = try_at(m, ahead, &here.camera), less = try_at(m, behind, &here.camera);
    const double step = (more ? ahead[i] : at[i]) - (less ? behind[i] : at[i]);
    slopes.col(i).setZero();
    if (step > 0) slopes.col(i) = ((more ? more->errors : here.errors) - (less ? less->errors : here.errors)) / step;
  });
  return slopes;
}

/// One damped step from `at`, cut at the bounds: fields at a bound that the step would cross stay there.
Eigen::VectorXd damped_step(const Eigen::MatrixXd& slopes, const Eigen::VectorXd& errors, const Eigen::VectorXd& at,
                            double damping) {
  const Eigen::VectorXd downhill = -slopes.transpose() * errors;
  Eigen::MatrixXd normal = slopes.transpose() * slopes;
  Eigen::VectorXd right = downhill;
  const double least = 1e-4 * normal.diagonal().maxCoeff();  // a field without effect must not be thrown about
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    normal(i, i) += damping * std::max(normal(i, i), least);
    const bool held = (at[i] <= 0 && downhill[i] < 0) || (at[i] >= 1 && downhill[i] > 0);
    if (!held) continue;
    normal.row(i).setZero();
    normal.col(i).setZero();
    normal(i, i) = 1;
    right[i] = 0;
  }
  const Eigen::VectorXd step = normal.ldlt().solve(right);
  return (at + step).cwiseMax(0).cwiseMin(1);
}

double cost_of(const TriedCamera& trial) {
  return trial.errors.squaredNorm() / static_cast<double>(trial.errors.size());
}

/// Where a descent is.
struct Descent {
  Eigen::VectorXd at;
  TriedCamera here;
  int steps = 0;
};

/// Follows the errors down to a minimum.
Descent descend(const CameraMeasurements& m, Descent d) {
  double damping = 1e-2, growth = 2;
  bool improved = true;
  while (improved && d.steps < kMostSteps) {
    const Eigen::MatrixXd slopes = slopes_of(m, d.at, d.here);
    improved = false;
    while (!improved && damping < 1e8) {
      const Eigen::VectorXd next = damped_step(slopes, d.here.errors, d.at, damping);
      std::optional<TriedCamera> there = try_at(m, next, &d.here.camera);
      if (there && cost_of(*there) < cost_of(d.here) * (1 - kSmallestGain)) {
        d.at = next, d.here = std::move(*there), improved = true;
        damping = std::max(damping / 3, 1e-9), growth = 2;
      } else {
        damping *= growth, growth *= 2;
      }
    }
    d.steps += improved;
  }
  return d;
}

/// The best of points spread over the bounds by a hash, some of which lie in the valley of another minimum than the
/// lens that the file starts from.
std::vector<Descent> other_starts(const CameraMeasurements& m, const TriedCamera& first) {
  std::vector<std::unique_ptr<Descent>> tried(kTriedStarts);  // none where the lens cannot be
  tbb::parallel_for(std::size_t{0}, tried.size(), [&](std::size_t k) {
    Eigen::VectorXd at(static_cast<Eigen::Index>(m.fit.size()));
    for (Eigen::Index i = 0; i < at.size(); ++i) at[i] = std::ldexp(simulator::hash(1, k, i) >> 11, -53);
    if (std::optional<TriedCamera> trial = try_at(m, at, &first.camera))
      tried[k] = std::make_unique<Descent>(Descent{std::move(at), std::move(*trial)});
  });
  std::erase_if(tried, [](const auto& d) { return !d; });
  std::stable_sort(tried.begin(), tried.end(),
                   [](const auto& a, const auto& b) { return cost_of(a->here) < cost_of(b->here); });
  std::vector<Descent> best;
  for (std::size_t k = 0; k < std::min(tried.size(), kOtherStarts); ++k) best.push_back(std::move(*tried[k]));
  return best;
}

/// The fitted fields and how well the figures determine them: what is left over is taken for the figures' own errors,
/// and the lens to change evenly over them. A field at a bound is held there.
std::vector<FittedValue> fitted_values(const CameraMeasurements& m, const Descent& end) {
  const auto held = [&](Eigen::Index i) { return end.at[i] <= 0 || end.at[i] >= 1; };
  Eigen::MatrixXd slopes = slopes_of(m, end.at, end.here);
  Eigen::Index free = 0;
  for (Eigen::Index i = 0; i < slopes.cols(); ++i) {
    if (held(i)) {
      slopes.col(i).setZero();
    } else {
      ++free;
    }
  }
  const double spare = static_cast<double>(std::max<Eigen::Index>(end.here.errors.size() - free, 1));
  Eigen::MatrixXd normal = slopes.transpose() * slopes;
  normal.diagonal().array() += 1e-9 * std::max(normal.diagonal().maxCoeff(), 1e-300);
  const Eigen::MatrixXd inverse = normal.ldlt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols()));
  std::vector<FittedValue> values;
  for (std::size_t i = 0; i < m.fit.size(); ++i) {
    const FittedField& f = m.fit[i];
    const auto k = static_cast<Eigen::Index>(i);
    FittedValue& value = values.emplace_back(FittedValue{f, f.low + end.at[k] * (f.high - f.low), {}});
    if (held(k)) continue;
    const double error = std::sqrt(inverse(k, k) * end.here.errors.squaredNorm() / spare);
    value.standard_error = error * (f.high - f.low);
  }
  return values;
}

}  // namespace

PreparedCamera prepare_camera(const CameraMeasurements& m, const nlohmann::json& lens_json,
                              const PreparedCamera* like) {
  PreparedCamera camera{lens_json, {}};
  camera.optics.erase("split");
  const bool shares = like != nullptr && like->optics == camera.optics;
  for (std::size_t g = 0; g < m.grids.size(); ++g) {
    const double focus_distance_m = m.grids[g].focus_distance_m;
    const simulator::Lens lens = simulator::read_lens(lens_json, m.path, "/lens", focus_distance_m);
    const auto same =
        std::find_if(m.grids.begin(), m.grids.begin() + static_cast<std::ptrdiff_t>(g),
                     [&](const MeasuredGrid& other) { return other.focus_distance_m == focus_distance_m; });
    const auto before = static_cast<std::size_t>(same - m.grids.begin());
    if (shares) {
      camera.at_grid.push_back(like->at_grid[g].with_split(lens.split));
    } else if (before < g) {
      camera.at_grid.push_back(camera.at_grid[before]);
    } else {
      camera.at_grid.emplace_back(lens, simulator::sensor_grid(m.sensor));
    }
  }
  return camera;
}

std::vector<std::vector<double>> predict(const CameraMeasurements& m, const PreparedCamera& camera, std::size_t index,
                                         int samples) {
  const MeasuredGrid& grid = m.grids[index];
  const simulator::LensSampler& lens = camera.at_grid[index];
  const std::size_t columns = grid.x.size();
  std::vector<PointFigures> points(columns * grid.y.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const auto pixel = [](double at, int size) { return std::min(static_cast<int>(at * size), size - 1); };
    points[i] = trace_point(lens, pixel(grid.x[i % columns], m.sensor.width_px),
                            pixel(grid.y[i / columns], m.sensor.height_px), grid.depth_m, samples);
  });
  std::vector<std::vector<double>> predicted;
  for (const MeasuredGrid::Values& figure : grid.figures) {
    std::vector<double>& values = predicted.emplace_back();
    for (const PointFigures& p : points) values.push_back(figure_of(p, figure.figure, 1e-6 * grid.unit_um));
    if (figure.figure == Figure::light) scale_light(figure.values, grid.x.size(), values);
  }
  return predicted;
}

std::vector<FigureScore> score_camera(const CameraMeasurements& m, const nlohmann::json& lens) {
  std::vector<FigureScore> scores;
  const PreparedCamera camera = prepare_camera(m, lens);
  for (std::size_t g = 0; g < m.grids.size(); ++g) {
    const MeasuredGrid& grid = m.grids[g];
    const std::vector<std::vector<double>> predicted = predict(m, camera, g, kScoreSamples);
    for (std::size_t k = 0; k < predicted.size(); ++k) {
      const std::vector<double>& measured = grid.figures[k].values;
      const FigureRow& row = row_of(kFigures, grid.figures[k].figure);
      const double scale = scale_of(row, measured);
      FigureScore& score = scores.emplace_back();
      score.grid = g;
      score.figure = row.value;
      for (std::size_t i = 0; i < measured.size(); ++i) {
        if (std::isnan(measured[i])) continue;
        const bool used = row.fitted && is_fitted_place(i % grid.x.size(), i / grid.x.size());
        FigureScore::Errors& errors = used ? score.fitted : score.judged;
        const double error = std::abs(predicted[k][i] - measured[i]) / scale;
        ++errors.count;
        errors.rms += error * error;
        errors.most = std::max(errors.most, error);
        errors.within += error <= row.tolerance;
      }
      for (FigureScore::Errors* errors : {&score.fitted, &score.judged}) {
        if (errors->count == 0) continue;
        errors->rms = std::sqrt(errors->rms / errors->count);
        errors->within /= errors->count;
      }
    }
  }
  return scores;
}

CameraFit fit_camera(const CameraMeasurements& m) {
  Eigen::VectorXd start(static_cast<Eigen::Index>(m.fit.size()));
  for (std::size_t i = 0; i < m.fit.size(); ++i) {
    const FittedField& f = m.fit[i];
    const double value = m.lens.at(nlohmann::json::json_pointer(f.pointer)).get<double>();
    start[static_cast<Eigen::Index>(i)] = (value - f.low) / (f.high - f.low);
  }
  std::optional<TriedCamera> first = try_at(m, start, nullptr);
  if (!first) {
    throw InputError(printable(m.path) + ": /lens: some place of the grids gets no light: start from another lens");
  }
  CameraFit fit;
  fit.before = cost_of(*first);
  std::vector<Descent> others = other_starts(m, *first);
  Descent best = descend(m, {std::move(start), std::move(*first)});
  fit.steps = best.steps, fit.after_first = cost_of(best.here);
  for (Descent& other : others) {
    other = descend(m, std::move(other));
    fit.steps += other.steps;
    if (cost_of(other.here) < kBetter * cost_of(best.here)) best = std::move(other);
  }
  fit.starts = 1 + static_cast<int>(others.size());
  fit.after = cost_of(best.here);
  fit.lens = lens_at(m, best.at);
  fit.fields = fitted_values(m, best);
  return fit;
}

nlohmann::ordered_json camera_json(const CameraMeasurements& m, const nlohmann::json& lens, const std::string& path) {
  nlohmann::ordered_json camera;
  camera["version"] = 1;
  camera["name"] = m.name;
  camera["source"] = m.source;
  camera["derived"] = m.derived;
  camera["lens"] = lens;
  if (lens.contains("file")) {
    const std::string file = std::filesystem::absolute(path_beside(m.path, lens["file"].get<std::string>())).string();
    camera["lens"]["file"] = std::filesystem::proximate(file, std::filesystem::absolute(path).parent_path()).string();
  }
  camera["sensor"] = m.sensor_json;
  return camera;
}

std::string to_text(const CameraFit& fit) {
  std::string text = fmt::format("{} starts, {} steps; mean square of error over tolerance {:.4g} -> {:.4g}",
                                 fit.starts, fit.steps, fit.before, fit.after);
  if (fit.after < fit.after_first) text += fmt::format(" (from the lens of the file: {:.4g})", fit.after_first);
  text += fmt::format("\n{:<28} {:>10} {:>10} {:>12} {:>15}\n", "field", "low", "high", "value", "standard error");
  for (const FittedValue& v : fit.fields) {
    const double range = v.field.high - v.field.low;
    const std::string error = !v.standard_error                 ? "at its bound"
                              : *v.standard_error > 0.5 * range ? "not determined"
                                                                : fmt::format("{:.2g}", *v.standard_error);
    text += fmt::format("{:<28} {:>10.4g} {:>10.4g} {:>12.5g} {:>15}\n", v.field.pointer, v.field.low, v.field.high,
                        v.value, error);
  }
  return text;
}

std::vector<std::string> warnings_of(const std::vector<FigureScore>& scores) {
  constexpr double kMuch = 5;
  std::vector<std::string> warnings;
  for (const FigureScore& s : scores) {
    const FigureRow& row = row_of(kFigures, s.figure);
    if (!row.fitted || !(s.judged.rms > kMuch * row.tolerance)) continue;
    warnings.push_back(
        fmt::format("grid {}: {} errs by {:.2g} RMS where it judges, {:.0f} times its tolerance: start "
                    "from another lens, or fit more of its fields",
                    s.grid, row.name, s.judged.rms, s.judged.rms / row.tolerance));
  }
  return warnings;
}

std::string to_text(const std::vector<FigureScore>& scores) {
  std::string text = fmt::format("{:<4} {:<17} {:>9} {:>22} {:>29}\n", "grid", "figure", "tolerance",
                                 "fitted: rms, most", "judged: rms, most, within");
  const auto cells = [](const FigureScore::Errors& e) {
    return e.count == 0 ? std::pair<std::string, std::string>{"-", "-"}
                        : std::pair{fmt::format("{:.4f}", e.rms), fmt::format("{:.4f}", e.most)};
  };
  for (const FigureScore& s : scores) {
    const FigureRow& row = row_of(kFigures, s.figure);
    const auto [fitted_rms, fitted_most] = cells(s.fitted);
    const auto [judged_rms, judged_most] = cells(s.judged);
    text += fmt::format("{:<4} {:<17} {:>9} {:>11} {:>10} {:>11} {:>10} {:>5.0f} %\n", s.grid, row.name,
                        fmt::format("{:g}", row.tolerance), fitted_rms, fitted_most, judged_rms, judged_most,
                        100 * s.judged.within);
  }
  return text;
}

}  // namespace dualpixel::evaluation
