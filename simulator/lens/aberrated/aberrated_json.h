#pragma once
#include <nlohmann/json.hpp>

#include "simulator/lens/lens.h"

namespace dualpixel::simulator {

/// A lens whose model is aberrated, as the text of a lens file.
nlohmann::ordered_json aberrated_lens_json(const Lens& lens);

}  // namespace dualpixel::simulator
