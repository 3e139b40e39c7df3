#include "scenes/places/furniture.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/procedural/noise.h"
#include "scenes/shapes/plants.h"
#include "scenes/textures/lettering.h"
#include "scenes/things/things.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

Surface board_surface(RandomStream& rng) {
  if (rng.chance(0.35f))
    return plain_surface(rng.substream(80), glm::mix(vec3(0.6f), paint_color(rng), 0.4f), rng.uniform(0.3f, 0.8f));
  return wood_surface(rng.substream(80), wood_color(rng), 0, 0.9f);
}

Surface upholstery(RandomStream& rng) {
  return woven_surface(rng.substream(81), paint_color(rng), paint_color(rng), rng.uniform(0.0015f, 0.003f));
}

/// A box with bulging sides.
void add_cushion(Mesh& mesh, vec3 center, vec3 half, float bulge) {
  add_ball(mesh, center, half, 20, [&](vec3 n) {
    const vec3 a = glm::abs(n);
    const float box = 1 / std::pow(std::pow(a.x, 7.0f) + std::pow(a.y, 7.0f) + std::pow(a.z, 7.0f), 1.0f / 7);
    return 1 + (1 - bulge) * (box - 1);
  });
}

}  // namespace

void add_dining_table(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float w = rng.uniform(0.55f, 0.95f), d = rng.uniform(0.38f, 0.5f), h = rng.uniform(0.7f, 0.77f);
  Mesh mesh;
  add_solid_box(mesh, {0, h - 0.018f, 0}, {w, 0.018f, d}, 0.005f);
  add_solid_box(mesh, {0, h - 0.08f, 0}, {w - 0.07f, 0.045f, d - 0.07f}, 0.003f);
  for (const float x : {-1.0f, 1.0f}) {
    for (const float z : {-1.0f, 1.0f})
      add_solid_box(mesh, {x * (w - 0.07f), 0.5f * (h - 0.04f), z * (d - 0.07f)}, {0.03f, 0.5f * (h - 0.04f), 0.03f},
                    0.005f);
  }
  build.add("table", placed_mesh(mesh, pose), board_surface(rng));
  const int things = 2 + rng.below(6);
  for (int i = 0; i < things; ++i) {
    RandomStream own = rng.substream(10 + i);
    const float x = (static_cast<float>(i) + 0.5f) / static_cast<float>(things) * 2 - 1;
    const glm::mat4 at =
        pose * standing({x * (w - 0.15f), h + 0.0006f, 0.6f * d * own.uniform(-1, 1)}, own.uniform(0, 6));
    draw_thing(own, 0.16f, 0.5f).add(build, own.substream(1), at);
  }
}

void add_chair(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  Mesh mesh;
  const float h = 0.45f, w = 0.21f, back = rng.uniform(0.38f, 0.5f);
  add_solid_box(mesh, {0, h, 0}, {w, 0.014f, w}, 0.008f);
  for (const float x : {-1.0f, 1.0f}) {
    add_pipe(mesh, {{x * w * 0.9f, 0, w * 0.95f}, {x * w * 0.85f, h, w * 0.85f}}, {0.015f, 0.018f}, 10);
    add_pipe(mesh, {{x * w * 0.9f, 0, -w * 1.1f}, {x * w * 0.85f, h, -w * 0.9f}, {x * w * 0.85f, h + back, -w * 1.25f}},
             {0.015f, 0.018f, 0.014f}, 10);
  }
  const int bars = 2 + rng.below(3);
  const bool upright = rng.chance(0.5f);
  for (int i = 0; i < bars; ++i) {
    const float t = (static_cast<float>(i) + 1) / static_cast<float>(bars);
    if (upright) {
      const float x = (2 * (static_cast<float>(i) + 0.5f) / static_cast<float>(bars) - 1) * w * 0.75f;
      add_pipe(mesh, {{x, h, -w * 0.9f}, {x, h + 0.95f * back, -w * 1.24f}}, 0.009f, 8);
    }
    if (!upright || i + 1 == bars)
      add_solid_box(mesh, {0, h + t * back * 0.96f, -w * (0.9f + 0.34f * t)}, {w * 0.84f, 0.03f, 0.009f}, 0.004f);
  }
  build.add("chair", placed_mesh(mesh, pose), board_surface(rng));
}

