#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/places/places.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

void add_roadway(SceneBuilder& build, RandomStream rng, float half_road, float half_street, float farthest) {
  Mesh road, pavements, curbs, markings;
  road.add_quad({-half_road, 0, 6}, {2 * half_road, 0, 0}, {0, 0, -farthest - 6}, {2 * half_road, farthest + 6});
  for (const float side : {-1.0f, 1.0f}) {
    const float middle = side * 0.5f * (half_road + half_street);
    add_solid_box(pavements, {middle, 0.03f, 3 - 0.5f * farthest},
                  {0.5f * (half_street - half_road), 0.06f, 0.5f * farthest + 3});
    add_solid_box(curbs, {side * half_road, 0.035f, 3 - 0.5f * farthest}, {0.08f, 0.06f, 0.5f * farthest + 3}, 0.01f);
  }
  const int dashes = static_cast<int>(farthest / 4);
  for (int i = 0; i < dashes; ++i)
    add_solid_box(markings, {0, 0.002f, 2 - 4 * static_cast<float>(i)}, {0.06f, 0.002f, 0.9f});
  const vec3 slab = vec3(0.33f, 0.32f, 0.3f) * rng.uniform(0.7f, 1.2f);
  const bool setts = rng.chance(0.35f);
  build.add("road", road,
            setts ? tile_surface(rng.substream(1), slab * 0.6f, slab * 0.25f, {0.15f, 0.1f}, 0.25f)
                  : rough_surface(rng.substream(1), vec3(0.09f), 0.22f, 1.1f, 1.1f));
  build.add("pavement", pavements,
            tile_surface(rng.substream(2), slab, slab * 0.45f, {rng.uniform(0.2f, 0.6f), 0.3f}, 0.12f));
  build.add("curb", curbs, rough_surface(rng.substream(3), slab * 0.9f, 0.15f, 0.6f));
  if (!setts) build.add("markings", markings, rough_surface(rng.substream(4), vec3(0.55f), 0.15f, 0.6f));
}

void add_houses(SceneBuilder& build, RandomStream rng, float half_street, float farthest, bool lit) {
  constexpr int kKinds = 4;
  int house[kKinds];
  float wide[kKinds];
  for (int i = 0; i < kKinds; ++i) {
    wide[i] = rng.uniform(5, 11);
    house[i] = build_house(build, rng.substream(i), wide[i], rng.uniform(6, 15), lit);
  }
  for (const float side : {-1.0f, 1.0f}) {
    float z = 5;
    while (z > -farthest) {
      const int kind = rng.below(kKinds);
      const float setback = rng.chance(0.3f) ? rng.uniform(0, 0.8f) : 0;
      build.place("house", house[kind],
                  standing({side * (half_street + setback), 0, z - 0.5f * wide[kind]}, -side * 1.5707963f));
      z -= wide[kind] + (rng.chance(0.15f) ? rng.uniform(1, 4) : 0.0f);
    }
  }
  build.place("house", house[rng.below(kKinds)], glm::scale(standing({0, 0, -farthest}, 0), vec3(2.5f, 1.2f, 1)));
}

}  // namespace

void lay_street(SceneBuilder& build, RandomStream rng, const PlaceOptions& options) {
  const float half_road = rng.uniform(2, 3.5f), half_street = half_road + rng.uniform(2, 4),
              farthest = 0.9f * options.farthest_m;
  const float shift = rng.uniform(-0.7f, 0.7f) * half_street;  // of the camera from the street's middle
  add_roadway(build, rng.substream(1), half_road, half_street, farthest);
  add_houses(build, rng.substream(2), half_street, farthest, lamp_nits(options.light) > 0);
  RandomStream at = rng.substream(3);
  const Planting planting = grow_planting(build, rng.substream(4), 1);
  for (int i = 0; i < options.trees; ++i) {
    const float z = options.nearest_m + 4 +
                    55 * (static_cast<float>(i) + at.uniform()) / static_cast<float>(std::max(options.trees, 1));
    plant(build, at, "tree", planting.trees[0], {at.sign() * (half_road + 0.6f), 0.06f, -z}, 0.8f);
  }
  const float nits = lamp_nits(options.light);
  for (int i = 0; i < options.lamps; ++i) {
    const float z = options.nearest_m + 3 + 9 * static_cast<float>(i), side = i % 2 == 0 ? 1.0f : -1.0f;
    add_lamp_post(build, rng.substream(20 + i), {side * (half_road + 0.35f), 0.06f, -z}, nits);
  }
  const float kerb = half_road + 0.3f;
  for (const float side : {-1.0f, 1.0f}) {
    const float from = -options.nearest_m - at.uniform(0.5f, 4), to = from - at.uniform(5, 25);
    const vec3 a(side * kerb, 0.09f, from), b(side * kerb, 0.09f, to);
    if (at.chance(0.5f)) {
      add_bollards(build, rng.substream(side > 0 ? 50 : 51), a, b, at.uniform(1, 2.4f));
    } else if (at.chance(0.5f)) {
      add_railing(build, rng.substream(side > 0 ? 52 : 53), a, b);
    }
    const int extras = 1 + at.below(4);
    for (int i = 0; i < extras; ++i) {
      const vec3 spot(side * (half_street - at.uniform(0.4f, 1)), 0.09f, -options.nearest_m - at.uniform(1, 18));
      RandomStream own = rng.substream(60 + i + (side > 0 ? 0 : 10));
      const int kind = own.below(4);
      if (kind == 0) add_bench(build, own, standing(spot, -side * 1.5708f));
      if (kind == 1) add_sign(build, own, {side * (half_road + 0.5f), 0.09f, spot.z});
      if (kind >= 2) plant(build, own, "shrub", planting.shrubs[0], spot, 0.8f);
    }
  }
  build.eye = {shift, 0, 0};
}

}  // namespace dualpixel::scenes
