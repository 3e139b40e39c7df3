#pragma once
#include <functional>
#include <string>
#include <vector>

#include "pipeline/edge_aware/bilateral_solver.h"

/// Small problems on which plain bilateral solvers are known to fail, each with one figure of merit.
namespace dualpixel::evaluation {

struct EdgeFailure {
  std::string name;
  std::string figure_name;  ///< with its unit
  Image guide, target, confidence;
  pipeline::BilateralSolverOptions options;
  std::function<double(const Image& result)> figure;  ///< 0 is perfect
};

/// Targets are in 0..1, or a little beyond; cells are 8, 8, 8.
std::vector<EdgeFailure> edge_failures();

// Those that are swept in strength, too (evaluation/stage_failures/). `draw`: other noise.

/// A step of the target where the guide has one of `levels`, with noise and no confidence near the edge.
EdgeFailure edge_of_levels(double levels, unsigned draw = 0);
/// The same where the guide has a clear edge, but one that lies 32 px aside within `gap_px` about the middle row; of it
/// the pixels that are given the other side's value are counted.
EdgeFailure edge_with_gap(double gap_px, unsigned draw = 0);
/// Fully confident targets of 0.2, a share of which are 0.7 too high.
EdgeFailure confident_outliers(double share, int robust_rounds, unsigned draw = 0);
/// A target of 0.5 with noise of 0.1 over a guide without information (`spread` levels of white noise).
EdgeFailure noisy_guide(double spread, unsigned draw = 0);

/// By the pipeline's solver.
Image solve(const EdgeFailure& failure);
/// The figure of that, always finite.
double solve_failure(const EdgeFailure& failure);

}  // namespace dualpixel::evaluation