void add_sofa(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float w = rng.uniform(0.75f, 1.1f);
  const int seats = w > 0.95f ? 3 : 2;
  Mesh body;
  add_cushion(body, {0, 0.22f, 0}, {w, 0.16f, 0.4f}, 0.1f);
  add_cushion(body, {0, 0.5f, -0.34f}, {w, 0.34f, 0.12f}, 0.15f);
  for (const float x : {-1.0f, 1.0f}) add_cushion(body, {x * (w + 0.02f), 0.36f, 0}, {0.11f, 0.26f, 0.42f}, 0.15f);
  for (int i = 0; i < seats; ++i) {
    const float x = (2 * (static_cast<float>(i) + 0.5f) / static_cast<float>(seats) - 1) * (w - 0.1f);
    add_cushion(body, {x, 0.42f, 0.06f}, {(w - 0.1f) / static_cast<float>(seats), 0.09f, 0.34f}, 0.22f);
    add_cushion(body, {x, 0.66f, -0.2f}, {(w - 0.1f) / static_cast<float>(seats), 0.2f, 0.1f}, 0.3f);
  }
  build.add("sofa", placed_mesh(body, pose), upholstery(rng));
  const int cushions = rng.below(4);
  for (int i = 0; i < cushions; ++i) {
    RandomStream own = rng.substream(20 + i);
    Mesh cushion;
    add_cushion(cushion, vec3(0), {0.2f, 0.2f, 0.07f}, 0.55f);
    const glm::mat4 at =
        pose * glm::rotate(glm::rotate(standing({own.uniform(-0.8f, 0.8f) * w, 0.66f, -0.02f}, 0.3f * own.normal()),
                                       -0.35f, vec3(1, 0, 0)),
                           0.25f * own.normal(), vec3(0, 0, 1));
    build.add("cushion", placed_mesh(cushion, at), upholstery(own));
  }
}

void add_bookcase(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float w = rng.uniform(0.4f, 0.6f), h = rng.uniform(1.2f, 2.1f), d = 0.15f;
  const int shelves = static_cast<int>(h / 0.34f);
  const float step = h / static_cast<float>(shelves);
  Mesh mesh;
  for (const float x : {-1.0f, 1.0f}) add_solid_box(mesh, {x * w, 0.5f * h, 0}, {0.012f, 0.5f * h, d}, 0.002f);
  add_solid_box(mesh, {0, 0.5f * h, -d + 0.004f}, {w, 0.5f * h, 0.004f});
  for (int i = 0; i <= shelves; ++i)
    add_solid_box(mesh, {0, std::min(step * static_cast<float>(i) + 0.012f, h), 0}, {w - 0.012f, 0.01f, d - 0.002f},
                  0.002f);
  build.add("bookcase", placed_mesh(mesh, pose), board_surface(rng));
  for (int i = 0; i < shelves; ++i) {
    RandomStream own = rng.substream(30 + i);
    const float y = step * static_cast<float>(i) + 0.0225f;
    if (own.chance(0.7f)) {
      add_book_row(build, own.substream(1), pose * glm::translate(glm::mat4(1), vec3(-w + 0.04f, y, d - 0.03f)),
                   2 * w * own.uniform(0.5f, 0.97f) - 0.06f, 0.9f * step);
      continue;
    }
    for (const float x : {-0.5f, 0.0f, 0.5f}) {
      if (own.chance(0.7f))
        draw_thing(own, 0.13f, 0.85f * step)
            .add(build, own.substream(static_cast<std::uint64_t>(8 + 4 * x)),
                 pose * standing({x * w, y, 0}, own.uniform(0, 6)));
    }
  }
}

void add_cupboard(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float w = rng.uniform(0.4f, 0.8f), h = rng.uniform(0.6f, 1.1f), d = 0.22f;
  const int doors = 2 + rng.below(2);
  Mesh body, knobs;
  add_solid_box(body, {0, 0.5f * h + 0.04f, 0}, {w, 0.5f * h - 0.04f, d}, 0.004f);
  for (int i = 0; i < doors; ++i) {
    const float half = w / static_cast<float>(doors), x = -w + half * static_cast<float>(2 * i + 1);
    add_solid_box(body, {x, 0.5f * h + 0.04f, d + 0.008f}, {half - 0.004f, 0.5f * h - 0.06f, 0.008f}, 0.003f);
    add_ball(knobs, {x + 0.7f * half, 0.6f * h, d + 0.03f}, vec3(0.013f), 8);
  }
  for (const float x : {-0.9f, 0.9f}) {
    for (const float z : {-0.85f, 0.85f}) add_pipe(body, {{x * w, 0, z * d}, {x * w, 0.09f, z * d}}, 0.018f, 8);
  }
  build.add("cupboard", placed_mesh(body, pose), board_surface(rng));
  build.add("knobs", placed_mesh(knobs, pose), metal_surface(rng.substream(2), vec3(0.6f, 0.5f, 0.35f), 0.3f));
  for (int i = 0; i < 3; ++i) {
    RandomStream own = rng.substream(40 + i);
    if (own.chance(0.7f))
      draw_thing(own, 0.16f, 0.5f)
          .add(build, own.substream(1),
               pose * standing({(static_cast<float>(i) - 1) * 0.62f * w, h + 0.0006f, 0}, own.uniform(0, 6)));
  }
}

