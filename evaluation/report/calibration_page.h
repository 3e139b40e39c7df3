#pragma once
#include <string>
#include <vector>

#include "pipeline/calibration/calibration.h"

/// A calibration folder, read back and shown.
namespace dualpixel::evaluation {

/// DIR/calibration.json. Throws InputError.
pipeline::Calibration read_calibration_folder(const std::string& folder);

/// What the lines were fitted to: DIR/measurements, where it is there.
std::vector<pipeline::TargetMeasurement> read_measurements(const std::string& folder);

/// One self-contained page: lines and maps as in Wadhwa et al. 2018, Fig. 7, and how slope and intercept change with
/// the focus distance.
std::string to_page(const pipeline::Calibration& calibration,
                    const std::vector<pipeline::TargetMeasurement>& measurements);

}  // namespace dualpixel::evaluation
