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

/// The figure of the pipeline's solver, always finite.
double solve_failure(const EdgeFailure& failure);

}  // namespace dualpixel::evaluation
