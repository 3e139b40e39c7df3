#pragma once
#include <algorithm>
#include <cmath>

#include "scenes/people/shape/material.h"
#include "scenes/procedural/noise.h"
#include "scenes/procedural/signed_distance.h"

/// What reflectance() is made of: one function for each kind of pattern.
namespace dualpixel::scenes {

/// 0 below 0, 1 above `width`, smooth between.
inline float smooth_step(float x, float width = 1) {
  const float t = std::clamp(x / width, 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

/// Sawtooth: the fractional part.
inline float saw(float x) { return x - std::floor(x); }
/// 0 .. 1 .. 0 over one repeat.
inline float triangle(float x) { return 1 - std::abs(2 * saw(x) - 1); }

/// Cellular noise (Worley 1996): the distance to the nearest of scattered points, one per unit square, and its random
/// number.
inline float cells(std::uint32_t seed, vec2 p, float& own) {
  const glm::ivec2 base(glm::floor(p));
  float nearest = 9;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const int x = base.x + i, y = base.y + j;
      const float d = glm::distance(p, vec2(x, y) + vec2(hash01(seed, x, y), hash01(seed, x, y, 1)));
      if (d >= nearest) continue;
      nearest = d;
      own = hash01(seed, x, y, 2);
    }
  }
  return nearest;
}

// people
vec3 face_pattern(const Material& material, vec3 p);
vec3 eye_pattern(const Material& material, vec3 direction);
vec3 hair_pattern(const Material& material, vec3 p);

// fabrics: those of Material::Kind from plain to camouflage, but for medley
vec3 fabric_pattern(const Material& material, vec3 p);

// environments: those of Material::Kind from rough to graffiti
vec3 environment_pattern(const Material& material, vec3 p);

/// Random mixtures of thirteen patterns, as the seed says.
vec3 medley_pattern(const Material& material, vec3 p);

}  // namespace dualpixel::scenes
