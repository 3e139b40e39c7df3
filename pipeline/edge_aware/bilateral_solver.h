#pragma once
#include "pipeline/edge_aware/bilateral_grid.h"
#include "pipeline/edge_aware/options.h"

/// Edge-aware smoothing: the fast bilateral solver (Barron and Poole 2016), which minimizes
///     lambda/2 sum_ij W_ij (x_i - x_j)^2 + sum_i c_i (x_i - t_i)^2                       (their Eq. 1)
/// for target t and confidence c, with W the bistochastized affinity of pixels in a bilateral grid.
namespace dualpixel::pipeline {

OptionFields fields(BilateralSolverOptions& options);

struct BilateralSolution {
  Image value;  ///< of the grid's size, channels as the target; always finite
  /// Of the targets that each pixel's value is the weighted mean of, under the weights of that mean, which are never
  /// negative: small where the targets agree. In squared units of the target, one channel for each of its;
  /// infinite where no confidence reaches. Empty unless asked for.
  Image variance;
  int iterations = 0;   ///< of the last solve, most of all channels
  double residual = 0;  ///< |b - A y| / |b| after it, most of all channels; 0 where b is
};

/// In grid space the minimum solves (lambda (Dm - Dn B Dn) + diag(S c)) y = S (c t) (their Eq. 4 to 7), here by
/// Jacobi-preconditioned conjugate gradients in double precision; pixels then interpolate between vertices
/// (bilateral_grid.h), where the paper's x = S^T y shows cells' borders as steps.
///
/// `target` has any number of channels, `confidence` one, at least 0; both are of the grid's size, `guide` is the
/// grid's own. A target or confidence that is not finite has confidence 0. `start`, where given, is a guess at the
/// result (the last frame's, say); otherwise each vertex starts from the mean over its pixels, and where these are not
/// confident from that of the tiles around (fill_gaps).
///
/// Pixels that no confident pixel reaches through the grid take the value of the nearest one that is reached. Where
/// confidence is 0 throughout, all take the mean of the targets that are finite (0 if none is).
///
/// Throws InputError where sizes differ or an option is out of its range.
BilateralSolution solve_bilateral(const BilateralGrid& grid, const Image& guide, const Image& target,
                                  const Image& confidence, const BilateralSolverOptions& options = {},
                                  const Image& start = {});

/// The target where confidence is 1, and towards 0 the mean of confident pixels around it, from ever wider
/// neighborhoods (pull and push over a pyramid: Gortler et al. 1996, "The Lumigraph", section 3.4.2). One channel.
/// 0 where confidence is 0 throughout. Both finite.
Image fill_gaps(const Image& target, const Image& confidence);

}  // namespace dualpixel::pipeline
