#include "scenes/people/body/seat.h"

#include <utility>

#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {

void add_seat(SceneModel& scene, const Figure& figure, RandomStream rng) {
  const Frame& pelvis = figure.skeleton.pelvis;
  const float h = figure.body.stature_m, half_width = rng.uniform(0.2f, 0.7f);
  const float top = pelvis.origin.y - (0.07f + 0.012f * figure.body.girth) * h, back = rng.uniform(0.0f, 0.7f);
  SceneObject seat;
  add_box(seat, pelvis.to_world({0, 0, 0.03f * h}) - vec3(0, pelvis.origin.y - top + 0.04f, 0), pelvis.axes,
          {half_width, 0.04f, 0.25f});
  if (rng.chance(0.5f))
    add_box(seat, vec3(pelvis.origin.x, 0.5f * top, pelvis.origin.z), pelvis.axes,
            {0.8f * half_width, 0.5f * top, 0.2f});
  if (rng.chance(0.7f))
    add_box(seat, pelvis.to_world({0, 0.5f * back, -0.14f * h - 0.05f}), pelvis.axes,
            {half_width, 0.5f * back + 0.05f, 0.03f});
  seat.material = scene.add(cloth_material(rng));
  scene.objects.push_back(std::move(seat));
}

}  // namespace dualpixel::scenes
