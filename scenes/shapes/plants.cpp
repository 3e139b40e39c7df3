#include "scenes/shapes/plants.h"

#include <cmath>

#include "scenes/math.h"
#include "scenes/procedural/noise.h"
#include "scenes/shapes/solids.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

vec3 random_direction(RandomStream& rng) {
  const float y = rng.uniform(-1, 1), phi = rng.uniform(0, 2 * kPi), r = std::sqrt(std::max(1 - y * y, 0.0f));
  return {r * std::cos(phi), y, r * std::sin(phi)};
}

/// A unit vector perpendicular to `along`, near `towards`.
vec3 across(vec3 along, vec3 towards) {
  vec3 side = towards - glm::dot(towards, along) * along;
  if (glm::dot(side, side) < 1e-6f) side = glm::cross(along, std::abs(along.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0));
  return glm::normalize(side);
}

void add_leaf_at(Mesh& leaves, RandomStream& rng, vec3 base, vec3 outward, float length) {
  const vec3 random = random_direction(rng), tilt = random_direction(rng);
  Leaf leaf;
  leaf.base = base;
  leaf.along = glm::normalize(outward + 0.9f * random + vec3(0, -0.15f, 0));
  leaf.up = across(leaf.along, vec3(0, 1, 0) + 0.6f * outward + 0.5f * tilt);
  leaf.length = length * rng.uniform(0.6f, 1.3f);
  leaf.width = leaf.length * rng.uniform(0.4f, 0.62f);
  leaf.droop = rng.uniform(0, 0.35f);
  leaf.fold = rng.uniform(0.1f, 0.45f);
  leaf.stalk = 0.12f;
  add_blade(leaves, leaf, rng.uniform(), 2);
}

/// A limb that bends and forks, and leaves along the last forks.
struct Grower {
  Mesh& wood;
  Mesh& leaves;
  RandomStream rng;
  const TreeOptions& options;
  std::vector<std::pair<vec3, vec3>> twigs;  ///< ends and directions

  void grow(vec3 from, vec3 along, float length, float radius, int level) {
    constexpr int kSteps = 5;
    std::vector<vec3> path = {from};
    std::vector<float> radii = {radius};
    vec3 direction = along;
    for (int i = 1; i <= kSteps; ++i) {
      const float upward = level == 0 ? 0.03f : 0.12f;
      direction = glm::normalize(direction + (level == 0 ? 0.09f : 0.22f) * random_direction(rng) + vec3(0, upward, 0));
      path.push_back(path.back() + direction * (length / kSteps));
      radii.push_back(radius * (1 - 0.42f * static_cast<float>(i) / kSteps));
      if (level >= 2) twigs.emplace_back(path.back(), direction);
    }
    add_pipe(wood, path, radii, level == 0 ? 12 : level == 1 ? 8 : 5, false);
    if (level == 3) return;
    const int forks = level == 0 ? 6 : level == 1 ? 5 : 4;
    for (int k = 0; k < forks; ++k) {
      const float t = level == 0 ? rng.uniform(0.55f, 1) : rng.uniform(0.35f, 1);
      const int at = std::min(static_cast<int>(t * kSteps), kSteps - 1);
      const vec3 base = glm::mix(path[at], path[at + 1], t * kSteps - static_cast<float>(at));
      const float phi = 2.4f * static_cast<float>(k) + rng.uniform(0, 1.2f);
      const vec3 side = across(direction, vec3(std::cos(phi), 0, std::sin(phi)));
      const vec3 out = glm::normalize(direction * rng.uniform(0.35f, 0.8f) + side * rng.uniform(0.6f, 1.1f));
      grow(base, out, length * rng.uniform(0.5f, 0.75f) * (level == 0 ? 2.0f * options.spread : 1.0f),
           radii[at] * rng.uniform(0.45f, 0.65f), level + 1);
    }
  }
};

}  // namespace

