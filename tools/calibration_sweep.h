#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/calibration/calibration.h"
#include "simulator/simulate.h"
#include "tools/calibration_target.h"

/// The sweep of a simulated camera over focus and target distances (Wadhwa et al. 2018, section 4.2: 20 focus
/// distances).
namespace dualpixel::tools {

struct SweepOptions {
  int focuses = 20;  ///< even in 1/z, from infinity to `nearest_focus_m`; 2 or more
  int targets = 8;   ///< for each focus distance, even in inverse depth; 3 or more
  double nearest_focus_m = 0.2;
  double reach_dp_px = 1;        ///< targets stand where disparity on the axis is within this
  double farthest_target_m = 3;  ///< and no farther than this, a room's length
  double tilt_x_deg = 0, tilt_y_deg = 0;
  int finest_px = 32;      ///< of the texture, as in CalibrationTarget
  int rays = 128;          ///< a block of DP pixels, as FlowOptions averages them
  NoiseProfile noise;      ///< of a pixel of a view, in units of the white level and its square; none by default
  std::uint64_t seed = 1;  ///< of textures and noise; every capture has its own texture
};

std::vector<double> sweep_focus_distances(const SweepOptions& options);

/// From far to near. `lens` is focused; `pixel_pitch_um` is that of a DP pixel.
std::vector<double> sweep_target_distances(const simulator::Lens& lens, double dp_pitch_um,
                                           const SweepOptions& options);

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
  std::vector<double> targets_;
  TargetCamera camera_;
  float dp_px_per_pixel_ = 1;  ///< of the views that camera_ sees
};

/// The whole sweep. With a folder (not empty) every measurement is kept there as soon as it is made, and one that is
/// there already is not made again. Throws InputError where the lens cannot be focused so near.
std::vector<pipeline::TargetMeasurement> run_sweep(const simulator::Simulation& simulation, const SweepOptions& options,
                                                   const std::string& folder = "",
                                                   const std::function<void(double fraction)>& progress = {});

}  // namespace dualpixel::tools
