#pragma once
#include "simulator/render/adaptive.h"

/// How exact a render will be, from a few photosites that are rendered twice.
namespace dualpixel::simulator {

/// Mean square error of both views over the allowed one, RMS^2 over the picture.
struct RenderError {
  double samples = 0;  ///< of camera samples and of what they sample themselves
  double light = 0;    ///< of light at points of surfaces (LightCacheOptions::light_samples); 0 without them
  double both() const { return samples + light; }
};

/// At `samples` for each photosite and with the light cache that `world` has, which is given back. A
/// five-hundredth of a picture's photosites, but at least 64, are rendered with two scrambles of the samples, and with
/// two of the light.
RenderError estimate_error(RenderScene& world, const CameraView& camera, const RenderOptions& options,
                           const ErrorTarget& target, std::uint32_t samples);

/// The mean square error of light from `samples` at each point, where `at` of them have one of `error`.
double light_error(double error, int at, int samples);

/// The fewest samples, a power of two, with at most that error.
int light_samples_for(double allowed, double error, int at);

}  // namespace dualpixel::simulator
