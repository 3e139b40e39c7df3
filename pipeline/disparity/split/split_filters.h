#pragma once
#include <vector>

/// What one disparity does to low frequencies, as filters that undo it.
namespace dualpixel::pipeline::split {

/// Taps 0, 1, ... along x and along y; the other side mirrors them: equal for an even filter, negated along x for an
/// odd one.
struct SeparableFilter {
  std::vector<float> along_x, along_y;
};

/// A split sees a point at blur diameter b through the disc D of that diameter, weighted by 1 -+ g(x / (b / 2)) in the
/// left and right view (split_shape.h). Left through the right view's kernel equals right through the left's, so
///     D * (left - right) + (g D) * (left + right) = 0.
/// `difference` and `sum` are those two filters, divided at each frequency by the root of both spectra's squares, which
/// makes noise white again, under a Gaussian. Both views' kernels swap at -b: `sum` changes its sign.
/// Each is a sum of separable terms, the best ones: as many as leave out .02 % of the energy of both, but no more than
/// four. With alpha = .21 four leave out .1 % at d = 6, .2 % at 10 and .7 % at 16.
struct SplitFilters {
  int reach = 0;                            ///< samples, of the longest
  std::vector<SeparableFilter> difference;  ///< even along x
  std::vector<SeparableFilter> sum;         ///< odd along x; empty where d is 0
};

/// The samples that filters are made for.
struct FilterGrid {
  double sample_px = 1;  ///< DP pixels from sample to sample, along x and y
  double height = 1;     ///< of a DP pixel over its width: a disc that is round on the sensor is flat in high pixels
  double smoothing = 0;  ///< the Gaussian's standard deviation, samples along x and y
};

/// Filters of disparity d >= 0, for alpha up to 4 / (3 pi).
SplitFilters make_filters(double d_dp_px, double alpha, const FilterGrid& grid);

}  // namespace dualpixel::pipeline::split
