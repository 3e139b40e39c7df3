#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/procedural/noise.h"
#include "scenes/textures/lettering.h"
#include "scenes/things/things.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

Surface paper_edges(RandomStream rng) {
  const PinkNoise leafs(rng.seed(), 4, 64, 1.0f, 1, 4);
  Surface surface;
  surface.repeat_m = 0.05f;
  surface.texture = paint(256, [&](float u, float v) { return shaded(vec3(0.6f, 0.56f, 0.47f), 0.1f, leafs(u, v)); });
  return surface;
}

/// A rectangle of print: its UVs fill the picture once.
void add_print(SceneBuilder& build, const char* name, const glm::mat4& pose, vec3 corner, vec3 a, vec3 b,
               Surface surface) {
  Mesh quad;
  quad.add_quad(corner, a, b);
  surface.repeat_m = 1;
  build.add(name, placed_mesh(std::move(quad), pose), surface);
}

/// A closed book lying with its cover up: x along the spine's direction away, size in meters.
void add_one_book(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, vec3 size) {
  const vec3 color = paint_color(rng), half = 0.5f * size;
  Mesh pages, boards;
  add_solid_box(pages, {0.002f, half.y, 0}, {half.x - 0.004f, half.y - 0.002f, half.z - 0.003f});
  add_solid_box(boards, {0, 0.001f, 0}, {half.x, 0.001f, half.z});
  add_solid_box(boards, {0, size.y - 0.001f, 0}, {half.x, 0.001f, half.z});
  add_solid_box(boards, {-half.x + 0.001f, half.y, 0}, {0.001f, half.y, half.z});
  build.add("pages", placed_mesh(pages, pose), paper_edges(rng.substream(1)));
  build.add("binding", placed_mesh(boards, pose), plain_surface(rng.substream(2), color, 0.7f));
  const std::string title = random_text(rng, 1, 8 + rng.below(8)).front();
  add_print(build, "cover", pose, {-half.x, size.y + 0.0002f, half.z}, {size.x, 0, 0}, {0, 0, -size.z},
            cover_surface(rng.substream(3), color, title));
  add_print(build, "spine", pose, {-half.x - 0.0002f, 0, -half.z}, {0, 0, size.z}, {0, size.y, 0},
            cover_surface(rng.substream(4), color, title));
}

}  // namespace

void add_book_stack(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const int books = 1 + rng.below(4);
  float y = 0;
  for (int i = 0; i < books; ++i) {
    const vec3 size(rng.uniform(0.1f, 0.17f), rng.uniform(0.012f, 0.04f), rng.uniform(0.15f, 0.23f));
    const glm::mat4 at = glm::rotate(glm::translate(pose, vec3(0, y, 0)), 0.25f * rng.normal(), vec3(0, 1, 0));
    add_one_book(build, rng.substream(10 + i), at, size);
    y += size.y + 0.0004f;
  }
}

void add_open_page(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float w = rng.uniform(0.14f, 0.21f), h = w * rng.uniform(1.2f, 1.45f), curl = rng.uniform(0, 0.03f);
  const std::uint32_t seed = rng.seed();
  Surface print = page_surface(rng.substream(1), w);
  print.repeat_m = 1;
  Mesh page;
  if (rng.chance(0.5f)) {  // an open book: two curved pages
    for (const float side : {-1.0f, 1.0f}) {
      Mesh half;
      add_sheet(half, 24, 2, {1, 1}, [&](float u, float v) {
        const float s = side > 0 ? u : 1 - u;
        return vec3(side * s * w * 0.9f,
                    0.004f + 0.016f * std::pow(std::sin(3.14159f * std::pow(s, 0.45f)), 1.0f) * (1 - 0.4f * s),
                    (v - 0.5f) * h);
      });
      append(page, half);
    }
  } else {
    add_sheet(page, 24, 24, {1, 1}, [&](float u, float v) {
      const float corner = std::pow(std::max(u + v - 1.2f, 0.0f), 2.0f);
      return vec3((u - 0.5f) * w, 0.0012f + curl * corner + 0.002f * noise(seed, vec3(4 * u, 4 * v, 0)),
                  (v - 0.5f) * h);
    });
  }
  build.add("page", placed_mesh(page, pose), print);
}

void add_carton(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const vec3 size(rng.uniform(0.05f, 0.14f), rng.uniform(0.05f, 0.22f), rng.uniform(0.035f, 0.1f)), half = 0.5f * size;
  const vec3 color = rng.chance(0.4f) ? vec3(0.33f, 0.22f, 0.13f) : paint_color(rng);
  Mesh box;
  add_solid_box(box, {0, half.y, 0}, half, 0.001f);
  build.add("carton", placed_mesh(box, pose), rough_surface(rng.substream(1), color, 0.05f, 0.3f));
  const std::string title = random_text(rng, 1, 7).front();
  for (const float side : {1.0f, -1.0f}) {
    add_print(build, "front", pose, {-side * half.x, 0.001f, side * (half.z + 0.0003f)}, {side * size.x, 0, 0},
              {0, size.y - 0.002f, 0}, cover_surface(rng.substream(2), color, title));
  }
}

void add_book_row(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float length_m, float height_m) {
  float x = 0;
  for (int i = 0; x < length_m - 0.05f && i < 60; ++i) {
    RandomStream own = rng.substream(i);
    if (own.chance(0.06f)) {
      x += own.uniform(0.02f, 0.12f);
      continue;
    }
    const vec3 size(height_m * own.uniform(0.5f, 0.65f), own.uniform(0.012f, 0.045f),
                    height_m * own.uniform(0.68f, 0.95f));
    // upright, its spine to the front (+z)
    glm::mat4 stand = glm::translate(pose, vec3(x, 0.5f * size.z, -0.5f * size.x));
    stand = glm::rotate(stand, own.chance(0.12f) ? -0.14f : 0.0f, vec3(0, 0, 1));
    const glm::mat4 axes(glm::vec4(0, 0, -1, 0), glm::vec4(1, 0, 0, 0), glm::vec4(0, -1, 0, 0), glm::vec4(0, 0, 0, 1));
    const vec3 color = paint_color(own), half = 0.5f * size;
    Mesh box, spine;
    add_solid_box(box, {0, half.y, 0}, {half.x, half.y, half.z}, 0.001f);
    build.add("book", placed_mesh(box, stand * axes), Surface{.color = color, .roughness = 0.7f});
    if (own.chance(0.7f)) {
      add_print(build, "spine", stand * axes, {-half.x - 0.0003f, 0, -half.z}, {0, 0, size.z}, {0, size.y, 0},
                cover_surface(own.substream(4), color, random_text(own, 1, 9).front()));
    }
    x += size.y + 0.001f;
  }
}

}  // namespace dualpixel::scenes
