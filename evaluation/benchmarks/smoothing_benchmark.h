#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/edge_aware/smooth_disparity.h"

/// Edge-aware smoothing of disparity against the truth of a rendered capture: error, time, and peers.
namespace dualpixel::evaluation {

/// Over the pixels with valid truth. Edges: within 3 px of a jump of the true disparity by more than 0.2 DP px.
struct SmoothingErrors {
  double rmse_dp_px = 0, mae_dp_px = 0;
  double edge_rmse_dp_px = 0, edge_mae_dp_px = 0;
  double edge_width_px = 0;   ///< edge_metrics.h
  double thin_mae_dp_px = 0;  ///< on thin structures, edge_metrics.h
};

/// Solver, median and joint upsampling together, the best of two runs. Encoding the full-size guide for the upsampling
/// is included, as in the pipeline's stage; reducing the guide and the map is not.
struct SmoothingRun {
  double ms = 0, cpu_ms = 0;
  double memory_mb = 0;  ///< at most, besides what goes in
  SmoothingErrors errors;
};

struct SmoothingComparison {
  std::string family, name;
  SmoothingRun matched;  ///< of the paper's matches, fitted to the truth
  SmoothingRun known;    ///< of the truth with noise of 0.15 DP px, 5 % outliers, and gaps of 16 px around depth edges
};

/// Times of the single steps, and how well the mask's outline is met: boundary F-scores at 2 px. Upsampling is timed
/// here without encoding its guide.
struct SmoothingStages {
  double solve_ms = 0, median_ms = 0, upsample_ms = 0, mask_ms = 0;
  double disparity_cpu_ms = 0;  ///< of the first three
  double mask_cpu_ms = 0;
  double solve_peak_mb = 0;
  struct MaskScore {
    std::string name;
    double boundary_f = 0;
  };
  std::vector<MaskScore> masks;
};

/// Our solver and OpenCV's at half the capture's size with the same grid cells, lambda and iterations.
struct SolverComparison {
  pipeline::BilateralGridOptions cells;
  double vertices = 0;
  double ms = 0, grid_ms = 0, opencv_ms = 0;
  double cpu_ms = 0, opencv_cpu_ms = 0;
  double peak_mb = 0, opencv_peak_mb = 0;
  SmoothingErrors ours, opencv;
};

/// One of edge_failures.h; a figure is NaN where a solver returns that.
struct SolverFailure {
  std::string failure, figure;
  double ours = 0;
  std::optional<double> opencv;  ///< none where the build has no OpenCV
};

struct SmoothingBenchmark {
  std::string capture;
  SmoothingStages stages;
  std::vector<SolverComparison> opencv;  ///< empty where the build has no OpenCV
  std::vector<SolverFailure> failures;
  std::vector<SmoothingComparison> methods;
};

/// `capture_path` is a capture with truth. Throws InputError where it has none, or where its burst moves.
SmoothingBenchmark measure_smoothing(const std::string& capture_path,
                                     const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const SmoothingBenchmark& benchmark);
std::string to_page(const SmoothingBenchmark& benchmark);

}  // namespace dualpixel::evaluation
