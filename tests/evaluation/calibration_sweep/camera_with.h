#pragma once
#include <cmath>
#include <string>

#include "simulator/lens/lens_file.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {

/// A camera with a lens of lens_models/, whose sensor fills the lens's picture where that is known.
inline simulator::Simulation camera_with(const std::string& lens, int width_px = 2688, int height_px = 2016) {
  simulator::Simulation simulation;
  simulation.lens = simulator::read_lens_file(std::string(DUALPIXEL_SOURCE_DIR "/lens_models/") + lens + ".json", 1);
  simulation.sensor.width_px = width_px;
  simulation.sensor.height_px = height_px;
  if (const simulator::Prescription* prescription = simulator::prescription_of(simulation.lens)) {
    simulation.sensor.pixel_pitch_um = 2e3 * prescription->image_radius_mm / std::hypot(width_px, height_px);
  }
  return simulation;
}

}  // namespace dualpixel::evaluation
