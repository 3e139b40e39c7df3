#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/math.h"
#include "scenes/textures/lettering.h"
#include "scenes/things/things.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

/// Ceramics, enamel, metal.
Surface dish_surface(RandomStream& rng) {
  if (rng.chance(0.15f)) {
    const vec3 color = rng.chance(0.5f) ? vec3(0.62f, 0.6f, 0.57f) : vec3(0.72f, 0.47f, 0.3f);
    return metal_surface(rng.substream(1), color, rng.uniform(0.15f, 0.45f));
  }
  return plain_surface(rng.substream(1), paint_color(rng), rng.uniform(0.15f, 0.8f), 0.05f);
}

/// The outside of a vessel turned into one with a wall of `wall`: down again inside to `floor`.
std::vector<vec2> hollow(std::vector<vec2> outside, float wall, float floor) {
  std::vector<vec2> profile = outside;
  for (auto p = outside.rbegin(); p != outside.rend(); ++p) {
    const vec2 in(std::max(p->x - wall, 0.0f), std::max(p->y, floor));
    if (in.x > 0.002f && (profile.back().y > floor || in.y > floor)) profile.push_back(in);
  }
  profile.push_back({0, floor});
  return profile;
}

}  // namespace

void add_mug(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.034f, 0.046f), h = rng.uniform(0.07f, 0.11f), foot = rng.uniform(0.7f, 1.0f) * r;
  const float belly = rng.uniform(-0.05f, 0.18f);
  std::vector<vec2> outside = {{0, 0.002f}, {foot * 0.8f, 0.002f}, {foot * 0.88f, 0}, {foot, 0.004f}};
  for (int i = 1; i <= 10; ++i) {
    const float t = static_cast<float>(i) / 10;
    outside.push_back({(foot + (r - foot) * t) * (1 + belly * std::sin(kPi * t)), 0.004f + (h - 0.004f) * t});
  }
  Mesh mug;
  add_lathe(mug, glm::mat4(1), hollow(outside, 0.0035f, 0.006f));
  const float top = 0.82f * h, bottom = 0.25f * h, out = rng.uniform(0.02f, 0.03f);
  const float at = 0.5f * (foot + r) * (1 + 0.8f * belly);
  add_pipe(mug,
           curve(20,
                 [&](float t) {
                   const float phi = kPi * (t - 0.5f);
                   return vec3(at - 0.003f + out * std::cos(phi),
                               0.5f * (top + bottom) + 0.5f * (top - bottom) * std::sin(phi), 0);
                 }),
           rng.uniform(0.0038f, 0.0055f), 10);
  build.add("mug", placed_mesh(mug, pose), dish_surface(rng));
  if (rng.chance(0.6f)) {
    Mesh drink;
    const float level = rng.uniform(0.6f, 0.88f);
    add_lathe(drink, pose, {{at * 0.99f - 0.003f, level * h}, {0, level * h + 0.0001f}});
    build.add("drink", drink, plain_surface(rng.substream(2), vec3(0.06f, 0.03f, 0.014f), 0.1f));
  }
  if (rng.chance(0.35f)) {
    Mesh saucer;
    add_lathe(saucer, glm::translate(pose, vec3(0, -0.0005f, 0)),
              {{0, 0.001f}, {0.04f, 0.001f}, {0.075f, 0.011f}, {0.073f, 0.0125f}, {0.04f, 0.0035f}, {0, 0.003f}});
    build.add("saucer", saucer, dish_surface(rng));
  }
}

void add_bowl(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.07f, 0.13f), h = r * rng.uniform(0.4f, 0.75f), power = rng.uniform(1.6f, 3);
  std::vector<vec2> outside = {{0, 0.002f}, {0.38f * r, 0}, {0.4f * r, 0.004f}};
  for (int i = 1; i <= 12; ++i) {
    const float t = static_cast<float>(i) / 12;
    outside.push_back({r * (0.4f + 0.6f * t), 0.004f + (h - 0.004f) * std::pow(t, power)});
  }
  Mesh bowl;
  add_lathe(bowl, pose, hollow(outside, 0.004f, 0.008f), 64);
  build.add("bowl", bowl, dish_surface(rng));
  const int fruit = rng.below(6);
  for (int i = 0; i < fruit; ++i) {
    const float phi = 2.4f * static_cast<float>(i), out = i == fruit - 1 && fruit > 3 ? 0 : 0.5f * r;
    const float up = i == fruit - 1 && fruit > 3 ? 0.062f : 0.3f * h;
    add_fruit(build, rng.substream(10 + i), glm::translate(pose, vec3(out * std::cos(phi), up, out * std::sin(phi))));
  }
}

