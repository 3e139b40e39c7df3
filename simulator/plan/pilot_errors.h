#pragma once
#include <array>
#include <vector>

#include "simulator/plan/pilot_renders.h"
#include "simulator/plan/steps.h"

namespace dualpixel::simulator {

inline constexpr int kReferenceBounces = 8;
inline constexpr std::array kPilotSamples = {16, 64};  ///< less than a packet of 16 costs as much

/// What the pilot renders show of bounces, light, effects and samples, in the windows that have texture.
struct PilotErrors {
  int windows = 0, windows_textured = 0;
  std::vector<BounceStep> bounces;                   ///< 0, 1, 2, 4, 8; empty where too few windows have texture
  std::vector<LightStep> lights;                     ///< twice the scene file's spacing, that, and half
  std::vector<LightSampleStep> light_samples;        ///< the scene file's, and more
  std::vector<EffectStep> effects;                   ///< those of effects_of(simulation)
  std::array<double, kPilotSamples.size()> noise{};  ///< with the reference's bounces, at kPilotSamples
  /// The part of squared noise that more camera samples do not reduce: the mean, not a bound, as it is taken off one.
  double light_variance = 0;

  /// Error of `samples` samples with the reference's bounces, without light's part.
  double sample_error(int samples) const;
};

/// `pilots` without effects; they get more tiles where few windows have texture. `simulation` is the scene file's.
PilotErrors measure_pilots(PilotRenders& pilots, const Simulation& simulation, double tolerance_dp_px,
                           const ProgressCallback& progress);

}  // namespace dualpixel::simulator
