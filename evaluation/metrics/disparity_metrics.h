#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "capture/image/image.h"

/// Figures that compare an estimated disparity with the true one, over any set of pixels. `estimate` and `truth` hold
/// one finite value a pixel, in the same order and of the same length; every pixel has the same weight.
namespace dualpixel::evaluation {

/// truth ~ scale * estimate + offset.
struct AffineFit {
  double scale = 1;
  double offset = 0;
};

/// min over (s, o) of sum (s*e + o - t)^2 + 1e-5 (s^2 + o^2), as Garg et al. 2019, "Learning Single Camera Depth
/// Estimation using Dual-Pixels", section 5; the ridge keeps a constant estimate solvable.
AffineFit fit_affine(std::span<const float> estimate, std::span<const float> truth);

/// Mean of estimate - truth.
double bias(std::span<const float> estimate, std::span<const float> truth);

/// Root of the mean square of fit(estimate) - truth. With fit_affine's fit this is AIWE(2) of Garg et al. 2019, whose
/// weights are 1 here.
double rmse(std::span<const float> estimate, std::span<const float> truth, const AffineFit& fit = {});

/// Share of the pixels with |fit(estimate) - truth| > threshold.
double bad_pixel_rate(std::span<const float> estimate, std::span<const float> truth, double threshold,
                      const AffineFit& fit = {});

/// AIWE(1) of Garg et al. 2019: the mean absolute error after a robust affine fit, five rounds of fit_affine with
/// weights 1 / max(1e-3, |residual|) after the first.
double aiwe1(std::span<const float> estimate, std::span<const float> truth);

/// Ranks 1..n; equal values share the average of the ranks that they span ("fractional" ranks).
std::vector<double> average_ranks(std::span<const float> values);

/// Spearman's rank correlation: Pearson's of the average ranks. None where either side is constant.
std::optional<double> spearman(std::span<const float> a, std::span<const float> b);

/// How well a confidence sorts the errors (Ilg et al. 2018, "Uncertainty Estimates and Multi-Hypotheses Networks for
/// Optical Flow", section 5.1): pixels are removed from the least confident upwards, and the mean error of those
/// that remain is followed; an oracle removes the largest errors first. Pixels of equal confidence go in random order,
/// in expectation.
struct Sparsification {
  std::vector<double> removed;  ///< 0, 0.05 ... 0.95 of the pixels
  std::vector<double> error;    ///< mean error of those that remain, by confidence
  std::vector<double> oracle;   ///< ... by the error itself
  /// Area between the two curves, over all n steps, over the mean error of all pixels: 0 is perfect; a constant
  /// confidence gives 1 minus the oracle's area. None where no pixel errs.
  std::optional<double> ause;
};
Sparsification sparsification(std::span<const float> error, std::span<const float> confidence);

inline constexpr float kWrongDpPx = 0.5f;      ///< a larger error makes a disparity wrong
inline constexpr float kConfidentDpPx = 0.2f;  ///< a smaller predicted sigma makes it confident

using Mask = ImageOf<std::uint8_t>;  ///< 1 inside, 0 outside

/// Pixels at most `reach_px` away, along x and y, from a border between two neighbors whose disparities differ by more
/// than `jump_dp_px`; a border's own two pixels are 1 away.
Mask depth_edges(const Image& disparity_dp_px, float jump_dp_px, int reach_px);

}  // namespace dualpixel::evaluation
