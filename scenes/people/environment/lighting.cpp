#include "scenes/people/environment/lighting.h"

#include <cmath>

namespace dualpixel::scenes {
namespace {

/// Colors and directions that all kinds of lighting are drawn with.
struct Palette {
  float side = 1, turn = 0, up = 0;
  vec3 sky{0}, warm{0}, ground{0};
};

vec3 towards(float around, float height) {
  return vec3(std::sin(around) * std::cos(height), std::sin(height), std::cos(around) * std::cos(height));
}

/// Dome and key light of one kind.
void apply_lighting(SceneModel& scene, RandomStream& rng, LightingKind kind, const Palette& palette) {
  const float side = palette.side;
  const vec3 sky = palette.sky, warm = palette.warm, ground = palette.ground;
  DomeLight& dome = scene.dome;
  KeyLight& key = scene.key;
  switch (kind) {
    case LightingKind::overcast:
      dome.up = vec3(1.1f), dome.horizon = vec3(0.75f), dome.down = ground * 0.6f;
      key.irradiance = vec3(rng.uniform(0.05f, 0.25f)), key.spread = 0.3f;
      break;
    case LightingKind::sun_side:
      dome.up = 0.4f * sky, dome.horizon = 0.6f * sky, dome.down = ground;
      key.irradiance = vec3(1.6f, 1.5f, 1.35f) * rng.uniform(0.6f, 1.2f), key.spread = 0.02f;
      break;
    case LightingKind::sun_behind:
      dome.up = 0.6f * sky, dome.horizon = 0.8f * sky, dome.down = ground;
      key.direction = towards(side * rng.uniform(2, 3.1f), rng.uniform(0.3f, 1));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1, 0.95f, 0.8f) * rng.uniform(0.5f, 3);
      key.irradiance = vec3(2, 1.85f, 1.6f), key.spread = 0.02f;
      break;
    case LightingKind::window:
      dome.up = vec3(0.35f), dome.horizon = vec3(0.3f), dome.down = ground * 0.6f;
      key.direction = towards(side * rng.uniform(0.9f, 1.8f), rng.uniform(0.0f, 0.6f));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1, 1, 1.05f) * rng.uniform(0.6f, 2);
      key.irradiance = vec3(0.9f, 0.95f, 1), key.spread = rng.uniform(0.1f, 0.35f);
      break;
    case LightingKind::ceiling:
      dome.up = warm * 0.8f, dome.horizon = warm * 0.5f, dome.down = ground;
      key.direction = towards(side * rng.uniform(0, 2.5f), rng.uniform(0.9f, 1.4f));
      key.irradiance = warm * rng.uniform(0.3f, 0.9f), key.spread = rng.uniform(0.06f, 0.3f);
      break;
    case LightingKind::softbox:
      dome.up = vec3(0.25f), dome.horizon = vec3(0.25f), dome.down = vec3(0.2f);
      key.irradiance = vec3(1), key.spread = rng.uniform(0.08f, 0.3f);
      break;
    case LightingKind::flash:
      dome.up = dome.horizon = vec3(rng.uniform(0.05f, 0.2f)), dome.down = vec3(0.05f);
      key.direction = towards(side * rng.uniform(0, 0.12f), rng.uniform(0.0f, 0.2f));
      key.irradiance = vec3(1.1f), key.spread = 0.02f;
      break;
    case LightingKind::lamp:
      dome.up = warm * 0.12f, dome.horizon = warm * 0.15f, dome.down = ground * 0.3f;
      key.direction = towards(side * rng.uniform(0.5f, 2), rng.uniform(-0.1f, 0.8f));
      key.irradiance = warm * 1.2f, key.spread = rng.uniform(0.05f, 0.3f);
      break;
    case LightingKind::golden:
      dome.up = vec3(0.3f, 0.42f, 0.65f), dome.horizon = vec3(0.9f, 0.6f, 0.4f), dome.down = ground;
      key.direction = towards(side * rng.uniform(0.3f, 2.7f), rng.uniform(0.05f, 0.3f));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1.5f, 0.9f, 0.4f);
      key.irradiance = vec3(1.6f, 1, 0.55f), key.spread = 0.04f;
      break;
    case LightingKind::neon: {
      const vec3 one = random_color(rng) + 0.1f, two = random_color(rng) + 0.1f;
      dome.up = vec3(0.08f), dome.horizon = 0.3f * one, dome.down = vec3(0.05f);
      dome.lobe_direction = towards(-side * rng.uniform(0.8f, 2), 0.2f), dome.lobe = 2.0f * one,
      dome.lobe_sharpness = 2;
      key.irradiance = 1.5f * two, key.spread = 0.2f;
      break;
    }
    case LightingKind::skylight:
      dome.up = vec3(1.6f, 1.6f, 1.7f), dome.horizon = vec3(0.2f), dome.down = ground * 0.8f;
      key.direction = towards(side, 1.35f);
      key.irradiance = vec3(0.5f), key.spread = 0.35f;
      break;
  }
}

}  // namespace

std::string set_lighting(SceneModel& scene, RandomStream rng) {
  constexpr const char* kNames[] = {"overcast", "sun",  "sun behind", "window", "ceiling", "softbox",
                                    "flash",    "lamp", "neon",       "golden", "skylight"};
  static_assert(std::size(kNames) == kLightingKinds);
  const int index = rng.choose(kLightingKinds, kReservedLightingKinds);
  Palette palette{};
  palette.side = rng.sign(), palette.turn = rng.uniform(0.2f, 1.3f), palette.up = rng.uniform(0.25f, 1.1f);
  palette.sky = glm::mix(vec3(0.55f, 0.75f, 1.1f), vec3(0.9f, 0.95f, 1), rng.uniform());
  palette.warm = glm::mix(vec3(1, 0.93f, 0.84f), vec3(1, 0.62f, 0.33f), rng.uniform());
  DomeLight& dome = scene.dome;
  KeyLight& key = scene.key;
  key.direction = towards(palette.side * palette.turn, palette.up);
  dome.lobe_direction = key.direction;
  dome.sky = true;
  palette.ground = vec3(0.35f, 0.32f, 0.28f) * rng.uniform(0.4f, 1.2f);
  apply_lighting(scene, rng, static_cast<LightingKind>(index), palette);
  return std::string("light:") + kNames[index];
}

}  // namespace dualpixel::scenes
