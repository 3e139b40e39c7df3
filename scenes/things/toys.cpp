#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/math.h"
#include "scenes/procedural/noise.h"
#include "scenes/textures/lettering.h"
#include "scenes/things/things.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

/// A ring lying flat: a circle of radius `thick` turned at `radius`.
std::vector<vec2> torus(float radius, float thick, float y) {
  std::vector<vec2> profile;
  for (int i = 0; i <= 16; ++i) {
    const float phi = 2 * kPi * static_cast<float>(i) / 16;
    profile.push_back({radius + thick * std::sin(phi), y - thick * std::cos(phi)});
  }
  return profile;
}

void add_letter_block(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float side) {
  const vec3 color = paint_color(rng);
  Mesh box;
  add_solid_box(box, {0, 0.5f * side, 0}, vec3(0.5f * side), 0.05f * side);
  for (vec2& uv : box.uvs) uv /= side;
  Surface print = letter_surface(rng.substream(1), color, static_cast<char>('A' + rng.below(26)));
  print.repeat_m = 1;
  build.add("letter block", placed_mesh(box, pose), print);
}

}  // namespace

void add_letter_blocks(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float side = rng.uniform(0.026f, 0.04f);
  const int wide = 1 + rng.below(3), levels = 1 + rng.below(3);
  int index = 0;
  for (int level = 0; level < levels; ++level) {
    for (int i = 0; i + level < wide || i == 0; ++i) {
      const vec3 at((static_cast<float>(i) - 0.5f * static_cast<float>(std::max(wide - level, 1) - 1)) * side * 1.12f,
                    static_cast<float>(level) * side, 0.1f * side * rng.normal());
      RandomStream own = rng.substream(10 + index++);
      add_letter_block(build, own, glm::rotate(glm::translate(pose, at), 0.25f * own.normal(), vec3(0, 1, 0)), side);
    }
  }
}

void add_toy_car(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float length = rng.uniform(0.07f, 0.15f), width = 0.42f * length, wheel = 0.1f * length;
  Mesh body, cabin, wheels, hubs;
  add_solid_box(body, {0, wheel + 0.1f * length, 0}, {0.5f * length, 0.1f * length, 0.5f * width}, 0.03f * length);
  const float back = rng.uniform(-0.12f, 0.05f) * length;
  add_solid_box(cabin, {back, wheel + 0.27f * length, 0}, {0.22f * length, 0.09f * length, 0.42f * width},
                0.04f * length);
  add_solid_box(body, {back, wheel + 0.355f * length, 0}, {0.21f * length, 0.012f * length, 0.41f * width},
                0.01f * length);
  for (const float x : {-0.3f, 0.3f}) {
    for (const float z : {-1.0f, 1.0f}) {
      const glm::mat4 axle = glm::rotate(glm::translate(glm::mat4(1), vec3(x * length, wheel, z * 0.5f * width)),
                                         0.5f * kPi, vec3(1, 0, 0));
      add_lathe(wheels, axle,
                {{0, -0.2f * wheel},
                 {0.9f * wheel, -0.25f * wheel},
                 {wheel, -0.15f * wheel},
                 {wheel, 0.15f * wheel},
                 {0.9f * wheel, 0.25f * wheel},
                 {0.5f * wheel, 0.2f * wheel}},
                32);
      add_lathe(
          hubs, axle,
          {{0, -0.27f * wheel}, {0.5f * wheel, -0.22f * wheel}, {0.5f * wheel, 0.22f * wheel}, {0, 0.27f * wheel}}, 24);
    }
  }
  build.add("toy car", placed_mesh(body, pose),
            plain_surface(rng.substream(1), paint_color(rng), rng.uniform(0.1f, 0.4f), 0.03f));
  build.add("windows", placed_mesh(cabin, pose),
            plain_surface(rng.substream(2), vec3(0.05f, 0.06f, 0.07f), 0.08f, 0.02f));
  build.add("wheels", placed_mesh(wheels, pose), plain_surface(rng.substream(3), vec3(0.03f), 0.8f));
  build.add("hubs", placed_mesh(hubs, pose), metal_surface(rng.substream(4), vec3(0.7f), 0.25f));
}