void add_bottle(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.026f, 0.042f), h = rng.uniform(0.16f, 0.3f), neck = rng.uniform(0.28f, 0.5f) * r;
  const float shoulder = rng.uniform(0.5f, 0.72f) * h, rise = rng.uniform(0.06f, 0.2f) * h;
  std::vector<vec2> profile = {{0, 0.001f}, {0.85f * r, 0}, {0.97f * r, 0.003f}, {r, 0.009f}, {r, shoulder}};
  for (int i = 1; i <= 8; ++i) {
    const float t = static_cast<float>(i) / 8;
    profile.push_back({neck + (r - neck) * 0.5f * (1 + std::cos(kPi * t)), shoulder + rise * t});
  }
  profile.push_back({neck, 0.95f * h});
  for (const vec2 p : {vec2(neck * 1.25f, 0.955f * h), vec2(neck * 1.25f, 0.985f * h), vec2(neck, h), vec2(0, h)}) {
    profile.push_back(p);
  }
  Mesh bottle, label;
  add_lathe(bottle, pose, profile);
  const vec3 color = paint_color(rng);
  build.add("bottle", bottle, plain_surface(rng.substream(1), color * 0.6f, rng.uniform(0.08f, 0.35f), 0.03f));
  const float from = 0.12f * h, to = 0.9f * shoulder;
  add_lathe(label, glm::rotate(pose, rng.uniform(0, 2 * kPi), vec3(0, 1, 0)), {{r + 0.0004f, from}, {r + 0.0004f, to}});
  Surface print = cover_surface(rng.substream(2), paint_color(rng), random_text(rng, 1, 9).front());
  for (vec2& uv : label.uvs) uv = {-2 * uv.x / (2 * kPi * r), 1 + uv.y / (to - from)};
  print.repeat_m = 1;
  build.add("label", label, print);
}

void add_candle(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.009f, 0.035f), h = rng.uniform(0.05f, 0.18f);
  Mesh wax, wick;
  add_lathe(wax, pose, {{0, 0}, {r, 0}, {r, h - 0.003f}, {0.93f * r, h}, {0.7f * r, h - 0.003f}, {0, h - 0.004f}});
  add_pipe(wick, {{0, h - 0.005f, 0}, {0.0008f, h + 0.004f, 0}, {0.002f, h + 0.01f, 0}}, 0.0008f, 6);
  build.add("candle", wax,
            plain_surface(rng.substream(1),
                          glm::mix(vec3(0.75f, 0.7f, 0.58f), paint_color(rng), rng.chance(0.4f) ? 0.8f : 0.0f), 0.55f,
                          0.02f));
  build.add("wick", placed_mesh(wick, pose), plain_surface(rng.substream(2), vec3(0.03f), 1));
  if (rng.chance(0.5f)) {
    Mesh flame;
    add_ball(flame, {0.001f, h + 0.018f, 0}, vec3(0.0042f, 0.013f, 0.0042f), 8,
             [](vec3 n) { return n.y < 0 ? 1.0f : 1 - 0.25f * n.y; });
    build.add("flame", placed_mesh(flame, pose), glowing_surface(vec3(9000, 5200, 1700)));
  }
}

void add_turned_piece(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float h = rng.uniform(0.07f, 0.2f), r = h * rng.uniform(0.15f, 0.24f);
  std::vector<vec2> profile = {{0, 0}, {r, 0}, {r, 0.03f * h}, {0.85f * r, 0.06f * h}};
  float y = 0.08f * h;
  while (y < 0.8f * h) {  // beads, coves and collars
    const float piece = h * rng.uniform(0.06f, 0.28f), wide = r * rng.uniform(0.3f, 0.8f);
    const bool bead = rng.chance(0.5f);
    for (int i = 0; i <= 6; ++i) {
      const float s = std::sin(kPi * static_cast<float>(i) / 6);
      profile.push_back({wide * (bead ? 0.7f + 0.3f * s : 1 - 0.4f * s), y + piece * static_cast<float>(i) / 6});
    }
    y += piece * 1.05f;
  }
  const float knob = r * rng.uniform(0.4f, 0.7f);
  for (int i = 0; i <= 8; ++i) {
    const float phi = kPi * (static_cast<float>(i) / 8 - 0.42f) / 0.92f * 0.8f;
    profile.push_back({std::max(knob * std::cos(phi), 0.0f), y + knob * (0.8f + std::sin(phi))});
  }
  profile.push_back({0, y + 1.82f * knob});
  Mesh piece;
  add_lathe(piece, pose, profile);
  const vec3 metal(0.75f, 0.58f, 0.3f);
  build.add("turned piece", piece,
            rng.chance(0.3f) ? metal_surface(rng.substream(1), metal, rng.uniform(0.1f, 0.3f))
                             : wood_surface(rng.substream(1), wood_color(rng), 0, 0.15f));
}

void add_tin(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.03f, 0.045f), h = rng.uniform(0.05f, 0.13f);
  Mesh tin, label;
  std::vector<vec2> profile = {{0, 0.002f}, {0.95f * r, 0.002f}, {0.97f * r, 0}, {r, 0}, {r, 0.002f}};
  for (int i = 0; i <= 24; ++i) {
    const float t = static_cast<float>(i) / 24;
    profile.push_back({0.985f * r + (i % 2 != 0 ? 0.0006f : 0.0f), 0.003f + (h - 0.006f) * t});
  }
  for (const vec2 p :
       {vec2(r, h - 0.002f), vec2(r, h), vec2(0.97f * r, h), vec2(0.95f * r, h - 0.003f), vec2(0, h - 0.003f)})
    profile.push_back(p);
  add_lathe(tin, pose, profile, 64);
  build.add("tin", tin, metal_surface(rng.substream(1), vec3(0.62f, 0.61f, 0.6f), rng.uniform(0.2f, 0.4f)));
  const float from = 0.08f * h, to = 0.92f * h;
  add_lathe(label, glm::rotate(pose, rng.uniform(0, 6), vec3(0, 1, 0)), {{r, from}, {r, to}}, 64);
  for (vec2& uv : label.uvs) uv = {-2 * uv.x / (2 * kPi * r), 1 + uv.y / (to - from)};
  Surface print = cover_surface(rng.substream(2), paint_color(rng), random_text(rng, 1, 8).front());
  print.repeat_m = 1;
  build.add("label", label, print);
}

}  // namespace dualpixel::scenes
