#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "scenes/places/places.h"
#include "scenes/textures/lettering.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

Surface painted_iron(RandomStream rng) {
  const vec3 colors[] = {vec3(0.03f), vec3(0.02f, 0.05f, 0.03f), vec3(0.2f), vec3(0.05f, 0.07f, 0.12f)};
  return plain_surface(rng.substream(91), colors[rng.below(4)], 0.45f, 0.08f);
}

/// Parts of a house before its wall: recesses are not cut; panes lie a little before the wall in protruding frames.
struct House {
  Mesh wall, frames, panes, lit, stone;
};

void add_window(House& house, RandomStream& rng, vec3 at, vec2 half, bool lit, int bars) {
  Mesh& pane = lit ? house.lit : house.panes;
  pane.add_quad(at + vec3(-half.x, -half.y, 0.02f), {2 * half.x, 0, 0}, {0, 2 * half.y, 0});
  constexpr float kFrame = 0.04f;
  for (const float s : {-1.0f, 1.0f}) {
    add_solid_box(house.frames, at + vec3(s * half.x, 0, 0.04f), {kFrame, half.y + kFrame, 0.05f}, 0.006f);
    add_solid_box(house.frames, at + vec3(0, s * half.y, 0.04f), {half.x + kFrame, kFrame, 0.05f}, 0.006f);
  }
  for (int i = 1; i < bars; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(bars);
    add_solid_box(house.frames, at + vec3((2 * t - 1) * half.x, 0, 0.035f), {0.018f, half.y, 0.02f});
  }
  if (bars > 2 || rng.chance(0.5f))
    add_solid_box(house.frames, at + vec3(0, 0.15f * half.y, 0.035f), {half.x, 0.018f, 0.02f});
  add_solid_box(house.stone, at + vec3(0, -half.y - 0.08f, 0.08f), {half.x + 0.12f, 0.035f, 0.1f}, 0.008f);
}

}  // namespace

int build_house(SceneBuilder& build, RandomStream rng, float wide, float high, bool lit) {
  House house;
  house.wall.add_quad({-0.5f * wide, 0, 0}, {wide, 0, 0}, {0, high, 0}, {wide, high});
  house.wall.add_quad({0.5f * wide, 0, 0}, {0, 0, -6}, {0, high, 0}, {6, high});
  house.wall.add_quad({-0.5f * wide, 0, -6}, {0, 0, 6}, {0, high, 0}, {6, high});
  const int floors = std::max(static_cast<int>(high / 3.1f), 1),
            columns = std::max(static_cast<int>(wide / rng.uniform(1.7f, 2.6f)), 1);
  const vec2 half(rng.uniform(0.4f, 0.6f), rng.uniform(0.6f, 0.85f));
  const int bars = 1 + rng.below(3), door = rng.below(columns);
  const float share_lit = lit ? rng.uniform(0.15f, 0.5f) : 0;
  for (int f = 0; f < floors; ++f) {
    for (int c = 0; c < columns; ++c) {
      const vec3 at((static_cast<float>(c) + 0.5f) / static_cast<float>(columns) * wide - 0.5f * wide,
                    3.1f * static_cast<float>(f) + 1.75f, 0);
      if (f == 0 && c == door) {
        add_solid_box(house.frames, {at.x, 1.1f, 0.02f}, {0.5f, 1.1f, 0.04f}, 0.01f);
        add_solid_box(house.stone, {at.x, 0.08f, 0.3f}, {0.7f, 0.08f, 0.3f}, 0.01f);
        continue;
      }
      add_window(house, rng, at, half, rng.chance(share_lit), bars);
    }
    add_solid_box(house.stone, {0, 3.1f * static_cast<float>(f + 1) - 0.15f, 0.04f}, {0.5f * wide, 0.06f, 0.06f},
                  0.01f);
  }
  add_solid_box(house.stone, {0, high, -2.8f}, {0.5f * wide + 0.15f, 0.12f, 3.1f}, 0.02f);
  const vec3 plaster = glm::mix(vec3(0.5f, 0.46f, 0.4f), glm::max(paint_color(rng), vec3(0.1f)), 0.45f);
  const int wall =
      build.add(rng.chance(0.45f) ? brick_surface(rng.substream(1), vec3(0.36f, 0.15f, 0.09f) * rng.uniform(0.6f, 1.4f))
                                  : rough_surface(rng.substream(1), plaster, 0.1f, 3, 1.3f));
  const int frames = build.add(plain_surface(rng.substream(2), rng.chance(0.6f) ? vec3(0.6f) : paint_color(rng), 0.6f));
  const int stone =
      build.add(rough_surface(rng.substream(3), vec3(0.38f, 0.36f, 0.32f) * rng.uniform(0.7f, 1.2f), 0.14f, 1));
  const int panes = build.add(plain_surface(rng.substream(4), vec3(0.025f, 0.03f, 0.035f), 0.06f, 0.02f));
  const int glow = build.add(glowing_surface(vec3(60, 42, 22) * rng.uniform(0.5f, 2)));
  return build.add_shared(
      {{house.wall, wall}, {house.frames, frames}, {house.stone, stone}, {house.panes, panes}, {house.lit, glow}});
}

