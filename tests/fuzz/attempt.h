#pragma once
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "tests/temporary_folder.h"

/// What the libFuzzer targets share. Any bytes must be read or be an InputError; whatever else is thrown ends the
/// fuzzer.
namespace dualpixel::fuzz {

/// The bytes that the fuzzer made.
inline std::string text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

template <typename Act>
int attempt(const Act& act) {
  try {
    act();
  } catch (const InputError&) {
  }
  return 0;
}

/// For readers that take paths: a folder for as long as the fuzzer runs.
inline const TemporaryFolder& folder() {
  static const TemporaryFolder made;
  return made;
}

}  // namespace dualpixel::fuzz
