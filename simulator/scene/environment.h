#pragma once
#include <string>

#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

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
};

/// A procedural sky, smooth enough that few light samples do.
Environment make_sky(const SkyOptions& options, int width = 512);

}  // namespace dualpixel::simulator
