#include "scenes/test_targets/test_targets.h"

#include <cmath>

#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

glm::vec3 gray(float n) { return glm::vec3(0.02f + 0.9f * n * n); }

}  // namespace

void add_calibration_target(Glb& glb) {
  // 512 cells over 0.6 m: 1.2 mm, 4.7 photosites at 0.88 m; one cycle of noise is two cells
  const Texture texture = noise_texture(11, 2048, 32, 512, 0.85f, [](float n, float, float) { return gray(n); });
  const int material = glb.add_material(glb.add_texture(texture), glm::vec3(1), true);
  Mesh plane;
  plane.add_quad({-0.9f, -0.6f, -0.88f}, {1.8f, 0, 0}, {0, 1.2f, 0}, {3, 2});
  glb.add_node("target", plane, material);
  glb.add_camera("camera", glm::vec3(0), {0, 0, -1});
}

void add_slanted_planes(Glb& glb) {
  const auto plane = [&](const char* name, std::uint32_t seed, glm::vec3 corner, glm::vec3 a, glm::vec3 b,
                         glm::vec2 repeat, glm::vec3 tint) {
    const int material =
        glb.add_material(glb.add_texture(two_tone(seed, tint * 0.05f, tint, 8, 256, 0.8f)), glm::vec3(1), true);
    Mesh mesh;
    mesh.add_quad(corner, a, b, repeat);
    glb.add_node(name, mesh, material);
  };
  plane("left wall", 21, {-0.22f, -0.6f, -0.35f}, {-0.75f, 0, -1.65f}, {0, 1.2f, 0}, {6, 4}, {0.9f, 0.75f, 0.6f});
  plane("right wall", 22, {0.95f, -0.6f, -2.0f}, {-0.72f, 0, 1.6f}, {0, 1.2f, 0}, {6, 4}, {0.6f, 0.75f, 0.9f});
  plane("floor", 23, {-0.5f, -0.12f, -0.45f}, {1.0f, 0, 0}, {0, 0.05f, -1.5f}, {4, 6}, {0.7f, 0.8f, 0.55f});
  plane("leaning card", 24, {-0.11f, -0.11f, -0.62f}, {0.2f, 0, 0}, {0, 0.2f, -0.24f}, {1, 1}, {0.85f, 0.5f, 0.5f});
  plane("back wall", 25, {-1.3f, -0.9f, -2.0f}, {2.6f, 0, 0}, {0, 1.8f, 0}, {5, 3.5f}, {0.8f, 0.8f, 0.8f});
  glb.add_camera("camera", glm::vec3(0), {0, 0, -1});
}

void add_occlusion_edges(Glb& glb) {
  const auto material = [&](std::uint32_t seed, glm::vec3 dark, glm::vec3 bright) {
    return glb.add_material(glb.add_texture(two_tone(seed, dark, bright, 8, 256, 0.8f)), glm::vec3(1), true);
  };
  Mesh back;
  back.add_quad({-1.6f, -1.1f, -2.2f}, {3.2f, 0, 0}, {0, 2.2f, 0}, {6, 4});
  glb.add_node("back", back, material(31, {0.05f, 0.08f, 0.15f}, {0.5f, 0.7f, 0.9f}));

  // a comb whose teeth and gaps widen from 1 to 24 mm
  Mesh comb;
  float x = -0.33f;
  for (int i = 0; i < 12; ++i) {
    const float width = 0.001f * std::pow(1.33f, static_cast<float>(i));
    comb.add_quad({x, -0.02f, -0.9f}, {width, 0, 0}, {0, 0.25f, 0}, {width * 5, 1.2f});
    x += 2.1f * width;
  }
  glb.add_node("comb", comb, material(32, {0.2f, 0.05f, 0.03f}, {0.95f, 0.6f, 0.4f}));

  Mesh rods;
  for (int i = 0; i < 9; ++i) {
    const float width = 0.0003f * std::pow(1.5f, static_cast<float>(i));
    const float left = 0.05f + 0.03f * i;
    rods.add_quad({left, -0.3f, -1.2f}, {width, 0, 0}, {0.02f * (i - 4), 0.62f, 0}, {0.05f, 3});
  }
  glb.add_node("rods", rods, material(33, {0.02f, 0.1f, 0.03f}, {0.3f, 0.8f, 0.3f}));

  Mesh near_card;
  near_card.add_quad({-0.2f, -0.2f, -0.45f}, {0.16f, 0, 0}, {0, 0.13f, 0}, {0.8f, 0.7f});
  glb.add_node("near card", near_card, material(34, {0.2f, 0.15f, 0.02f}, {0.95f, 0.85f, 0.5f}));

  Mesh disc;
  constexpr int kCorners = 96;
  for (int i = 0; i < kCorners; ++i) {
    const float angle = 2 * static_cast<float>(M_PI) * i / kCorners;
    const glm::vec2 direction(std::cos(angle), std::sin(angle));
    disc.positions.push_back({0.09f + 0.07f * direction.x, -0.1f + 0.07f * direction.y, -0.6f});
    disc.uvs.push_back(0.5f + 0.35f * direction);
    if (i >= 2) disc.triangles.push_back({0u, static_cast<unsigned>(i - 1), static_cast<unsigned>(i)});
  }
  glb.add_node("disc", disc, material(35, {0.1f, 0.02f, 0.15f}, {0.8f, 0.5f, 0.9f}));
  glb.add_camera("camera", glm::vec3(0), {0, 0, -1});
}

}  // namespace dualpixel::scenes