void add_ring_tower(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const int rings = 3 + rng.below(4);
  float radius = rng.uniform(0.032f, 0.045f), y = 0.012f;
  Mesh foot;
  add_lathe(foot, pose, {{0, 0}, {1.15f * radius, 0}, {1.15f * radius, 0.008f}, {1.05f * radius, 0.012f}, {0, 0.012f}});
  const float thick = rng.uniform(0.008f, 0.012f);
  for (int i = 0; i < rings; ++i) {
    Mesh one;
    add_lathe(one, pose, torus(radius - thick, thick, y + thick));
    build.add("ring", one, plain_surface(rng.substream(20 + i), paint_color(rng), rng.uniform(0.2f, 0.6f), 0.03f));
    radius *= 0.87f;
    y += 1.93f * thick;
  }
  add_lathe(foot, pose, {{0.006f, 0.012f}, {0.006f, y + 0.012f}, {0.0045f, y + 0.017f}, {0, y + 0.018f}}, 24);
  build.add("tower", foot, wood_surface(rng.substream(2), wood_color(rng), 0, 0.2f));
}

void add_toy_ball(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.02f, 0.05f);
  const vec3 a = paint_color(rng), b = paint_color(rng);
  const int stripes = 2 + rng.below(5);
  const bool along = rng.chance(0.5f);
  const PinkNoise wear(rng.seed(), 4, 256, 1.3f);
  Surface skin;
  skin.repeat_m = 1;
  skin.roughness = rng.uniform(0.15f, 0.7f);
  skin.texture = paint(512, [&](float u, float v) {
    const float s = along ? u : v;
    const bool second = std::fmod(s * static_cast<float>(2 * stripes), 2.0f) < 1;
    return shaded(second ? a : b, 0.05f, wear(u, v));
  });
  Mesh ball;
  add_ball(ball, {0, r, 0}, vec3(r), 32);
  for (vec2& uv : ball.uvs) uv = {uv.x / (2 * kPi * r), uv.y / (kPi * r)};
  const glm::mat4 rolled = glm::translate(glm::rotate(glm::translate(pose, vec3(0, r, 0)), rng.uniform(0, 3),
                                                      glm::normalize(rng.uniform3(-1, 1) + vec3(0.01f))),
                                          vec3(0, -r, 0));
  build.add("ball", placed_mesh(ball, rolled), skin);
}

void add_crumpled_cloth(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float w = rng.uniform(0.14f, 0.24f), height = rng.uniform(0.02f, 0.055f);
  const std::uint32_t seed = rng.seed();
  Mesh cloth;
  add_sheet(cloth, 90, 90, {w * 1.3f, w * 1.3f}, [&](float u, float v) {
    const vec3 p(u * 3.2f, v * 3.2f, 0);
    const vec3 shift = 0.45f * vec3(noise(seed + 5, p) - 0.5f, noise(seed + 6, p) - 0.5f, 0);
    const float ridge = 1 - std::abs(2 * noise(seed, p + 2.0f * shift) - 1),
                fine = 1 - std::abs(2 * noise(seed + 1, 2.3f * p + shift) - 1);
    const float rim = std::min(std::min(u, 1 - u), std::min(v, 1 - v));
    const float up = height * std::min(1.0f, 0.25f + 4 * rim) * (0.65f * ridge * ridge + 0.3f * fine * fine);
    return vec3((u - 0.5f + 0.12f * shift.x) * w, 0.001f + up, (v - 0.5f + 0.12f * shift.y) * w);
  });
  build.add("cloth", placed_mesh(cloth, pose),
            woven_surface(rng.substream(1), paint_color(rng), paint_color(rng), rng.uniform(0.0008f, 0.0016f)));
}

}  // namespace dualpixel::scenes
