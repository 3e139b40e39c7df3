#include "scenes/people/environment/foreground.h"

#include <algorithm>

#include "scenes/people/environment/plants.h"

namespace dualpixel::scenes {

void add_foreground(SceneModel& scene, RandomStream rng, vec3 camera, float top_m) {
  EnvironmentBuilder build(scene, rng);
  const float between = rng.uniform(0.25f, 0.6f);
  const vec3 at = camera * between;
  switch (rng.below(4)) {
    case 0: {  // the near edge of a table
      const float y = top_m - rng.uniform(0.02f, 0.12f);
      build.box({at.x, y - 0.02f, 0.35f + at.z * 0.5f}, {2.5f, 0.02f, std::max(at.z * 0.5f - 0.1f, 0.1f)},
                wall_material(rng));
      for (int i = 0; i < 3; ++i) {
        const vec3 half = rng.uniform3(0.02f, 0.06f);
        build.box({at.x + rng.uniform(-0.4f, 0.4f), y + half.y, 0.35f + at.z * rng.uniform(0.2f, 0.6f)}, half,
                  cloth_material(rng), rng.uniform(-1, 1));
      }
      break;
    }
    case 1:  // leaves from one side or below
      add_leaves(build.object(leaves_material(rng)), rng,
                 {at.x + rng.sign() * rng.uniform(0.15f, 0.4f), top_m - rng.uniform(0.0f, 0.2f), at.z}, vec3(0.18f), 40,
                 0.09f);
      break;
    case 2: {  // rail
      const float y = top_m - rng.uniform(0.0f, 0.15f);
      const Material metal = plain_material(random_color(rng), 0.3f);
      add_tube(build.object(metal), {{at.x - 3, y, at.z}, {at.x + 3, y, at.z}}, {0.02f, 0.02f}, 6);
      for (int i = -6; i < 7; ++i) {
        const float x = at.x + 0.14f * static_cast<float>(i);
        add_tube(build.object(metal), {{x, 0, at.z}, {x, y, at.z}}, {0.007f, 0.007f}, 5);
      }
      break;
    }
    default:  // a shoulder, a cushion, the back of a dog
      add_ellipsoid(build.object(cloth_material(rng)),
                    {at.x + rng.sign() * rng.uniform(0.15f, 0.4f), top_m - rng.uniform(0.12f, 0.3f), at.z},
                    vec3(0.17f, 0.14f, 0.1f), mat3(1), 12);
  }
}

}  // namespace dualpixel::scenes