void add_blade(Mesh& leaves, const Leaf& leaf, float shade, int steps) {
  const vec3 side = glm::cross(leaf.up, leaf.along);
  const auto first = static_cast<unsigned>(leaves.positions.size());
  for (int i = 0; i <= steps; ++i) {
    const float t = leaf.stalk + (1 - leaf.stalk) * static_cast<float>(i) / static_cast<float>(steps);
    const float s = (t - leaf.stalk) / (1 - leaf.stalk);
    const float half = 0.5f * leaf.width * std::max(1.9f * std::sqrt(s) * (1 - s * s), 0.02f);
    const vec3 middle = leaf.base + leaf.along * (t * leaf.length) - leaf.up * (leaf.droop * leaf.length * t * t);
    const vec3 normal = glm::normalize(leaf.up + 2 * leaf.droop * t * leaf.along);
    for (const float a : {-1.0f, 0.0f, 1.0f}) {
      leaves.positions.push_back(middle + side * (a * half) + leaf.up * (std::abs(a) * half * leaf.fold));
      leaves.normals.push_back(glm::normalize(normal - 0.7f * leaf.fold * a * side));
      leaves.uvs.push_back({shade + 0.04f * a, 0.1f * s + 0.37f * shade});
    }
  }
  for (int i = 0; i < steps; ++i) {
    const unsigned a = first + 3 * static_cast<unsigned>(i);
    for (const unsigned b : {a, a + 1}) {
      leaves.triangles.push_back({b, b + 1, b + 4});
      leaves.triangles.push_back({b, b + 4, b + 3});
    }
  }
}

void add_tree(Mesh& wood, Mesh& leaves, RandomStream rng, const TreeOptions& options) {
  Grower grower{wood, leaves, rng.substream(1), options, {}};
  const float trunk = options.height_m * (0.25f + options.trunk_share);
  const float radius = options.height_m * rng.uniform(0.014f, 0.024f);
  grower.grow({0, -0.05f, 0}, glm::normalize(vec3(0.05f * rng.normal(), 1, 0.05f * rng.normal())), trunk, radius, 0);
  if (options.bare || grower.twigs.empty()) return;
  RandomStream own = rng.substream(2);
  for (int i = 0; i < options.leaves; ++i) {
    const auto& [at, direction] =
        grower.twigs[static_cast<std::size_t>(own.below(static_cast<int>(grower.twigs.size())))];
    const vec3 off = random_direction(own) * (options.height_m * 0.035f * own.uniform());
    add_leaf_at(leaves, own, at + off, glm::normalize(direction + random_direction(own)), options.leaf_m);
  }
}

void add_shrub(Mesh& wood, Mesh& leaves, RandomStream rng, const ShrubOptions& options) {
  const std::uint32_t seed = rng.seed();
  for (int i = 0; i < 9; ++i) {
    const vec3 to = random_direction(rng) * options.radii * 0.7f + vec3(0, options.radii.y * 0.9f, 0);
    const vec3 bend = 0.1f * options.radii * random_direction(rng);
    add_pipe(wood, curve(6, [&](float t) { return t * to + 4 * t * (1 - t) * bend; }),
             std::vector<float>{0.012f, 0.01f, 0.008f, 0.006f, 0.005f, 0.003f}, 5, false);
  }
  for (int i = 0; i < options.leaves; ++i) {
    const vec3 out = random_direction(rng);
    const float bumps = 0.62f + 0.6f * fractal(seed, out * 2.2f + 7.0f, 3);
    const float depth = std::pow(rng.uniform(), 0.35f);
    const vec3 at = out * options.radii * bumps * (0.45f + 0.55f * depth) + vec3(0, options.radii.y * 0.92f, 0);
    if (at.y < 0.02f) continue;
    add_leaf_at(leaves, rng, at, out, options.leaf_m);
  }
}

