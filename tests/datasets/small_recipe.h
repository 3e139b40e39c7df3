#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/temporary_folder.h"

/// Recipes whose samples take some hundredths of a second.
namespace dualpixel::datasets::testing {

inline nlohmann::json small_recipe(int count = 6) {
  return {{"version", 1},
          {"count", count},
          {"seed", 5},
          {"scenes",
           {{{"file", DUALPIXEL_SCENES_DIR "/slanted_planes.json"}},
            {{"file", DUALPIXEL_SCENES_DIR "/occlusion_edges.json"}}}},
          {"set",
           {{"sensor.width_px", 64},
            {"sensor.height_px", 48},
            {"sensor.pixel_pitch_um", 58.8},
            {"burst.frames", 1},
            {"exposure.iso", {{"choice", {100, 200}}}},
            {"render.light_spacing_px", 0},
            {"render.samples_per_pixel", 4},
            {"render.photograph_samples_per_pixel", 2},
            {"render.all_in_focus_samples_per_pixel", 2}}},
          {"relations", {{"focus", "surface"}}},
          {"layout", "npy"},
          {"keep", {"left", "right", "view_disparity_dp_px", "depth_m"}}};
}

/// The bytes of all files under a folder, by their paths in it.
inline std::map<std::string, std::string> bytes_under(const std::string& folder) {
  std::map<std::string, std::string> bytes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes[entry.path().lexically_relative(folder)] = read_bytes(entry.path());
  }
  return bytes;
}

}  // namespace dualpixel::datasets::testing
