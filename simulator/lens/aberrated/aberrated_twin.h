#pragma once
#include "simulator/lens/lens.h"

namespace dualpixel::simulator {

/// The aberrated lens that behaves as the prescription of `lens` does: each aberration fitted to its traced rays over
/// its image circle. The same split pixel, focal length and focus. Throws InputError where `lens` is no prescription,
/// or where part of its image circle is dark.
Lens aberrated_twin(const Lens& lens);

}  // namespace dualpixel::simulator
