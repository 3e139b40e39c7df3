#include "scenes/people/clothing/trousers.h"

#include <algorithm>
#include <utility>

#include "scenes/people/body/body_cones.h"
#include "scenes/people/body/body_mesh.h"
#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {

void add_trousers(SceneModel& scene, Figure& figure, RandomStream& rng) {
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m;
  if (std::max(k.hip[0].y, k.knee[0].y) + 0.15f * h < figure.lowest_m) return;
  const bool skirt = figure.body.woman > 0.5f && !figure.pose.sitting && rng.chance(0.35f);
  const float room = rng.uniform(0.006f, 0.018f);
  Shape shape;
  const vec3 z = k.pelvis.axes[2];
  const float hips = (0.066f + 0.006f * figure.body.woman) * h * (1 + 0.22f * figure.body.girth) + room;
  shape.cones.push_back({k.pelvis.to_world({0.035f * h, -0.015f * h, 0}),
                         k.pelvis.to_world({-0.035f * h, -0.015f * h, 0}), hips, hips, 0.03f * h, z, 1.15f});
  shape.cones.push_back({k.pelvis.origin, k.pelvis.to_world({0, 0.06f * h, 0}), hips,
                         0.075f * h * (1 + 0.3f * figure.body.girth), 0.03f, z, 1.3f});
  const float until = skirt ? 0 : rng.chance(0.25f) ? rng.uniform(0.3f, 0.55f) : 1;
  if (skirt) {
    const float length = rng.uniform(0.2f, 0.45f);
    Cone cone{k.pelvis.origin,
              k.pelvis.to_world({0, -length * h, 0}),
              hips,
              hips + rng.uniform(0.02f, 0.16f),
              0.03f,
              z,
              1.15f};
    cone.end_normal = -k.pelvis.axes[1];
    shape.cones.push_back(cone);
  }
  for (int side = 0; side < 2 && !skirt; ++side) {
    for (const Cone& cone : leg_cones(figure, side, room, until)) shape.cones.push_back(cone);
  }
  Material material = cloth_material(rng);
  if (rng.chance(0.35f)) {
    material.kind = Material::Kind::denim;
    material.a = vec3(0.02f, 0.035f, 0.07f) * rng.uniform(0.5f, 2);
    material.b = vec3(0.15f, 0.22f, 0.33f) * rng.uniform(0.5f, 1.5f);
  }
  constexpr float kFolds_m = 0.012f;
  figure.legs_cloth_m = room + kFolds_m;
  add_object(scene, figure, mesh_on_body(figure, shape, kFolds_m, rng.seed()), material);
  SceneObject shoes;
  for (int side = 0; side < 2; ++side) {
    const vec3 along = k.toe[side] - k.ankle[side];
    add_ellipsoid(shoes, k.ankle[side] + 0.35f * along - vec3(0, 0.012f * h, 0), h * vec3(0.028f, 0.082f, 0.028f),
                  axes_along(along, {0, 1, 0}), 8);
  }
  if (k.ankle[0].y + 0.1f > figure.lowest_m) {
    Material leather;
    leather.a = random_color(rng);
    leather.gloss = 0.3f;
    add_object(scene, figure, std::move(shoes), leather);
  }
}

}  // namespace dualpixel::scenes
