#pragma once
#include <nlohmann/json.hpp>

#include "capture/json_fields.h"
#include "simulator/lens/split/split_pixel.h"

namespace dualpixel::simulator {

/// Reads the object `split` of a lens. Throws InputError.
SplitPixel read_split(Fields fields);

/// The same object as a lens file has it.
nlohmann::ordered_json split_json(const SplitPixel& split);

}  // namespace dualpixel::simulator