void add_lamp_post(SceneBuilder& build, RandomStream rng, vec3 foot, float nits) {
  const float high = rng.uniform(3.2f, 5),
              out = rng.chance(0.5f) ? rng.uniform(0.4f, 1.0f) * -std::copysign(1.0f, foot.x) : 0;
  Mesh post, head;
  add_lathe(post, glm::translate(glm::mat4(1), foot),
            {{0, 0}, {0.11f, 0}, {0.11f, 0.25f}, {0.07f, 0.4f}, {0.055f, 0.5f}, {0.035f, high}, {0, high}}, 20);
  const vec3 top = foot + vec3(0, high, 0), lamp = top + vec3(out, out == 0 ? 0.14f : 0.12f, 0);
  if (out != 0)
    add_pipe(post, {top, top + vec3(0.15f * out, 0.16f, 0), top + vec3(0.6f * out, 0.22f, 0), lamp + vec3(0, 0.08f, 0)},
             0.025f, 8);
  add_lathe(post, glm::translate(glm::mat4(1), lamp), {{0.17f, 0.1f}, {0.1f, 0.17f}, {0, 0.2f}}, 20);
  add_ball(head, lamp, vec3(0.11f, 0.1f, 0.11f), 5);
  build.add("lamp post", post, painted_iron(rng));
  const bool on = nits > 0;
  const vec3 warm = rng.chance(0.6f) ? vec3(1.3f, 0.95f, 0.5f) : vec3(0.95f, 1, 1.05f);
  build.add("lamp", head, on ? glowing_surface(nits * warm) : plain_surface(rng.substream(2), vec3(0.7f), 0.2f));
}

void add_bench(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  Mesh slats, legs;
  const float half = rng.uniform(0.7f, 0.95f);
  for (int i = 0; i < 4; ++i)
    add_solid_box(slats, {0, 0.44f, 0.12f * static_cast<float>(i) - 0.15f}, {half, 0.016f, 0.048f}, 0.006f);
  for (int i = 0; i < 3; ++i)
    add_solid_box(slats, {0, 0.56f + 0.12f * static_cast<float>(i), -0.22f - 0.03f * static_cast<float>(i)},
                  {half, 0.045f, 0.015f}, 0.006f);
  for (const float x : {-0.8f * half, 0.8f * half}) {
    add_pipe(legs, {{x, 0, 0.22f}, {x, 0.42f, 0.2f}, {x, 0.42f, -0.2f}, {x, 0.84f, -0.31f}}, 0.022f, 8);
    add_pipe(legs, {{x, 0, -0.28f}, {x, 0.42f, -0.2f}}, 0.022f, 8);
    add_pipe(legs, {{x, 0.42f, 0.2f}, {x, 0.64f, 0.2f}, {x, 0.66f, -0.24f}}, 0.018f, 8);
  }
  build.add("bench", placed_mesh(slats, pose), wood_surface(rng.substream(1), wood_color(rng), 0));
  build.add("bench legs", placed_mesh(legs, pose), painted_iron(rng));
}

