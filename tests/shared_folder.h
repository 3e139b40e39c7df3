#pragma once
#include <cstdlib>
#include <filesystem>

namespace dualpixel {

/// Where pictures, scenes and measurements of others may lie, which the repository does not hold: what
/// $DUALPIXEL_SHARED names. Tests that need them are skipped where they are missing.
inline std::filesystem::path shared_folder() {
  const char* const named = std::getenv("DUALPIXEL_SHARED");
  return named ? named : DUALPIXEL_SOURCE_DIR "/../shared";
}

}  // namespace dualpixel
