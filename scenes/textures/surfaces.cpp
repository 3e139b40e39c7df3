#include "scenes/textures/surfaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/math.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

float clamp01(float x) { return std::clamp(x, 0.0f, 1.0f); }

/// A whole number of parts of about `part` each.
int parts(float whole, float part) { return std::max(static_cast<int>(std::lround(whole / part)), 1); }

vec3 from_hue(float hue, float saturation, float value) {
  vec3 rgb;
  for (int c = 0; c < 3; ++c) {
    rgb[c] = clamp01(std::abs(fraction(hue + static_cast<float>(3 - c) / 3) * 6 - 3) - 1);
  }
  return value * glm::mix(vec3(1), rgb, saturation);
}

}  // namespace

vec3 paint_color(RandomStream& rng) {
  const float kind = rng.uniform(), hue = rng.uniform(), t = rng.uniform(), s = rng.uniform();
  if (kind < 0.22f) return vec3(0.55f + 0.25f * t) * vec3(1, 1 - 0.05f * s, 1 - 0.16f * s);  // whites, creams
  if (kind < 0.36f) return vec3(0.08f + 0.3f * t) * vec3(1, 1 - 0.08f * s, 1 - 0.2f * s);    // grays, beiges
  if (kind < 0.46f) return vec3(0.025f + 0.04f * t);                                         // near black
  if (kind < 0.75f) return from_hue(hue, 0.35f + 0.35f * s, 0.1f + 0.3f * t);                // muted
  return from_hue(hue, 0.6f + 0.3f * s, 0.25f + 0.4f * t);                                   // bright
}

vec3 wood_color(RandomStream& rng) {
  const float t = rng.uniform(), s = rng.uniform();
  return glm::mix(vec3(0.09f, 0.045f, 0.022f), vec3(0.5f, 0.34f, 0.19f), t) * (0.85f + 0.3f * s);
}

Surface plain_surface(RandomStream rng, vec3 color, float roughness, float contrast) {
  const PinkNoise noise(rng.seed(), 2, 256, 1.4f);
  Surface surface;
  surface.texture = paint(256, [&](float u, float v) { return shaded(color, contrast, noise(u, v)); });
  surface.repeat_m = 0.2f;
  surface.roughness = roughness;
  return surface;
}

Surface metal_surface(RandomStream rng, vec3 color, float roughness) {
  Surface surface = plain_surface(rng, color, roughness, 0.03f);
  surface.metallic = 1;
  return surface;
}

Surface wood_surface(RandomStream rng, vec3 color, float board_m, float repeat_m) {
  const int boards = board_m > 0 ? parts(repeat_m, board_m) : 1;
  const std::uint32_t seed = rng.seed();
  const PinkNoise bend(rng.seed(), 2, 16, 2.0f), fiber(rng.seed(), 8, 64, 1.1f, 8, 1), patch(rng.seed(), 2, 64, 1.3f);
  const float rings = rng.uniform(5, 11), strength = rng.uniform(0.1f, 0.28f);
  Surface surface;
  surface.repeat_m = repeat_m;
  surface.roughness = rng.uniform(0.45f, 0.9f);
  surface.texture = paint(1024, [&, board_m](float u, float v) {
    const float x = u * static_cast<float>(boards);
    const int board = std::min(static_cast<int>(x), boards - 1);
    const float own = hash01(seed, board), shift = hash01(seed, board, 1);
    const float in = x - static_cast<float>(board);
    const float swirl = bend(u, v + shift);
    const float ring = fraction((in + 0.35f * swirl) * rings + 3 * own);
    const float late = ring * ring * (ring < 0.93f ? 1.0f : (1 - ring) / 0.07f);  // late wood darkens, then it ends
    float tone = -strength * 2.2f * late + 0.09f * fiber(u, v + shift) + 0.1f * patch(u, v);
    tone += 0.45f * (own - 0.5f);
    const float joint = board_m > 0 ? std::min(in, 1 - in) * board_m : 1.0f;
    if (joint < 0.0016f) tone -= 1.3f;
    return shaded(color * vec3(1, 1 - 0.12f * late, 1 - 0.25f * late), 1, tone);
  });
  return surface;
}

Surface rough_surface(RandomStream rng, vec3 color, float contrast, float repeat_m, float slope) {
  const PinkNoise noise(rng.seed(), 2, 256, slope), hue(rng.seed(), 2, 32, 1.5f);
  const float warm = rng.uniform(0, 0.1f);
  Surface surface;
  surface.repeat_m = repeat_m;
  surface.texture = paint(512, [&](float u, float v) {
    const float h = warm * hue(u, v);
    return shaded(color * vec3(1 + h, 1, 1 - h), contrast, noise(u, v));
  });
  return surface;
}

