#include "scenes/make_scenes/portrait_scene.h"

#include <algorithm>
#include <cmath>

#include "scenes/make_scenes/portrait_person.h"
#include "scenes/procedural/signed_distance.h"
#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

// One file, and functions as long as they are: the compiler inlines by the size of a file, and where it inlines, the
// last bits of the shipped glTF file change.

constexpr float kPi = 3.14159265358979f;

/// A leaf: a folded blade of six triangles from `base` along `along`, `length` meters.
void add_leaf(Mesh& mesh, std::uint32_t seed, int i, vec3 base, vec3 along, vec3 side, float length) {
  const vec3 up = glm::normalize(glm::cross(side, along));
  const float half = length * (0.2f + 0.1f * scene_hash01(seed + 1, i));
  const vec3 edge = glm::normalize(side + 0.35f * up) * half, other = glm::normalize(-side + 0.35f * up) * half;
  const vec3 droop = -0.18f * length * up;
  const vec3 points[7] = {base,
                          base + along * (0.35f * length) + edge,
                          base + along * (0.35f * length) + other,
                          base + along * (0.4f * length),
                          base + along * (0.72f * length) + 0.7f * edge + 0.4f * droop,
                          base + along * (0.72f * length) + 0.7f * other + 0.4f * droop,
                          base + along * length + droop};
  const unsigned faces[8][3] = {{0, 1, 3}, {0, 3, 2}, {1, 4, 3}, {3, 5, 2}, {3, 4, 6}, {3, 6, 5}, {0, 0, 0}, {0, 0, 0}};
  const auto first = static_cast<unsigned>(mesh.positions.size());
  const glm::vec2 corner(scene_hash01(seed + 2, i), scene_hash01(seed + 3, i));
  for (const vec3& p : points) {
    mesh.positions.push_back(p);
    mesh.normals.push_back(up);
    mesh.uvs.push_back(corner + 0.25f * glm::vec2(glm::dot(p - base, side), glm::dot(p - base, along)) / length);
  }
  for (int f = 0; f < 6; ++f) mesh.triangles.push_back({first + faces[f][0], first + faces[f][1], first + faces[f][2]});
}

/// `count` leaves near the surface of an ellipsoid.
void add_bush(Mesh& mesh, std::uint32_t seed, int count, vec3 center, vec3 radii, float leaf_m) {
  for (int i = 0; i < count; ++i) {
    const float z = 2 * scene_hash01(seed, i, 1) - 1, phi = 2 * kPi * scene_hash01(seed, i, 2),
                r = std::sqrt(1 - z * z);
    const vec3 outward(r * std::cos(phi), z, r * std::sin(phi));
    const float bumps = 0.75f + 0.5f * fractal_noise(seed + 9, outward * 3.0f + center, 1, 3, 0.6f);
    const vec3 base = center + outward * radii * bumps * std::pow(0.5f + 0.5f * scene_hash01(seed, i, 3), 0.4f);
    const vec3 random =
        vec3(scene_hash01(seed, i, 4), scene_hash01(seed, i, 5), scene_hash01(seed, i, 6)) * 2.0f - 1.0f;
    const vec3 along = glm::normalize(outward * 0.8f + random + vec3(0, -0.3f, 0));
    const vec3 side =
        glm::normalize(glm::cross(along, glm::normalize(outward + 0.7f * vec3(random.z, random.x, random.y))));
    add_leaf(mesh, seed + 20, i, base, along, side, leaf_m * (0.6f + 0.8f * scene_hash01(seed, i, 7)));
  }
}

