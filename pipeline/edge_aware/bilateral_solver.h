#pragma once
#include "pipeline/edge_aware/bilateral_grid.h"

/// Edge-aware smoothing: the fast bilateral solver (Barron and Poole 2016), which minimises
///     lambda/2 sum_ij W_ij (x_i - x_j)^2 + sum_i c_i (x_i - t_i)^2                       (their Eq. 1)
/// for target t and confidence c, with W the bistochastised affinity of pixels in a bilateral grid.
namespace dualpixel::pipeline {

struct BilateralSolverOptions {
  float lambda = 128;                ///< smoothness over data; the authors' public code
  int iterations = 25;               ///< of preconditioned conjugate gradients (section 3: 25)
  int bistochastic_iterations = 10;  ///< the authors' public code
};

/// In grid space the minimum solves (lambda (Dm - Dn B Dn) + diag(S c)) y = S (c t), x = S^T y (their Eq. 4 to 7), here
/// by Jacobi-preconditioned conjugate gradients in double precision from the mean over each cell of fill_gaps(t, c).
///
/// `target` and `confidence` are of the grid's size; confidence is at least 0. A target or confidence that is not
/// finite has confidence 0. Pixels that no confident pixel reaches through the grid get what fill_gaps says of them,
/// smoothed; the result is always finite.
Image solve_bilateral(const BilateralGrid& grid, const Image& target, const Image& confidence,
                      const BilateralSolverOptions& options = {});

/// The target where confidence is 1, and towards 0 the mean of what confident pixels around say, from ever wider
/// neighbourhoods (pull and push over a pyramid: Gortler et al. 1996, "The Lumigraph", section 3.4.2). 0 where
/// confidence is 0 throughout. Both finite.
Image fill_gaps(const Image& target, const Image& confidence);

}  // namespace dualpixel::pipeline
