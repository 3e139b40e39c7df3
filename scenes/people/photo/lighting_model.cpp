#include "scenes/people/photo/lighting_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/people/shape/reflectance.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

constexpr float kDomeReach_m = 0.7f;  ///< nearer objects darken
constexpr float kKeyReach_m = 4;      ///< nearer objects cast a shadow; walls farther away let the light of windows in

vec3 dome_radiance(const DomeLight& dome, vec3 d) {
  const float height = std::sqrt(std::abs(d.y));
  const vec3 gradient = glm::mix(dome.horizon, d.y > 0 ? dome.up : dome.down, height);
  return gradient + dome.lobe * std::exp(dome.lobe_sharpness * (glm::dot(d, dome.lobe_direction) - 1));
}

/// Approximate cosine-weighted mean of the radiance over the hemisphere about a normal.
vec3 dome_irradiance(const DomeLight& dome, vec3 n) {
  const vec3 gradient = 0.5f * dome.horizon + (0.25f + 0.25f * n.y) * dome.up + (0.25f - 0.25f * n.y) * dome.down;
  const float facing = std::max((glm::dot(n, dome.lobe_direction) + 0.4f) / 1.4f, 0.0f);
  return gradient + dome.lobe * (1.6f / dome.lobe_sharpness * facing);
}

/// Two unit directions perpendicular to n and to each other.
void across(vec3 n, vec3& x, vec3& y) {
  x = glm::normalize(std::abs(n.y) < 0.9f ? glm::cross(n, vec3(0, 1, 0)) : glm::cross(n, vec3(1, 0, 0)));
  y = glm::cross(n, x);
}

vec3 cosine_direction(vec3 n, float u, float v) {
  vec3 x, y;
  across(n, x, y);
  const float r = std::sqrt(u), phi = 2 * std::numbers::pi_v<float> * v;
  return glm::normalize(r * std::cos(phi) * x + r * std::sin(phi) * y + std::sqrt(std::max(1 - u, 0.0f)) * n);
}

}  // namespace

vec3 background_radiance(const DomeLight& dome, vec3 d) {
  vec3 color = dome_radiance(dome, d);
  if (!dome.sky || d.y < 0) return color;
  const float clouds = fractal(dome.seed, d * (2.2f / (0.25f + d.y)), 4);
  const float cover = std::clamp(3 * (clouds - 0.5f), 0.0f, 1.0f);
  return glm::mix(color, vec3(0.9f) * (0.3f + glm::dot(color, vec3(0.33f))), cover);
}

LightSample sample_light(const SceneModel& scene, const SceneObject& object, const glm::uvec3& t, float b1, float b2,
                         vec3 eye_direction, bool key, float u, float v) {
  const float b0 = 1 - b1 - b2;
  const auto at = [&](const std::vector<vec3>& values) {
    return b0 * values[t.x] + b1 * values[t.y] + b2 * values[t.z];
  };
  const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
  const vec3 color = reflectance(material, at(object.rest));
  vec3 geometric =
      glm::cross(object.positions[t.y] - object.positions[t.x], object.positions[t.z] - object.positions[t.x]);
  const float area = glm::length(geometric);
  geometric = area > 0 ? geometric / area : vec3(0, 1, 0);
  if (glm::dot(geometric, eye_direction) > 0) geometric = -geometric;
  vec3 n = at(object.normals);
  const float length = glm::length(n);
  n = length > 1e-6f ? n / length : geometric;
  if (glm::dot(n, geometric) < 0) n = -n;
  LightSample lit;
  lit.origin = at(object.positions) + 0.0015f * geometric;
  lit.seen = lit.hidden = color * material.emission;
  constexpr float kShare = 2;  // each kind of light is asked for by half of the samples, which are a net of their own
  if (key) {
    const KeyLight& light = scene.key;
    vec3 x, y;
    across(light.direction, x, y);
    const float r = light.spread * std::sqrt(u), phi = 2 * std::numbers::pi_v<float> * v;
    lit.towards = glm::normalize(light.direction + r * std::cos(phi) * x + r * std::sin(phi) * y);
    lit.reach_m = kKeyReach_m;
    const float cosine = glm::dot(n, light.direction);
    // light wraps around under skin and through leaves, red furthest
    const vec3 wrap = material.softness * vec3(1, 0.55f, 0.45f);
    const vec3 diffuse = glm::max((vec3(cosine) + wrap) / (1.0f + wrap), vec3(0));
    vec3 arriving = color * diffuse;
    if (material.gloss > 0 && cosine > 0) {
      const vec3 half = glm::normalize(light.direction - eye_direction);
      arriving += material.gloss * 0.06f * (material.gloss_power + 2) * cosine *
                  std::pow(std::max(glm::dot(n, half), 0.0f), material.gloss_power) *
                  glm::mix(vec3(1), color * 2.0f, 0.4f);
    }
    lit.seen += kShare * arriving * light.irradiance;
    if (diffuse == vec3(0)) lit.reach_m = 0;
    return lit;
  }
  lit.towards = cosine_direction(n, u, v);
  lit.reach_m = glm::dot(lit.towards, geometric) > 0 ? kDomeReach_m : 0;
  // the irradiance of the whole dome times the unoccluded fraction: less noise than the radiance of single directions
  const vec3 ambient = dome_irradiance(scene.dome, n);
  lit.seen += kShare * color * ambient;
  lit.hidden += kShare * 0.35f * color * ambient * glm::mix(vec3(1), color, 0.5f);  // what the neighbor gives back
  return lit;
}

}  // namespace dualpixel::scenes