/// A tapered, bent branch of eight sides.
void add_branch(Mesh& mesh, std::uint32_t seed, vec3 from, vec3 to, float radius_from, float radius_to) {
  constexpr unsigned kSides = 10, kRings = 24;
  const vec3 axis = glm::normalize(to - from);
  const vec3 x = glm::normalize(glm::cross(axis, std::abs(axis.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0)));
  const vec3 y = glm::cross(axis, x);
  const float length = glm::length(to - from);
  const auto first = static_cast<unsigned>(mesh.positions.size());
  for (unsigned ring = 0; ring <= kRings; ++ring) {
    const float t = static_cast<float>(ring) / kRings;
    const vec3 bend =
        0.06f * length *
        ((value_noise(seed, vec3(t * 4, 0, 0)) - 0.5f) * x + (value_noise(seed + 1, vec3(t * 4, 0, 0)) - 0.5f) * y);
    for (unsigned s = 0; s <= kSides; ++s) {
      const float phi = 2 * kPi * static_cast<float>(s % kSides) / kSides;
      const vec3 n = std::cos(phi) * x + std::sin(phi) * y;
      const float radius = (radius_from + (radius_to - radius_from) * t) *
                           (0.9f + 0.25f * value_noise(seed + 2, vec3(s % kSides, t * 30, 0)));
      mesh.positions.push_back(from + (to - from) * t + bend + radius * n);
      mesh.normals.push_back(n);
      mesh.uvs.push_back({static_cast<float>(s) / kSides, t * length / (6 * radius_from)});
    }
  }
  for (unsigned ring = 0; ring < kRings; ++ring) {
    for (unsigned s = 0; s < kSides; ++s) {
      const unsigned a = first + ring * (kSides + 1) + s, b = a + kSides + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
}

void add_garden(Glb& glb) {
  const auto plain = [&](const Texture& texture) { return glb.add_material(glb.add_texture(texture), vec3(1), false); };

  const Texture brick = noise_texture(301, 1024, 8, 512, 0.85f, [](float n, float u, float v) {
    const float row = std::floor(v * 12);
    const float x = u * 5 + 0.5f * std::fmod(row, 2.0f), y = v * 12;
    const float column = std::floor(x);
    const float joint = std::min({x - column, 1 - (x - column), (y - row) * 0.42f, (1 - (y - row)) * 0.42f});
    const float tone = scene_hash01(302, static_cast<int>(column) % 5, static_cast<int>(row));
    if (joint < 0.035f + 0.02f * n) return glm::mix(vec3(0.22f, 0.2f, 0.17f), vec3(0.5f, 0.47f, 0.42f), n);
    return glm::mix(vec3(0.12f, 0.04f, 0.025f), vec3(0.55f, 0.25f, 0.16f), 0.25f + 0.75f * n) * (0.6f + 0.6f * tone);
  });
  Mesh wall;
  wall.add_quad({-5.5f, -1.2f, -4.6f}, {5.2f, 0, 0.5f}, {0, 2.3f, 0}, {4.3f, 2.4f});
  glb.add_node("wall", wall, plain(brick));

  const Texture paving = noise_texture(311, 1024, 8, 512, 0.88f, [](float n, float u, float v) {
    const float x = u * 3, y = v * 3;
    const float joint = std::min({x - std::floor(x), std::ceil(x) - x, y - std::floor(y), std::ceil(y) - y});
    const float tone = scene_hash01(312, static_cast<int>(x), static_cast<int>(y));
    return glm::mix(vec3(0.12f, 0.11f, 0.095f), vec3(0.6f, 0.56f, 0.5f), n) *
           (joint < 0.03f ? 0.4f : 0.75f + 0.4f * tone);
  });
  Mesh ground;
  ground.add_quad({-7, -1.15f, -0.2f}, {14, 0, 0}, {0, 0, -14}, {9, 9});
  glb.add_node("terrace", ground, plain(paving));

  const Texture wood = noise_texture(321, 1024, 8, 512, 0.85f, [](float n, float u, float v) {
    const float grain = 0.5f + 0.5f * std::sin(2 * kPi * (v * 22 + 1.5f * n + 0.6f * std::sin(6.28318f * u)));
    return glm::mix(vec3(0.13f, 0.06f, 0.025f), vec3(0.5f, 0.3f, 0.15f), 0.5f * grain + 0.5f * n);
  });
  const int wood_material = plain(wood);
  Mesh table;
  table.add_quad({-0.62f, -0.215f, -0.4f}, {0.47f, 0, 0.0f}, {0, 0.0f, -0.34f}, {1.2f, 0.9f});
  table.add_quad({-0.62f, -0.235f, -0.4f}, {0.47f, 0, 0.0f}, {0, 0.02f, 0}, {1.2f, 0.05f});
  glb.add_node("table", table, wood_material);

  const Texture bark = two_tone(331, {0.035f, 0.025f, 0.018f}, {0.3f, 0.23f, 0.17f}, 8, 512, 0.9f);
  Mesh trees;
  add_branch(trees, 341, {1.05f, -1.2f, -2.7f}, {0.92f, 2.4f, -2.6f}, 0.11f, 0.08f);
  add_branch(trees, 344, {0.98f, 0.35f, -2.65f}, {0.15f, 0.95f, -2.5f}, 0.035f, 0.012f);
  add_branch(trees, 347, {-1.9f, -1.2f, -6.5f}, {-1.7f, 3.5f, -6.4f}, 0.16f, 0.12f);
  add_branch(trees, 350, {2.9f, -1.2f, -9.5f}, {3.0f, 4.0f, -9.5f}, 0.22f, 0.17f);
  add_branch(trees, 353, {0.55f, -1.2f, -12.0f}, {0.6f, 4.0f, -12.0f}, 0.2f, 0.16f);
  for (int i = 0; i < 14; ++i) {  // bare twigs that cross the sky and the wall
    const float x = -0.62f + 0.11f * i + 0.05f * scene_hash01(360, i);
    add_branch(trees, 400 + 3 * i, {x, 0.75f, -1.6f - 0.5f * scene_hash01(361, i)},
               {x + 0.35f * (scene_hash01(362, i) - 0.5f), 0.12f + 0.35f * scene_hash01(363, i), -1.5f}, 0.006f,
               0.0015f);
  }
  glb.add_node("branches", trees, plain(bark));

  const int leaf_green = plain(two_tone(371, {0.02f, 0.05f, 0.008f}, {0.24f, 0.40f, 0.08f}, 4, 256, 0.85f));
  const int leaf_olive = plain(two_tone(372, {0.035f, 0.045f, 0.012f}, {0.36f, 0.36f, 0.10f}, 4, 256, 0.85f));
  const int leaf_red = plain(two_tone(373, {0.10f, 0.02f, 0.01f}, {0.55f, 0.22f, 0.07f}, 4, 256, 0.85f));
  Mesh hedge, shrubs, autumn;
  for (int i = 0; i < 7; ++i)
    add_bush(hedge, 500 + 40 * i, 1300, {-0.2f + 0.62f * i, -0.45f + 0.16f * scene_hash01(499, i), -3.6f - 0.15f * i},
             {0.5f, 0.62f, 0.4f}, 0.11f);
  add_bush(shrubs, 800, 1100, {-0.95f, -0.62f, -2.0f}, {0.42f, 0.55f, 0.35f}, 0.075f);
  add_bush(shrubs, 840, 700, {0.62f, -0.62f, -1.55f}, {0.3f, 0.4f, 0.25f}, 0.065f);
  add_bush(hedge, 880, 1200, {-1.8f, 2.6f, -6.4f}, {1.6f, 1.3f, 1.2f}, 0.2f);
  add_bush(hedge, 920, 1200, {3.0f, 2.9f, -9.5f}, {2.2f, 1.6f, 1.6f}, 0.28f);
  add_bush(shrubs, 960, 1200, {0.5f, 2.6f, -12.0f}, {2.6f, 1.6f, 1.5f}, 0.34f);
  add_bush(shrubs, 1000, 1600, {-1.5f, 0.2f, -13.5f}, {7.0f, 1.9f, 0.8f}, 0.42f);
  add_bush(autumn, 1040, 420, {0.35f, 0.6f, -2.45f}, {0.5f, 0.22f, 0.25f}, 0.055f);
  for (int i = 0; i < 90; ++i) {  // leaves on the twigs
    const vec3 base(-0.65f + 1.5f * scene_hash01(1081, i), 0.15f + 0.45f * scene_hash01(1082, i),
                    -1.5f - 0.4f * scene_hash01(1083, i));
    const vec3 along = glm::normalize(vec3(scene_hash01(1084, i) - 0.5f, -0.6f, scene_hash01(1085, i) - 0.5f));
    add_leaf(autumn, 1090, i, base, along,
             glm::normalize(glm::cross(along, vec3(scene_hash01(1086, i) - 0.5f, 0.2f, 1))), 0.035f);
  }
  // the plant on the table, nearer than the focus plane
  add_bush(shrubs, 1120, 70, {-0.29f, -0.1f, -0.52f}, {0.06f, 0.08f, 0.05f}, 0.045f);
  add_bush(hedge, 1136, 60, {-0.25f, -0.15f, -0.47f}, {0.05f, 0.05f, 0.04f}, 0.03f);
  glb.add_node("hedge", hedge, leaf_green);
  glb.add_node("shrubs", shrubs, leaf_olive);
  glb.add_node("autumn leaves", autumn, leaf_red);

  const Texture clay = two_tone(381, {0.2f, 0.07f, 0.035f}, {0.6f, 0.3f, 0.18f}, 8, 512, 0.85f);
  Mesh pot;
  add_branch(pot, 1200, {-0.28f, -0.214f, -0.51f}, {-0.28f, -0.15f, -0.51f}, 0.032f, 0.045f);
  glb.add_node("pot", pot, plain(clay));
}

}  // namespace

void make_portrait(const std::string& path) {
  Glb glb;
  add_portrait_person(glb);
  add_garden(glb);
  glb.add_camera("camera", vec3(0), {0, 0, -1});
  glb.add_sun(glm::normalize(vec3(0.55f, -0.75f, -0.55f)), {1, 0.93f, 0.82f}, 13000);
  glb.write(path);
}

}  // namespace dualpixel::scenes
