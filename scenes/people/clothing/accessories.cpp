#include "scenes/people/clothing/accessories.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/people/shape/primitives.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {

void add_tie(SceneModel& scene, const Figure& figure, RandomStream& rng) {
  const Frame& chest = figure.skeleton.chest;
  const float h = figure.body.stature_m;
  Material material = cloth_material(rng);
  material.scale_m = rng.uniform(0.012f, 0.04f);
  SceneObject object;
  std::vector<vec3> path;
  std::vector<float> radii;
  for (int i = 0; i <= 6; ++i) {
    const float t = static_cast<float>(i) / 6;
    path.push_back(chest.to_world({0, (0.2f - 0.17f * t) * h, (0.068f + 0.012f * std::sin(3 * t)) * h}));
    radii.push_back(i == 0 ? 0.014f : 0.02f + 0.014f * t);
  }
  add_tube(object, path, radii, 6);
  add_object(scene, figure, std::move(object), material);
}

void add_scarf(SceneModel& scene, Figure& figure, RandomStream& rng) {
  const Skeleton& k = figure.skeleton;
  const float thick = rng.uniform(0.022f, 0.04f), ring = 0.062f + 0.5f * thick;
  const vec3 center = k.neck_base + 0.02f * k.chest.axes[1] + 0.015f * k.chest.axes[2];
  const Frame frame{center, k.chest.axes};
  const auto seed = rng.seed();
  const float tail_x = rng.uniform(-0.06f, 0.06f), tail_m = rng.uniform(0.12f, 0.35f);
  const bool tail = rng.chance(0.6f);
  const auto distance = [&](vec3 p) {
    const vec3 q = frame.to_local(p);
    const float around = std::hypot(std::hypot(q.x, q.z * 1.05f) - ring, (q.y + 0.3f * q.z) * 0.7f) - thick;
    float d = around + 0.012f * (noise(seed, q * 35.0f) - 0.5f);
    if (tail) {
      const vec3 from(tail_x, -0.01f, ring), to(tail_x * 1.6f, -tail_m, ring + 0.03f);
      d = blend(d, capsule(q, from, to, thick * 0.9f, thick), 0.02f);
    }
    return d;
  };
  SceneObject object = polygonize(distance, center - vec3(0.17f, 0.42f, 0.17f), center + vec3(0.17f, 0.1f, 0.17f),
                                  std::max(figure.body_cell_m * 0.7f, 0.007f));
  for (std::size_t i = 0; i < object.positions.size(); ++i) object.rest[i] = frame.to_local(object.positions[i]);
  add_object(scene, figure, std::move(object), cloth_material(rng));
  figure.tags.emplace_back("scarf");
}

}  // namespace dualpixel::scenes
