#pragma once
#include "simulator/render/adaptive.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// The variance that the sensor adds to a half photosite in a view: shot noise, of white things what the filter's color
/// matrix makes of it, and read-outs.
ErrorTarget sensor_noise(const Simulation& simulation, double lux_per_nit);

}  // namespace dualpixel::simulator
