#include "evaluation/camera_fit/camera_fit.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/path_beside.h"
#include "evaluation/camera_fit/camera_figures.h"
#include "simulator/lens/lens_file.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kFitSamples = 4096, kScoreSamples = 16384;  ///< rays of each place
constexpr int kMostSteps = 60;
constexpr double kDifference = 2e-2;  ///< of a parameter's range: above the grain of the rays that a rim cuts
constexpr double kSmallestGain = 1e-4;

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
struct Trial {
  PreparedCamera camera;
  Eigen::VectorXd errors;
};
std::optional<Trial> try_at(const CameraMeasurements& m, const Eigen::VectorXd& at, const PreparedCamera* like) {
  try {
    PreparedCamera camera = prepare_camera(m, lens_at(m, at), like);
    std::optional<Eigen::VectorXd> errors = weighted_errors(m, camera);
    if (!errors) return {};
    return Trial{std::move(camera), std::move(*errors)};
  } catch (const InputError&) {
    return {};
  }
}

/// Central differences, one-sided at a bound or where the lens cannot be.
Eigen::MatrixXd slopes_of(const CameraMeasurements& m, const Eigen::VectorXd& at, const Trial& here) {
  Eigen::MatrixXd slopes(here.errors.size(), at.size());
  tbb::parallel_for(Eigen::Index{0}, at.size(), [&](Eigen::Index i) {
    Eigen::VectorXd ahead = at, behind = at;
    ahead[i] = std::min(1.0, at[i] + kDifference);
    behind[i] = std::max(0.0, at[i] - kDifference);
    const std::optional<Trial> more = try_at(m, ahead, &here.camera), less = try_at(m, behind, &here.camera);
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
  Eigen::VectorXd at(static_cast<Eigen::Index>(m.fit.size()));
  for (std::size_t i = 0; i < m.fit.size(); ++i) {
    const FittedField& f = m.fit[i];
    const double start = m.lens.at(nlohmann::json::json_pointer(f.pointer)).get<double>();
    at[static_cast<Eigen::Index>(i)] = (start - f.low) / (f.high - f.low);
  }
  std::optional<Trial> here = try_at(m, at, nullptr);
  if (!here) {
    throw InputError(printable(m.path) + ": /lens: some place of the grids gets no light: start from another lens");
  }
  CameraFit fit;
  const double count = static_cast<double>(here->errors.size());
  fit.before = fit.after = here->errors.squaredNorm() / count;
  double damping = 1e-2, growth = 2;
  bool improved = true;
  while (improved && fit.steps < kMostSteps) {
    const Eigen::MatrixXd slopes = slopes_of(m, at, *here);
    improved = false;
    while (!improved && damping < 1e8) {
      const Eigen::VectorXd next = damped_step(slopes, here->errors, at, damping);
      std::optional<Trial> there = try_at(m, next, &here->camera);
      const double cost = there ? there->errors.squaredNorm() / count : std::numeric_limits<double>::infinity();
      if (cost < fit.after * (1 - kSmallestGain)) {
        fit.after = cost, at = next, here = std::move(there), improved = true;
        damping = std::max(damping / 3, 1e-9), growth = 2;
      } else {
        damping *= growth, growth *= 2;
      }
    }
    fit.steps += improved;
  }
  fit.lens = lens_at(m, at);
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
