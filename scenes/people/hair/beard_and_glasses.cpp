#include "scenes/people/hair/beard_and_glasses.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenes/people/body/head.h"
#include "scenes/people/hair/strands.h"
#include "scenes/people/shape/primitives.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

SceneObject on_head(const Figure& figure, SceneObject object) {
  move_to_head(figure, object);
  return object;
}

}  // namespace

void add_beard(SceneModel& scene, Figure& figure, RandomStream& rng) {
  const float full = rng.uniform(0.004f, 0.02f), length = rng.chance(0.3f) ? rng.uniform(0.01f, 0.06f) : 0;
  const bool whiskers = rng.chance(0.6f), chin_only = rng.chance(0.3f);
  const auto seed = rng.seed();
  const auto distance = [&](vec3 p) {
    const vec3 s(std::abs(p.x), p.y, p.z);
    float d = ellipsoid(p, {0, -0.092f - 0.4f * length, 0.06f},
                        vec3(0.024f + full, 0.022f + full + 0.6f * length, 0.022f + full));
    if (!chin_only) {
      d = blend(d, capsule(s, {0.03f, -0.085f, 0.05f}, {0.06f, -0.045f, 0.015f}, 0.012f + full, 0.008f + full), 0.02f);
      if (whiskers)
        d = blend(d, capsule(s, {0.058f, -0.05f, 0.018f}, {0.071f, 0.0f, 0.006f}, 0.009f + full, 0.006f), 0.01f);
    }
    const float lip = capsule(s, {0, -0.037f, 0.0885f}, {0.024f, -0.051f, 0.076f}, 0.005f + 0.2f * full, 0.004f);
    d = blend(d, lip, 0.004f);
    d = carve(d, ellipsoid(p, {0, -0.056f, 0.085f}, {0.022f, 0.0115f, 0.03f}), 0.006f);
    return d - 0.007f * (noise(seed, p * 110.0f) + 0.6f * noise(seed + 1, p * 260.0f) - 0.8f);
  };
  SceneObject beard =
      polygonize(distance, {-0.1f, -0.2f, -0.01f}, {0.1f, 0.02f, 0.13f}, figure.head_cell_m / figure.body.head_scale);
  move_to_head(figure, beard);
  beard.hair_m = 0.012f;
  SceneObject soft = strands(figure, beard, rng, 250, 0.02f, 0.6f, 0.0007f, 0.4f);
  Material material = figure.hair;
  material.a *= rng.uniform(0.7f, 1.3f);
  material.gloss *= 0.3f;
  add_object(scene, figure, std::move(beard), material);
  add_object(scene, figure, std::move(soft), material);
  figure.face.v[kStubble] = std::max(figure.face.v[kStubble], rng.uniform(0.6f, 1.1f));
  figure.tags.emplace_back("beard");
}

void add_glasses(SceneModel& scene, Figure& figure, RandomStream& rng) {
  const bool sun = rng.chance(0.4f);
  Material frame;
  frame.a = rng.chance(0.6f) ? vec3(0.02f) : random_color(rng);
  frame.gloss = 0.5f;
  frame.gloss_power = 60;
  const float wide = rng.uniform(0.02f, 0.026f), tall = rng.uniform(0.014f, 0.024f),
              thick = rng.uniform(0.0009f, 0.0022f);
  const float z = 0.1f, y = 0.01f, square = rng.uniform(2, 4);
  SceneObject rims, lenses;
  for (const float x : {-1.0f, 1.0f}) {
    std::vector<vec3> path;
    for (int i = 0; i <= 16; ++i) {
      const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / 16;
      const float c = std::cos(turn), s = std::sin(turn);
      const float r = 1 / std::pow(std::pow(std::abs(c), square) + std::pow(std::abs(s), square), 1 / square);
      path.emplace_back(x * 0.0315f + wide * r * c, y + tall * r * s,
                        z - 0.3f * std::abs(x * 0.0315f + wide * r * c) * 0.4f);
    }
    add_tube(rims, path, std::vector<float>(path.size(), thick), 5);
    const float outer = x * (0.0315f + wide);
    add_tube(rims,
             {{outer, y + 0.004f, z - 0.008f}, {x * 0.079f, y + 0.006f, 0.03f}, {x * 0.083f, y + 0.004f, -0.012f}},
             std::vector<float>(3, thick * 1.2f), 5);
    if (sun) add_ellipsoid(lenses, {x * 0.0315f, y, z - 0.004f}, {wide * 1.02f, tall * 1.02f, 0.002f}, mat3(1), 8);
  }
  add_tube(rims,
           {{-0.0315f + wide, y + 0.003f, z - 0.002f},
            {0, y + 0.006f, z + 0.003f},
            {0.0315f - wide, y + 0.003f, z - 0.002f}},
           std::vector<float>(3, thick), 5);
  add_object(scene, figure, on_head(figure, std::move(rims)), frame);
  if (sun) {
    Material dark;
    dark.a = glm::mix(vec3(0.015f), random_color(rng), 0.1f);
    dark.gloss = 0.8f;
    dark.gloss_power = 90;
    add_object(scene, figure, on_head(figure, std::move(lenses)), dark);
  }
  figure.tags.emplace_back(sun ? "sunglasses" : "glasses");
}

}  // namespace dualpixel::scenes
