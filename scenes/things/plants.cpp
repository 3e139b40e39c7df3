#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "scenes/procedural/noise.h"
#include "scenes/shapes/plants.h"
#include "scenes/things/things.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

Surface leaves_of(RandomStream& rng) {
  const vec3 dark = vec3(0.03f, 0.075f, 0.02f) * rng.uniform(0.7f, 1.6f);
  const float yellow = rng.uniform(1.2f, 2.6f);
  return leaf_surface(rng.substream(77), dark, dark * vec3(yellow * 1.2f, yellow, 1.1f));
}

/// Skin of a fruit: two colors in patches, and specks.
Surface fruit_skin(RandomStream rng, vec3 color, vec3 blush, float roughness) {
  const PinkNoise patch(rng.seed(), 2, 8, 1.5f, 2, 1), speck(rng.seed(), 16, 256, 1.1f);
  Surface surface;
  surface.repeat_m = 0.25f;
  surface.roughness = roughness;
  surface.texture = paint(256, [&](float u, float v) {
    const float mix = std::clamp(0.5f + 0.45f * patch(u, v), 0.0f, 1.0f);
    return shaded(glm::mix(color, blush, mix), 0.08f, speck(u, v));
  });
  return surface;
}

void add_stalk(SceneBuilder& build, const glm::mat4& pose, float from) {
  Mesh stalk;
  add_pipe(stalk, {{0, from, 0}, {0.001f, from + 0.008f, 0}, {0.004f, from + 0.017f, 0.001f}},
           {0.0011f, 0.001f, 0.0016f}, 6);
  build.add("stalk", placed_mesh(stalk, pose), Surface{.color = vec3(0.08f, 0.05f, 0.025f)});
}

void add_banana(SceneBuilder& build, RandomStream& rng, const glm::mat4& pose) {
  const float length = rng.uniform(0.13f, 0.17f), bend = rng.uniform(0.9f, 1.4f), r = rng.uniform(0.015f, 0.018f);
  std::vector<float> radii;
  const std::vector<vec3> path = curve(17, [&](float t) {
    const float a = bend * (t - 0.5f), turn = length / bend;
    radii.push_back(r * std::pow(std::max(1 - std::pow(std::abs(2 * t - 1), 5.0f), 0.0f), 0.5f) + 0.004f);
    return vec3(turn * std::sin(a), r + 0.004f, turn * (1 - std::cos(a)) - 0.02f);
  });
  Mesh mesh;
  add_pipe(mesh, path, radii, 7);
  build.add("banana", placed_mesh(mesh, pose),
            fruit_skin(rng.substream(1), vec3(0.72f, 0.5f, 0.07f), vec3(0.6f, 0.47f, 0.09f), 0.6f));
}

}  // namespace

void add_fruit(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const int kind = rng.below(6);
  if (kind == 5) return add_banana(build, rng, pose);
  const std::uint32_t seed = rng.seed();
  const float r = rng.uniform(0.032f, 0.043f), lumps = rng.uniform(0.03f, 0.08f);
  vec3 radii(r, r * 0.93f, r), color, blush;
  float roughness = 0.35f;
  std::function<float(vec3)> shape;
  const auto lump = [seed, lumps](vec3 n) { return 1 + lumps * (noise(seed, n * 1.7f) - 0.5f); };
  if (kind <= 1) {  // apple, with its hollows
    shape = [lump](vec3 n) { return lump(n) * (1 - 0.28f * std::exp(-18 * (1 - std::abs(n.y)))); };
    color = rng.chance(0.5f) ? vec3(0.45f, 0.03f, 0.03f) : vec3(0.4f, 0.42f, 0.06f);
    blush = rng.chance(0.6f) ? vec3(0.55f, 0.09f, 0.04f) : vec3(0.5f, 0.45f, 0.1f);
  } else if (kind == 2) {  // orange
    shape = [seed, lump](vec3 n) { return lump(n) * (1 - 0.012f * noise(seed + 1, n * 26.0f)); };
    color = vec3(0.78f, 0.27f, 0.02f), blush = vec3(0.72f, 0.32f, 0.03f), roughness = 0.5f;
  } else if (kind == 3) {  // pear
    radii = {r * 0.92f, r * 1.5f, r * 0.92f};
    shape = [lump](vec3 n) {
      return lump(n) * (n.y > -0.2f ? 1 - 0.33f * std::pow((n.y + 0.2f) / 1.2f, 1.5f) * (1 - 0.3f * n.y) : 1.0f);
    };
    color = vec3(0.42f, 0.42f, 0.07f), blush = vec3(0.5f, 0.3f, 0.08f), roughness = 0.55f;
  } else {  // lemon
    radii = {r * 0.85f, r * 0.85f, r * 1.15f};
    shape = [lump](vec3 n) { return lump(n) * (1 + 0.13f * std::exp(-14 * (1 - std::abs(n.z)))); };
    color = vec3(0.75f, 0.58f, 0.05f), blush = vec3(0.7f, 0.62f, 0.08f), roughness = 0.45f;
  }
  const float lift = radii.y * shape(vec3(0, -1, 0));
  Mesh fruit;
  add_ball(fruit, vec3(0), radii, 32, shape);
  const glm::mat4 tilted = glm::rotate(glm::translate(pose, vec3(0, lift, 0)), 0.12f * rng.normal(), vec3(1, 0, 0));
  build.add("fruit", placed_mesh(fruit, tilted), fruit_skin(rng.substream(1), color, blush, roughness));
  if (kind <= 1 || kind == 3) add_stalk(build, tilted, radii.y * shape(vec3(0, 1, 0)) - 0.004f);
}