void add_floor_lamp(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float nits) {
  const float h = rng.uniform(1.3f, 1.6f), low = rng.uniform(0.16f, 0.22f), high = rng.uniform(0.1f, 0.16f);
  Mesh stand, shade, bulb;
  add_lathe(stand, pose, {{0, 0}, {0.15f, 0}, {0.15f, 0.015f}, {0.02f, 0.03f}, {0.012f, 0.06f}, {0.012f, h}}, 24);
  add_lathe(shade, pose, {{low, h - 0.05f}, {high, h + 0.22f}}, 40);
  add_ball(bulb, vec3(pose * glm::vec4(0, h + 0.07f, 0, 1)), vec3(0.05f), 5);
  build.add("lamp stand", stand, metal_surface(rng.substream(1), vec3(0.5f, 0.45f, 0.38f), 0.4f));
  build.add("shade", shade,
            nits > 0 ? Surface{.color = vec3(0.7f, 0.62f, 0.5f),
                               .emission_nits = vec3(0.045f * nits) * vec3(1.2f, 0.95f, 0.6f)}
                     : woven_surface(rng.substream(2), vec3(0.6f, 0.55f, 0.45f), vec3(0.5f), 0.0015f));
  if (nits > 0) build.add("bulb", bulb, glowing_surface(nits * vec3(1.3f, 0.95f, 0.55f)));
}

void add_pendant(SceneBuilder& build, RandomStream rng, vec3 at, float ceiling_y, float nits) {
  const float r = rng.uniform(0.15f, 0.24f);
  Mesh shade, bulb;
  add_lathe(shade, glm::translate(glm::mat4(1), at),
            {{r, 0}, {0.92f * r, 0.4f * r}, {0.5f * r, 0.75f * r}, {0.1f * r, 0.85f * r}}, 40);
  add_pipe(shade, {at + vec3(0, 0.8f * r, 0), {at.x, ceiling_y, at.z}}, 0.004f, 6);
  add_ball(bulb, at + vec3(0, 0.25f * r, 0), vec3(0.05f), 5);
  build.add("pendant", shade, plain_surface(rng.substream(1), paint_color(rng), 0.5f));
  build.add(
      "bulb", bulb,
      nits > 0 ? glowing_surface(nits * vec3(1.3f, 0.95f, 0.55f)) : plain_surface(rng.substream(2), vec3(0.7f), 0.2f));
}

void add_floor_plant(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.12f, 0.18f);
  Mesh pot, leaves;
  add_lathe(pot, pose,
            {{0, 0}, {0.75f * r, 0}, {r, 1.7f * r}, {0.92f * r, 1.7f * r}, {0.88f * r, 1.4f * r}, {0, 1.4f * r}});
  add_pot_plant(leaves, rng.substream(1), rng.uniform(0.5f, 1.1f));
  build.add("pot", pot, plain_surface(rng.substream(2), paint_color(rng), 0.6f));
  const vec3 green = vec3(0.03f, 0.075f, 0.02f) * rng.uniform(0.7f, 1.6f);
  build.add("plant", placed_mesh(leaves, pose * glm::translate(glm::mat4(1), vec3(0, 1.4f * r, 0))),
            leaf_surface(rng.substream(3), green, green * vec3(2, 1.7f, 1.2f)));
}

void add_curtain(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float wide, float high) {
  const float folds = wide / rng.uniform(0.09f, 0.15f), deep = rng.uniform(0.025f, 0.05f);
  const std::uint32_t seed = rng.seed();
  Mesh cloth;
  add_sheet(cloth, 160, 30, {1.5f * wide, high}, [&](float u, float v) {
    const float wander = 0.6f * noise(seed, vec3(u * folds * 0.5f, v * 2, 0)),
                phase = 6.2831853f * (u * folds + wander);
    const float open = 0.5f + 0.5f * std::min(3 * v, 1.0f);
    return vec3(u * wide + 0.02f * std::sin(2 * phase) * open, -v * high,
                deep * open * std::sin(phase) + 0.02f * noise(seed + 1, vec3(u * 3, v * 2, 1)));
  });
  build.add("curtain", placed_mesh(cloth, pose), upholstery(rng));
}

