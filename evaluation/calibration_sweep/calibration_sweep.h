#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "evaluation/calibration_sweep/calibration_target.h"
#include "pipeline/calibration/calibration.h"
#include "pipeline/disparity/noise_model.h"
#include "simulator/simulate.h"

/// The sweep of a simulated camera over focus and target distances (Wadhwa et al. 2018, section 4.2: 20 focus
/// distances).
namespace dualpixel::evaluation {

struct SweepOptions {
  int focuses = 20;  ///< even in 1/z, from infinity to `nearest_focus_m`; 2 or more
  int targets = 8;   ///< for each focus distance, even in inverse depth; 3 or more
  double nearest_focus_m = 0.2;
  double tilt_x_deg = 0;      ///< as in CalibrationTarget
  int finest_px = 32;         ///< of the texture, as in CalibrationTarget
  pipeline::ViewNoise noise;  ///< of the captures; none by default
  std::uint64_t seed = 1;     ///< of the textures and of the noise
};

std::vector<double> sweep_focus_distances(const SweepOptions& options);

/// The simulation's lens, focused elsewhere and made ready (up to a second for a prescription). Throws InputError where
/// it cannot be focused there, or where no light passes it.
simulator::LensSampler focused_lens(const simulator::Simulation& simulation, double focus_distance_m);

/// Throws InputError where the lens cannot be focused on one of the sweep's distances.
void require_focuses(const simulator::Simulation& simulation, const SweepOptions& options);

/// From far to near. `lens` is focused; `dp_pitch_um` is that of a DP pixel. Targets are at most 3 m away, the
/// length of a room, and where disparity on the axis is within 1 DP px; but they span at least 1 / m of inverse depth,
/// so that with a lens much longer than a phone's they leave that range.
std::vector<double> sweep_target_distances(const simulator::Lens& lens, double dp_pitch_um, int targets);

/// One focus distance of a sweep.
class FocusSweep {
 public:
  FocusSweep(const simulator::Simulation& simulation, double focus_distance_m, const SweepOptions& options);

  const std::vector<double>& target_distances_m() const { return targets_; }
  /// Renders the target at `distance_m` and measures it; the texture and the noise are those of `seed`.
  pipeline::TargetMeasurement measure(double distance_m, std::uint64_t seed) const;
  const simulator::LensSampler& lens() const { return camera_.lens; }

 private:
  SweepOptions options_;
  TargetCamera camera_;
  std::vector<double> targets_;
  float dp_px_per_pixel_ = 1;  ///< of the views that camera_ sees
};

/// Of a frame that is exposed at that ISO, as its capture states it.
pipeline::ViewNoise frame_noise(const simulator::SensorOptions& sensor, double iso);

void add_noise(Image& view, const pipeline::ViewNoise& noise, std::uint64_t seed);

/// A sweep's two focus distances around one, which are all that a correction for that one uses, from far to near. A
/// sweep that ends farther away is made to reach that near.
struct FocusesAround {
  std::array<double, 2> focus_distances_m;
  int farther = 0;  ///< index of the first among the sweep's
};
FocusesAround focuses_around(double focus_distance_m, const SweepOptions& options);

/// What the sweep would measure at focuses_around().
std::vector<pipeline::TargetMeasurement> measure_around(const simulator::Simulation& simulation,
                                                        double focus_distance_m, const SweepOptions& options);

/// The whole sweep; every capture has its own texture. With a folder (not empty) every measurement is written there at
/// once, and one that exists already is read instead of made again. The same bytes for any number of threads;
/// `progress` is called by one at a time. Throws InputError where the lens cannot be focused so near.
std::vector<pipeline::TargetMeasurement> run_sweep(const simulator::Simulation& simulation, const SweepOptions& options,
                                                   const std::string& folder = "",
                                                   const std::function<void(double fraction)>& progress = {});

}  // namespace dualpixel::evaluation