void add_potted_plant(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.035f, 0.06f), h = r * rng.uniform(1.3f, 1.9f), narrow = rng.uniform(0.65f, 0.9f);
  Mesh pot, earth, leaves;
  add_lathe(pot, pose,
            {{0, 0},
             {narrow * r, 0},
             {0.96f * r, 0.8f * h},
             {1.06f * r, 0.8f * h},
             {1.06f * r, h},
             {0.97f * r, h},
             {0.93f * r, 0.86f * h}});
  add_lathe(earth, pose, {{0.95f * r, 0.87f * h}, {0.4f * r, 0.89f * h}, {0, 0.88f * h}});
  const vec3 clay(0.4f, 0.16f, 0.08f);
  build.add("pot", pot,
            rng.chance(0.5f) ? rough_surface(rng.substream(1), clay * rng.uniform(0.7f, 1.2f), 0.12f, 0.3f)
                             : plain_surface(rng.substream(1), paint_color(rng), rng.uniform(0.2f, 0.9f)));
  build.add("earth", earth, rough_surface(rng.substream(2), vec3(0.05f, 0.035f, 0.022f), 0.4f, 0.1f, 1.1f));
  add_pot_plant(leaves, rng.substream(3), rng.uniform(0.1f, 0.28f));
  build.add("plant", placed_mesh(leaves, glm::translate(pose, vec3(0, 0.87f * h, 0))), leaves_of(rng));
}

void add_vase_of_flowers(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float h = rng.uniform(0.1f, 0.18f), r = h * rng.uniform(0.25f, 0.4f), mouth = r * rng.uniform(0.45f, 0.9f),
              waist = rng.uniform(0.3f, 0.7f);
  std::vector<vec2> profile = {{0, 0}, {0.6f * r, 0}};
  for (int i = 1; i <= 14; ++i) {
    const float t = static_cast<float>(i) / 14;
    const float bulge = std::exp(-std::pow((t - waist) / 0.33f, 2.0f));
    profile.push_back({glm::mix(glm::mix(0.6f * r, mouth, t), r, bulge), h * t});
  }
  profile.push_back({mouth - 0.003f, h});
  profile.push_back({mouth - 0.004f, 0.7f * h});
  Mesh vase, stems, petals, middles;
  add_lathe(vase, pose, profile);
  build.add("vase", vase, plain_surface(rng.substream(1), paint_color(rng), rng.uniform(0.1f, 0.6f)));
  const int flowers = 3 + rng.below(9);
  for (int i = 0; i < flowers; ++i) {
    const float phi = 2.4f * static_cast<float>(i),
                lean = 0.75f * std::sqrt(static_cast<float>(i) / static_cast<float>(flowers));
    const vec3 out(std::cos(phi), 0, std::sin(phi)), way = glm::normalize(vec3(0, 1, 0) + lean * out);
    const vec3 base(0.4f * mouth * out.x, 0.75f * h, 0.4f * mouth * out.z), tip = base + way * rng.uniform(0.09f, 0.2f);
    add_pipe(stems, {base, glm::mix(base, tip, 0.5f) + 0.008f * out, tip}, 0.0014f, 5);
    Leaf leaf{.base = glm::mix(base, tip, 0.55f),
              .along = glm::normalize(out + way),
              .up = glm::normalize(way - 0.3f * out),
              .length = 0.05f,
              .width = 0.016f};
    leaf.up = glm::normalize(leaf.up - glm::dot(leaf.up, leaf.along) * leaf.along);
    add_blade(stems, leaf, rng.uniform(), 4);
    add_flower(petals, middles, rng.substream(20 + i), tip, way + 0.5f * out, rng.uniform(0.016f, 0.034f));
  }
  build.add("stems", placed_mesh(stems, pose), leaves_of(rng));
  const vec3 color = paint_color(rng);
  build.add("petals", placed_mesh(petals, pose),
            leaf_surface(rng.substream(2), glm::max(color, vec3(0.12f)), glm::mix(color, vec3(0.75f), 0.4f)));
  build.add("flower middles", placed_mesh(middles, pose),
            plain_surface(rng.substream(3), vec3(0.5f, 0.33f, 0.05f), 1, 0.2f));
}

}  // namespace dualpixel::scenes
