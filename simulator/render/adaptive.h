#pragma once
#include <array>

#include "simulator/render/views.h"

/// Sampling with a purpose: no more samples than keep the two views' standard error under a share of what the picture
/// tolerates anyway, such as the sensor's noise.
///
/// Of each tile some photosites are rendered at 4, 16, 64, ... samples, twice each with independent scrambles, until
/// their mean square difference says that the error will be small enough at four times as many; the error's fall is
/// drawn on from there. These pilots are thrown away: the count that they lead to is fixed before the picture's own
/// samples are drawn, so stopping cannot bias it (repeated testing of the picture's own samples would).
namespace dualpixel::simulator {

/// Allowed variance of one half-photosite's mean, nits^2, for radiance x in its filter's colour:
/// per_nit * x + constant.
struct ErrorTarget {
  std::array<double, 3> per_nit{};
  std::array<double, 3> constant{};
};

/// What a picture would need, tile by tile.
struct Pilot {
  SampleMap map;  ///< with error_ratio; counts within 16 ... most_samples
  double samples_spent = 0;
};

/// `options.samples_per_pixel` is not used. Tiles that would need more than `most_samples` get that many. The same for
/// any number of threads.
Pilot plan_samples(const RenderScene& scene, const CameraView& camera, const RenderOptions& options,
                   const ErrorTarget& target, std::uint32_t most_samples = 16384,
                   const ProgressCallback& progress = {});

}  // namespace dualpixel::simulator