Surface brick_surface(RandomStream rng, vec3 color) {
  constexpr int kColumns = 5, kRows = 16;  // of 0.24 m x 0.075 m
  const std::uint32_t seed = rng.seed();
  const PinkNoise grain(rng.seed(), 8, 512, 1.2f), patch(rng.seed(), 2, 16, 1.2f), edge(rng.seed(), 32, 256, 1.2f);
  const vec3 mortar = vec3(rng.uniform(0.18f, 0.45f)) * vec3(1, 0.95f, 0.86f);
  const float variety = rng.uniform(0.12f, 0.4f);
  Surface surface;
  surface.repeat_m = 1.2f;
  surface.texture = paint(512, [&](float u, float v) {
    const float y = v * kRows;
    const int row = std::min(static_cast<int>(y), kRows - 1);
    const float x = u * kColumns + (row % 2 != 0 ? 0.5f : 0.0f);
    const int column = static_cast<int>(x) % kColumns;
    const float dx = std::min(fraction(x), 1 - fraction(x)) * 0.24f,
                dy = std::min(fraction(y), 1 - fraction(y)) * 0.075f;
    const float joint = clamp01((std::min(dx, dy) - 0.005f - 0.0012f * edge(u, v)) / 0.0025f);
    const float own = hash01(seed, column, row) - 0.5f;
    const vec3 brick = shaded(color * vec3(1, 1 + 0.25f * own, 1 + 0.3f * own), 1,
                              0.14f * grain(u, v) + 0.12f * patch(u, v) + 2 * variety * own);
    return glm::mix(shaded(mortar, 0.13f, grain(v, u)), brick, joint);
  });
  return surface;
}

Surface tile_surface(RandomStream rng, vec3 color, vec3 joint_color, vec2 tile_m, float variety) {
  const int columns = parts(1.2f, tile_m.x), rows = parts(1.2f, tile_m.y);
  const bool staggered = rows % 2 == 0 && rng.chance(0.5f);
  const std::uint32_t seed = rng.seed();
  const PinkNoise grain(rng.seed(), 4, 512, 1.2f), edge(rng.seed(), 32, 256, 1.2f);
  const float joint_m = std::clamp(0.03f * std::min(tile_m.x, tile_m.y), 0.0015f, 0.008f);
  Surface surface;
  surface.repeat_m = 1.2f;
  surface.roughness = rng.chance(0.5f) ? rng.uniform(0.15f, 0.5f) : 0.9f;
  surface.texture = paint(512, [&](float u, float v) {
    const float y = v * static_cast<float>(rows);
    const int row = std::min(static_cast<int>(y), rows - 1);
    const float x = u * static_cast<float>(columns) + (staggered && row % 2 != 0 ? 0.5f : 0.0f);
    const int column = static_cast<int>(x) % columns;
    const float dx = std::min(fraction(x), 1 - fraction(x)) * tile_m.x,
                dy = std::min(fraction(y), 1 - fraction(y)) * tile_m.y;
    const float inside = clamp01((std::min(dx, dy) - joint_m * (0.5f + 0.1f * variety * edge(u, v))) / 0.0015f);
    const float own = hash01(seed, column, row) - 0.5f;
    return glm::mix(shaded(joint_color, 0.2f, grain(v, u)),
                    shaded(color, 1, variety * (1.6f * own + 0.35f * grain(u, v))), inside);
  });
  return surface;
}

Surface woven_surface(RandomStream rng, vec3 color, vec3 second, float thread_m) {
  constexpr int kTexelsAThread = 8, kSize = 512;
  const int threads = kSize / kTexelsAThread;
  const std::uint32_t seed = rng.seed();
  const PinkNoise fuzz(rng.seed(), 8, 512, 1.0f), patch(rng.seed(), 2, 32, 1.4f);
  const int pattern = rng.below(4);  // plain twice, stripes, checks
  const int period = 8 << rng.below(3);
  const float share = rng.uniform(0.2f, 0.6f);
  Surface surface;
  surface.repeat_m = thread_m * static_cast<float>(threads);
  surface.texture = paint(kSize, [&](float u, float v) {
    const float x = u * static_cast<float>(threads), y = v * static_cast<float>(threads);
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const bool warp = (i + j) % 2 == 0;  // plain weave: which thread is on top
    const float ridge = std::sin(std::numbers::pi_v<float> * fraction(warp ? x : y));
    const float own = warp ? hash01(seed, i) : hash01(seed, j, 1);
    const auto dyed = [&](int k) {
      return pattern >= 2 && static_cast<float>(k % period) < share * static_cast<float>(period);
    };
    const bool other = warp ? dyed(i) : pattern == 3 && dyed(j);
    const float tone = 0.3f * (ridge - 0.64f) + 0.25f * (own - 0.5f) + 0.08f * fuzz(u, v) + 0.05f * patch(u, v);
    return shaded(other ? second : color, 1, tone);
  });
  return surface;
}

Surface bark_surface(RandomStream rng, vec3 color) {
  const PinkNoise ridge(rng.seed(), 4, 64, 1.1f, 4, 1), grain(rng.seed(), 4, 256, 1.1f);
  Surface surface;
  surface.repeat_m = 0.5f;
  surface.texture = paint(512, [&](float u, float v) {
    const float crack = std::abs(ridge(u + 0.01f * grain(u, v), v));
    return shaded(color, 1, -0.8f * std::max(0.6f - crack, 0.0f) + 0.16f * grain(u, v));
  });
  return surface;
}

Surface leaf_surface(RandomStream rng, vec3 color, vec3 other) {
  const PinkNoise noise(rng.seed(), 4, 128, 1.2f);
  Surface surface;
  surface.roughness = rng.uniform(0.45f, 0.8f);
  surface.texture = paint(256, [&](float u, float v) {
    const float mix = 0.5f - 0.5f * std::cos(kTurn * u);
    return shaded(glm::mix(color, other, mix), 0.12f, noise(u, v));
  });
  return surface;
}

Surface glowing_surface(vec3 nits) {
  Surface surface;
  surface.color = vec3(0);
  surface.emission_nits = nits;
  return surface;
}

}  // namespace dualpixel::scenes
