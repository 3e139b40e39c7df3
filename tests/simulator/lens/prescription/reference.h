#pragma once
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"

/// Fourteen published lenses and what an independent tracer computed for them.
namespace dualpixel::simulator::testing {

inline const nlohmann::json& reference() {
  static const nlohmann::json json = read_json_file(DUALPIXEL_SOURCE_DIR "/tests/data/optics/reference_numbers.json");
  return json;
}

inline std::vector<std::string> lens_names() {
  std::vector<std::string> names;
  for (const auto& [name, lens] : reference()["lenses"].items()) names.push_back(name);
  return names;
}

/// Focused on infinity, as the reference has it.
inline Lens reference_lens(const nlohmann::json& figures) {
  return read_lens_file(std::string(DUALPIXEL_SOURCE_DIR "/") + figures["file"].get<std::string>(),
                        std::numeric_limits<double>::infinity());
}

}  // namespace dualpixel::simulator::testing
