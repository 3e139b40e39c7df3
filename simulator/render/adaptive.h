#pragma once
#include <algorithm>
#include <array>
#include <functional>

#include "simulator/render/views.h"

/// Sampling with a purpose: no more samples than keep the two views' standard error under a share of what the picture
/// tolerates anyway, such as the sensor's noise.
///
/// Of each tile sixteen photosites are rendered at 8, 32, 128, ... samples, twice each with independent scrambles,
/// until their mean square difference says that the error will be small enough at four times as many; beyond that
/// the error's fall is extrapolated. These pilots are thrown away: the count that they lead to is fixed before the
/// picture's own samples are drawn, so stopping cannot bias it (repeated testing of the picture's own samples would).
///
/// Samples go where they gain most: for independent samples each tile's count is in proportion to its standard
/// deviation, which costs least for an RMS error over the picture. To give each tile the same error would cost as much
/// as to give each the same count.
namespace dualpixel::simulator {

/// Allowed variance of one half-photosite's mean, nits^2, for radiance x in its filter's color:
/// per_nit * x + constant.
struct ErrorTarget {
  std::array<double, 3> per_nit{};
  std::array<double, 3> constant{};

  /// At a photosite of this color and light. Light of few samples may be negative: what a surface reflects in this
  /// direction, and thin shadows, are sampled as differences from the diffuse light that is known.
  double at(int color, double nits) const { return per_nit[color] * std::max(nits, 0.0) + constant[color]; }
};

/// What the probes say about each tile: its standard error is the allowed one at `needed` samples, and its variance
/// falls as samples^-slope.
struct Pilot {
  SampleMap grid;
  std::vector<double> needed, slope;
  double samples = 0;  ///< that the probes took
};

/// `options.samples_per_pixel` is not used. The same for any number of threads.
Pilot probe_tiles(const RenderScene& scene, const CameraView& camera, const RenderOptions& options,
                  const ErrorTarget& target, std::uint32_t most_samples = 16384, const ProgressCallback& progress = {});

/// Of each photosite; powers of two.
struct SampleLimits {
  std::uint32_t fewest = 16, most = 16384;
};

/// The cheapest map whose RMS over the picture of standard error over allowed error is `error`. Counts are powers of
/// two within `limits`: a picture for which the fewest are too many gets less error than it asked for, one that the
/// most do not satisfy more.
SampleMap share_samples(const Pilot& pilot, double error, const SampleLimits& limits = {});

/// The map of least error whose samples add up to no more than `affordable()`, or the fewest. It is asked over and
/// over, so that the time of the search itself, a fraction of a second for a large picture, can be taken off what it
/// says.
SampleMap share_budget(const Pilot& pilot, const std::function<double()>& affordable, const SampleLimits& limits = {});

}  // namespace dualpixel::simulator
