#pragma once
#include "simulator/render/adaptive.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// The variance that the sensor adds to a half photosite: shot noise and one read-out.
ErrorTarget sensor_noise(const Simulation& simulation, double lux_per_nit);

}  // namespace dualpixel::simulator
