#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scenes/drawn/scene_builder.h"

namespace dualpixel::scenes {

/// Sets exposure.time_s, exposure.iso and camera.focus_distance_m of `scene` by what its camera sees of the glTF file
/// beside `scene_path`: a small picture through a pinhole. `seed` picks the surface in focus where the shooting has
/// none; `stops` brightens (positive) or darkens.
void meter(nlohmann::json& scene, const std::string& scene_path, const Shooting& shooting, std::uint64_t seed,
           double stops);

/// Sets exposure.time_s and iso of `scene` to what stands for `seconds` at ISO 100, as a phone's camera shares light
/// between time and gain: up to 1/60 s at ISO 100, then both grow, to 1/12 s.
void set_exposure(nlohmann::json& scene, double seconds, int digits);

}  // namespace dualpixel::scenes