void add_pot_plant(Mesh& leaves, RandomStream rng, float height_m) {
  const bool rosette = rng.chance(0.5f);
  const int stems = rosette ? 24 + rng.below(16) : 5 + rng.below(5);
  for (int i = 0; i < stems; ++i) {
    const float phi = 2.4f * static_cast<float>(i) + rng.uniform(0, 0.8f), lean = rng.uniform(0.15f, 0.9f);
    const vec3 out(std::cos(phi), 0, std::sin(phi));
    if (rosette) {
      Leaf leaf;
      leaf.base = 0.05f * height_m * out;
      leaf.along = glm::normalize(lean * out + vec3(0, 1, 0));
      leaf.up = across(leaf.along, vec3(0, 1, 0) - out);
      leaf.length = height_m * rng.uniform(0.6f, 1.15f);
      leaf.width = height_m * rng.uniform(0.07f, 0.12f);
      leaf.droop = lean * rng.uniform(0.05f, 0.5f);
      leaf.fold = 0.35f;
      add_blade(leaves, leaf, rng.uniform(), 8);
      continue;
    }
    const vec3 tip = height_m * rng.uniform(0.6f, 1.0f) * glm::normalize(0.8f * lean * out + vec3(0, 1, 0));
    const vec3 bend = 0.12f * height_m * out;
    const std::vector<vec3> stem = curve(8, [&](float t) { return t * tip + 4 * t * (1 - t) * bend; });
    add_pipe(leaves, stem, 0.006f * height_m + 0.0006f, 5);
    for (std::size_t k = 2; k < stem.size(); ++k) {
      for (int both = 0; both < 2; ++both) {
        const vec3 outward = glm::normalize(random_direction(rng) + 0.6f * out);
        add_leaf_at(leaves, rng, stem[k], outward, 0.2f * height_m);
      }
    }
  }
}

void add_grass(Mesh& leaves, RandomStream rng, int blades, float radius_m, float height_m) {
  for (int i = 0; i < blades; ++i) {
    const float r = radius_m * std::sqrt(rng.uniform()), phi = rng.uniform(0, 2 * kPi);
    Leaf leaf;
    leaf.base = {r * std::cos(phi), -0.005f, r * std::sin(phi)};
    leaf.along = glm::normalize(vec3(0, 1, 0) + 0.55f * random_direction(rng));
    leaf.up = across(leaf.along, random_direction(rng));
    leaf.length = height_m * rng.uniform(0.4f, 1.2f);
    leaf.width = 0.004f + 0.02f * leaf.length;
    leaf.droop = rng.uniform(0, 0.5f);
    leaf.fold = 0.2f;
    add_blade(leaves, leaf, rng.uniform(), 3);
  }
}

void add_flower(Mesh& petals, Mesh& middle, RandomStream rng, vec3 at, vec3 facing, float radius_m) {
  const vec3 n = glm::normalize(facing), x = across(n, vec3(0, 1, 0.3f)), y = glm::cross(n, x);
  const int count = 5 + rng.below(9);
  const float cup = rng.uniform(-0.1f, 0.7f);
  for (int i = 0; i < count; ++i) {
    const float phi = 2 * kPi * static_cast<float>(i) / static_cast<float>(count) + 0.1f * rng.normal();
    const vec3 out = std::cos(phi) * x + std::sin(phi) * y;
    Leaf leaf;
    leaf.base = at + 0.1f * radius_m * out;
    leaf.along = glm::normalize(out + cup * n);
    leaf.up = across(leaf.along, n);
    leaf.length = radius_m * rng.uniform(0.85f, 1.05f);
    leaf.width = radius_m * 3.2f / static_cast<float>(count) * rng.uniform(0.8f, 1.1f);
    leaf.droop = rng.uniform(-0.1f, 0.25f);
    leaf.fold = 0.15f;
    add_blade(petals, leaf, rng.uniform(), 5);
  }
  add_ball(middle, at + 0.04f * radius_m * n, vec3(0.2f * radius_m), 8);
}

}  // namespace dualpixel::scenes
