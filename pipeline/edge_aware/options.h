#pragma once

/// Options of the steps that smooth_disparity.h and filter_mask.h share.
namespace dualpixel::pipeline {

/// Of bilateral_grid.h. Of 4, 8 and 16 px by 4, 8 and 16 levels, no choice is best for all targets; these lie near the
/// front of time against error for both that `dualpixel bench edges CAPTURE` charts.
struct BilateralGridOptions {
  float cell_px = 8;      ///< side of a cell along x and y, pixels of the guide; at least 1
  float cell_luma = 8;    ///< along Y, of 255 levels; at least 1. 8, 8, 8 as the authors' public code
  float cell_chroma = 8;  ///< along Cb and Cr, of 255 levels; at least 1
};

/// Of bilateral_solver.h.
struct BilateralSolverOptions {
  float lambda = 128;   ///< smoothness over data, above 0; the authors' public code. Of 2 to 512 its RMSE is within 1 %
                        ///< of the least on matches and 6 % on known errors (`dualpixel bench edges CAPTURE`)
  int iterations = 25;  ///< of preconditioned conjugate gradients, at most (section 3: 25). Stopping early smooths less
                        ///< where confidence is low: what lies far from it keeps more of the start
  double least_residual = 1e-6;      ///< stop where the residual falls below this share of the right side
  int bistochastic_iterations = 10;  ///< the authors' public code
  /// Rounds of reweighting (Geman and McClure's loss, their supplement's robust solver): each divides a pixel's
  /// confidence by (1 + (error / robust_scale)^2)^2. 0: quadratic, which 5 % of confident outliers shift by 5 % of
  /// their error. Each round costs a solve
  int robust_rounds = 0;
  float robust_scale = 0.25f;  ///< units of the target, above 0
  bool variance = false;       ///< also estimate the result's variance; costs a solve more for each channel
};

/// Of joint_upsample.h.
struct JointUpsampleOptions {
  float sigma_px = 0.5f;      ///< of the spatial Gaussian, pixels of the small map (Kopf et al., section 4: 0.5)
  float sigma_range = 16.0f;  ///< of the range Gaussian, guide levels of 255; ours (Kopf et al. use 0.1 of the range)
};

}  // namespace dualpixel::pipeline
