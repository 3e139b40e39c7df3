#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "scenes/places/places.h"
#include "scenes/shapes/plants.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

int foliage(SceneBuilder& build, RandomStream rng) {
  const vec3 dark = vec3(0.03f, 0.07f, 0.018f) * rng.uniform(0.7f, 1.6f);
  const bool autumn = rng.chance(0.2f);
  const vec3 green = dark * vec3(rng.uniform(1.4f, 2.6f), rng.uniform(1.3f, 2.1f), 1.1f);
  return build.add(leaf_surface(rng.substream(1), autumn ? vec3(0.2f, 0.06f, 0.015f) : dark,
                                autumn ? vec3(0.45f, 0.2f, 0.03f) : green));
}

int wood(SceneBuilder& build, RandomStream rng) {
  return build.add(bark_surface(rng.substream(2), vec3(0.13f, 0.1f, 0.075f) * rng.uniform(0.5f, 1.8f)));
}

}  // namespace

Planting grow_planting(SceneBuilder& build, RandomStream rng, int kinds) {
  Planting planting;
  for (int i = 0; i < kinds; ++i) {
    RandomStream own = rng.substream(i);
    Mesh trunk, crown;
    TreeOptions tree;
    tree.height_m = own.uniform(5, 9);
    tree.trunk_share = own.uniform(0.1f, 0.35f);
    tree.spread = own.uniform(0.4f, 0.65f);
    tree.leaves = 9000 + own.below(7000);
    tree.leaf_m = own.uniform(0.09f, 0.16f);
    tree.bare = own.chance(0.1f);
    add_tree(trunk, crown, own.substream(1), tree);
    planting.trees.push_back(build.add_shared({{trunk, wood(build, own)}, {crown, foliage(build, own)}}));
    Mesh stems, leaves;
    const float r = own.uniform(0.35f, 0.8f);
    add_shrub(stems, leaves, own.substream(2), {{r, r * own.uniform(0.7f, 1.3f), r}, 2600, own.uniform(0.04f, 0.08f)});
    planting.shrubs.push_back(
        build.add_shared({{stems, wood(build, own.substream(3))}, {leaves, foliage(build, own.substream(4))}}));
  }
  return planting;
}

void plant(SceneBuilder& build, RandomStream& rng, const char* name, int shared, vec3 at, float scale) {
  const float turn = rng.uniform(0, 2 * std::numbers::pi_v<float>), size = scale * rng.uniform(0.75f, 1.25f);
  build.place(name, shared, glm::scale(standing(at, turn), vec3(size, size * rng.uniform(0.85f, 1.15f), size)));
}

void add_branch_in_front(SceneBuilder& build, RandomStream rng, vec3 eye, float distance_m) {
  const float side = rng.sign(), scale = distance_m;
  Mesh twigs, leaves;
  const int count = 2 + rng.below(4);
  for (int i = 0; i < count; ++i) {
    const vec3 from = eye + vec3(side * scale * rng.uniform(0.5f, 0.8f), scale * rng.uniform(0.3f, 0.7f),
                                 -distance_m * rng.uniform(0.8f, 1.2f));
    const vec3 to =
        from + scale * vec3(-side * rng.uniform(0.2f, 0.55f), rng.uniform(-0.45f, 0.0f), rng.uniform(-0.15f, 0.15f));
    const vec3 sag(0, -0.06f * scale, 0);
    const std::vector<vec3> path = curve(12, [&](float t) { return glm::mix(from, to, t) + 4 * t * (1 - t) * sag; });
    add_pipe(twigs, path,
             std::vector<float>{0.006f, 0.0055f, 0.005f, 0.0045f, 0.004f, 0.0036f, 0.0032f, 0.0028f, 0.0024f, 0.002f,
                                0.0016f, 0.001f},
             6);
    for (std::size_t k = 2; k < path.size(); ++k) {
      for (int n = 0; n < 3; ++n) {
        Leaf leaf;
        leaf.base = path[k];
        leaf.along = glm::normalize(rng.uniform3(-1, 1) + vec3(-0.4f * side, -0.3f, 0.01f));
        const vec3 up = vec3(0, 1, 0) + 0.6f * rng.uniform3(-1, 1);
        leaf.up = glm::normalize(up - glm::dot(up, leaf.along) * leaf.along);
        leaf.length = rng.uniform(0.035f, 0.075f);
        leaf.width = 0.5f * leaf.length;
        leaf.droop = rng.uniform(0, 0.3f);
        leaf.stalk = 0.15f;
        add_blade(leaves, leaf, rng.uniform(), 4);
      }
    }
  }
  build.add("twigs in front", twigs, wood(build, rng));
  build.add("leaves in front", leaves, foliage(build, rng));
}

}  // namespace dualpixel::scenes
