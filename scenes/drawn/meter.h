#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenes/drawn/scene_builder.h"

namespace dualpixel::scenes {

/// The scene file with a picture of `width_px` photosites, 3/4 as high, of the same field of view: behind a thin lens,
/// which is prepared at once, and with light sampled instead of kept. For RenderOptions::ideal_aperture_scale 0.
nlohmann::json small_picture(const nlohmann::json& scene, int width_px);

/// Nits to the signal of such a picture over the white level, as scene.exposure has it. A sensor's defaults at f/1.8.
double signal_per_nit(const nlohmann::json& scene);

/// Sets exposure.time_s, exposure.iso and camera.focus_distance_m of `scene` by what its camera sees of the glTF file
/// beside `scene_path`: a small picture through a pinhole. `seed` picks the surface in focus where the shooting has
/// none; `stops` brightens (positive) or darkens. Returns what is wrong with the scene, one line each: a view that
/// shows nothing (view_fault()), light for which no exposure is long or short enough; one that is less than a
/// stop too short is taken as it is.
std::vector<std::string> meter(nlohmann::json& scene, const std::string& scene_path, const Shooting& shooting,
                               std::uint64_t seed, double stops);

/// An exposure that is not what was asked for. All in seconds at ISO 100.
struct MissedExposure {
  double asked_s = 0;  ///< infinite where no exposure gives the mean: too much is black, or white too low
  double limit_s = 0;  ///< of the camera; or what the brightest of the picture allows
  double taken_s = 0;  ///< the limit, rounded
};

/// One line without an end.
std::string to_text(const MissedExposure& missed);
nlohmann::ordered_json to_json(const MissedExposure& missed);

/// Sets exposure.time_s and iso of `scene` to what stands for `seconds` at ISO 100, as a phone's camera shares light
/// between time and gain: up to 1/60 s at ISO 100, then both grow, to 1/12 s at ISO 12800. Returns what it missed where
/// that is not enough, or where less than a microsecond is asked for.
std::optional<MissedExposure> set_exposure(nlohmann::json& scene, double seconds, int digits);

}  // namespace dualpixel::scenes
