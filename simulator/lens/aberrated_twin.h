#pragma once
#include "simulator/lens/lens_sampler.h"

namespace dualpixel::simulator {

/// The aberrated lens that behaves as the prescription of `lens` does: knob by knob fitted to its traced rays over the
/// field of `sensor`, at the focus that `lens` has. The same split pixel, focal length, f-number and focus.
/// Throws std::invalid_argument where `lens` is no prescription.
Lens aberrated_twin(const Lens& lens, const SensorGrid& sensor);

}  // namespace dualpixel::simulator