void add_blinds(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float wide, float high) {
  const float step = rng.uniform(0.025f, 0.05f), tilt = rng.uniform(0.2f, 1.1f);
  const glm::mat3 axes(glm::rotate(glm::mat4(1), tilt, vec3(1, 0, 0)));
  Mesh slats;
  for (float y = 0; y < high; y += step)
    add_solid_box(slats, {0.5f * wide, -y, 0}, {0.5f * wide, 0.0006f, 0.46f * step}, 0, axes);
  for (const float x : {0.15f, 0.85f}) add_pipe(slats, {{x * wide, 0, 0.01f}, {x * wide, -high, 0.01f}}, 0.001f, 5);
  build.add("blinds", placed_mesh(slats, pose),
            plain_surface(rng.substream(1), glm::mix(vec3(0.65f), paint_color(rng), 0.3f), 0.5f));
}

void add_wall_picture(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const vec2 half(rng.uniform(0.12f, 0.42f), rng.uniform(0.12f, 0.38f));
  Mesh frame, picture;
  for (const float s : {-1.0f, 1.0f}) {
    add_solid_box(frame, {s * (half.x + 0.015f), 0, 0.015f}, {0.018f, half.y + 0.033f, 0.015f}, 0.004f);
    add_solid_box(frame, {0, s * (half.y + 0.015f), 0.015f}, {half.x, 0.018f, 0.015f}, 0.004f);
  }
  picture.add_quad({-half.x, -half.y, 0.008f}, {2 * half.x, 0, 0}, {0, 2 * half.y, 0});
  const vec3 a = paint_color(rng), b = paint_color(rng);
  const PinkNoise shapes(rng.seed(), 2, 256, 1.6f), strokes(rng.seed(), 4, 256, 1.1f, 1, 2);
  const float margin = rng.chance(0.4f) ? 0.14f : 0.0f;
  Surface print = rng.chance(0.3f) ? page_surface(rng.substream(2), 1) : Surface{};
  if (print.texture.size == 0) {
    print.texture = paint(512, [&](float u, float v) {
      if (std::min(std::min(u, 1 - u), std::min(v, 1 - v)) < margin) return vec3(0.7f);
      const float t = std::clamp(0.5f + 0.7f * shapes(u, v) + 0.6f * (v - 0.5f), 0.0f, 1.0f);
      return shaded(glm::mix(a, b, t), 0.15f, strokes(u, v));
    });
  }
  print.repeat_m = 1;
  print.roughness = 0.5f;
  build.add("frame", placed_mesh(frame, pose), wood_surface(rng.substream(1), wood_color(rng), 0));
  build.add("picture", placed_mesh(picture, pose), print);
}

void add_mirror(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, vec2 half) {
  Mesh frame, glass;
  for (const float s : {-1.0f, 1.0f}) {
    add_solid_box(frame, {s * (half.x + 0.015f), 0, 0.015f}, {0.022f, half.y + 0.037f, 0.02f}, 0.005f);
    add_solid_box(frame, {0, s * (half.y + 0.015f), 0.015f}, {half.x, 0.022f, 0.02f}, 0.005f);
  }
  glass.add_quad({-half.x, -half.y, 0.01f}, {2 * half.x, 0, 0}, {0, 2 * half.y, 0});
  build.add("frame", placed_mesh(frame, pose), wood_surface(rng.substream(1), wood_color(rng), 0));
  build.add("mirror", placed_mesh(glass, pose), Surface{.color = vec3(0.9f), .roughness = 0, .metallic = 1});
}

void add_glass_screen(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, glm::vec2 half) {
  Mesh foot, pane, ball;
  add_solid_box(foot, {0, 0.03f, 0}, {half.x + 0.05f, 0.03f, 0.12f}, 0.01f);
  pane.add_quad({-half.x, 0.06f, 0}, {2 * half.x, 0, 0}, {0, 2 * half.y, 0});
  const float radius = rng.uniform(0.1f, 0.16f);
  add_ball(ball, {half.x + 0.25f, radius, 0.1f}, vec3(radius), 48);
  build.add("screen foot", placed_mesh(foot, pose), wood_surface(rng.substream(1), wood_color(rng), 0));
  build.add("screen", placed_mesh(pane, pose),
            Surface{.color = {0.88f, 0.94f, 0.9f}, .roughness = 0, .transmission = 1});
  build.add("glass ball", placed_mesh(ball, pose), Surface{.roughness = 0, .transmission = 1, .solid = true});
}

}  // namespace dualpixel::scenes
