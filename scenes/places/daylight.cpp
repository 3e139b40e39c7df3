#include "scenes/places/places.h"

namespace dualpixel::scenes {

void set_daylight(SceneBuilder& build, RandomStream rng, const std::string& light) {
  const float azimuth = rng.uniform(-180, 180);
  if (light == "sun") {
    const float elevation = rng.uniform(15, 60), haze = rng.uniform(0.8f, 1.5f);
    build.sky(elevation, azimuth, rng.uniform(40000, 90000), 3500 * haze, 7500 * haze, 2200);
  } else if (light == "overcast") {
    build.sky(50, azimuth, 0, 3800, 3200, 600);
    build.scene["environment"]["zenith_nits"] = rng.uniform(2500, 4500);
  } else if (light == "dusk") {
    const float level = rng.uniform(0.5f, 1.6f);
    build.sky(rng.uniform(-2, 4), azimuth, 0, 30 * level, 110 * level, 6 * level);
    build.scene["environment"]["sun_glow_nits"] = 500 * level;
    build.scene["environment"]["sun_glow_width_deg"] = 25;
    build.shooting.key = 0.1f;
  } else {  // night
    build.sky(-20, azimuth, 0, 0.02f, 0.15f, 0.02f);
    build.shooting.key = 0.022f;
    build.shooting.most_clipped = 0.02f;
  }
}

float lamp_nits(const std::string& light) { return light == "night" ? 8000.0f : light == "dusk" ? 4500.0f : 0.0f; }

}  // namespace dualpixel::scenes
