#pragma once
#include <string>

#include "capture/names.h"
#include "capture/option_ranges.h"

namespace dualpixel::simulator {

struct Environment;

/// Where light from infinity comes from.
enum class EnvironmentModel { none, constant, sky, file };

inline constexpr Named<EnvironmentModel> kEnvironmentModels[] = {
    {"none", EnvironmentModel::none, "black"},
    {"constant", EnvironmentModel::constant, "the same radiance everywhere"},
    {"sky", EnvironmentModel::sky, "a procedural sky over a ground"},
    {"file", EnvironmentModel::file, "an equirectangular EXR or HDR picture"},
};

/// An equirectangular EXR or HDR file; pixel values times `nits_per_unit` are nits. Throws InputError on other formats,
/// values outside of [0, 1e12] nits, and pictures over 16384 x 8192.
Environment read_environment(const std::string& path, float nits_per_unit);

struct SkyOptions {
  float sun_elevation_deg = 35;
  float sun_azimuth_deg = 40;  ///< from -z towards +x
  float zenith_nits = 3000;    ///< clear blue overhead
  float horizon_nits = 6000;
  float ground_nits = 800;        ///< what the lower half sends up
  float sun_glow_nits = 40000;    ///< peak of the bright lobe around the sun; the disc itself is a directional light
  float sun_glow_width_deg = 12;  ///< standard deviation of the lobe

  bool operator==(const SkyOptions&) const = default;
};

inline constexpr OptionRange<SkyOptions> kSkyRanges[] = {
    {"sun_elevation_deg", &SkyOptions::sun_elevation_deg, -90, 90},
    {"sun_azimuth_deg", &SkyOptions::sun_azimuth_deg, -360, 360},
    {"zenith_nits", &SkyOptions::zenith_nits, 0, 1e9},
    {"horizon_nits", &SkyOptions::horizon_nits, 0, 1e9},
    {"ground_nits", &SkyOptions::ground_nits, 0, 1e9},
    {"sun_glow_nits", &SkyOptions::sun_glow_nits, 0, 1e9},
    {"sun_glow_width_deg", &SkyOptions::sun_glow_width_deg, 0.5, 90},
};

inline std::optional<OptionProblem> check(const SkyOptions& sky) { return check_ranges(sky, kSkyRanges); }

/// A procedural sky, smooth enough that few light samples do.
Environment make_sky(const SkyOptions& options, int width = 512);

}  // namespace dualpixel::simulator