void add_fence(SceneBuilder& build, RandomStream rng, vec3 from, vec3 to) {
  const float length = glm::distance(from, to), high = rng.uniform(0.8f, 1.7f), board = rng.uniform(0.07f, 0.13f),
              gap = rng.uniform(0.2f, 0.9f) * board;
  const vec3 along = (to - from) / length, out = glm::cross(along, vec3(0, 1, 0));
  const glm::mat3 axes(along, vec3(0, 1, 0), out);
  Mesh boards;
  const int count = static_cast<int>(length / (board + gap));
  for (int i = 0; i < count; ++i) {
    const float own = 0.012f * rng.normal();
    add_solid_box(boards, from + along * ((board + gap) * static_cast<float>(i)) + vec3(0, 0.5f * high + own, 0),
                  {0.5f * board, 0.5f * high, 0.009f}, 0.003f, axes);
  }
  for (const float y : {0.2f, 0.8f})
    add_solid_box(boards, 0.5f * (from + to) + vec3(0, y * high, 0) - 0.03f * out, {0.5f * length, 0.035f, 0.02f},
                  0.004f, axes);
  build.add("fence", boards,
            rng.chance(0.6f) ? wood_surface(rng.substream(1), wood_color(rng), 0)
                             : plain_surface(rng.substream(1), paint_color(rng), 0.8f, 0.12f));
}

void add_railing(SceneBuilder& build, RandomStream rng, vec3 from, vec3 to) {
  const float length = glm::distance(from, to), high = rng.uniform(0.9f, 1.1f);
  const vec3 along = (to - from) / length;
  Mesh bars;
  const float spacing = rng.uniform(0.1f, 0.16f);
  for (float x = 0; x < length; x += spacing)
    add_pipe(bars, {from + along * x, from + along * x + vec3(0, high, 0)}, 0.007f, 6);
  for (const float y : {0.1f, 1.0f})
    add_pipe(bars, {from + vec3(0, y * high, 0), to + vec3(0, y * high, 0)}, y > 0.5f ? 0.02f : 0.012f, 8);
  build.add("railing", bars, painted_iron(rng));
}

void add_bollards(SceneBuilder& build, RandomStream rng, vec3 from, vec3 to, float spacing_m) {
  Mesh posts;
  const float length = glm::distance(from, to), r = rng.uniform(0.05f, 0.09f), h = rng.uniform(0.7f, 1);
  for (float x = 0; x <= length; x += spacing_m) {
    add_lathe(posts, glm::translate(glm::mat4(1), from + (to - from) * (x / length)),
              {{0, 0},
               {r, 0},
               {r, 0.75f * h},
               {1.15f * r, 0.77f * h},
               {1.15f * r, 0.82f * h},
               {r, 0.84f * h},
               {0.9f * r, 0.95f * h},
               {0.5f * r, h},
               {0, h}},
              20);
  }
  build.add("bollards", posts, painted_iron(rng));
}

void add_sign(SceneBuilder& build, RandomStream rng, vec3 foot) {
  const float high = rng.uniform(2, 2.6f), half = rng.uniform(0.25f, 0.4f), turn = 0.4f * rng.normal();
  Mesh post, plate;
  add_pipe(post, {{0, 0, 0}, {0, high + half, 0}}, 0.03f, 10);
  plate.add_quad({-half, high - half, 0.035f}, {2 * half, 0, 0}, {0, 2 * half, 0});
  const glm::mat4 pose = standing(foot, turn);
  build.add("sign post", placed_mesh(post, pose), metal_surface(rng.substream(1), vec3(0.45f), 0.5f));
  Surface print = cover_surface(rng.substream(2), paint_color(rng), random_text(rng, 1, 7).front());
  print.repeat_m = 1;
  build.add("sign", placed_mesh(plate, pose), print);
}

}  // namespace dualpixel::scenes
