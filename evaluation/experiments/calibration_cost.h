#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/calibration/tilt.h"
#include "simulator/lens/disparity_field.h"

/// What a cheaper calibration costs: fewer photographs, noise, another texture, a tilted target.
namespace dualpixel::evaluation {

inline constexpr double kCostFocus_m = 0.69;  ///< of the captures to correct; no sweep measures there
inline constexpr double kCostDepths_m[] = {0.45, 0.9, 2.2};

/// One way to calibrate: the full sweep of 20 focus and 8 target distances with one setting changed.
struct CalibrationEffort {
  std::string axis, value;  ///< the setting, and what it is changed to
  SweepOptions sweep;
  double residual_dp_px = 0;  ///< deviation of a plane's disparity over the field after correction
  pipeline::TargetTilt tilt;  ///< as the calibration estimates it
  bool warned = false;        ///< of a tilted target
  double memory_mb = 0;       ///< at most, besides what was held before; part of it goes into drawing the target

  int photographs() const { return sweep.focuses * sweep.targets; }
};

struct CalibrationCost {
  std::string lens;
  /// Standard deviation of the disparity of planes at kCostDepths_m over the inner 90 % of the field, RMS over the
  /// depths, before correction.
  double uncorrected_dp_px = 0;
  std::vector<CalibrationEffort> efforts;
};

/// Deviation of a plane's disparity over the inner 90 % of the field, RMS over kCostDepths_m.
double field_deviation_dp_px(const simulator::DisparityField& field, const Camera& camera,
                             const pipeline::Correction* correction);

CalibrationCost measure_calibration_cost(const simulator::Simulation& simulation,
                                         const std::function<void(double fraction)>& progress);

nlohmann::ordered_json to_json(const CalibrationCost& cost);
std::string to_page(const CalibrationCost& cost);

}  // namespace dualpixel::evaluation
