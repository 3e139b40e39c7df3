#include "scenes/people/hair/strands.h"

#include <algorithm>
#include <cmath>

#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {

void let_hang(const Figure& figure, SceneObject& object) {
  const Frame& head = figure.skeleton.head;
  const float s = figure.body.head_scale;
  const vec3 forward = glm::normalize(vec3(head.axes[2].x, 0, head.axes[2].z) * 0.5f + figure.skeleton.chest.axes[2]);
  const Frame hanging{head.origin, axes_along({0, 1, 0}, forward)};
  for (vec3& p : object.positions) {
    const float t = std::clamp((-0.03f - p.y) / 0.1f, 0.0f, 1.0f);
    p = glm::mix(head.to_world(s * p), hanging.to_world(s * p), t);
    for (int step = 0; step < 2 && t > 0.5f; ++step) {
      const float room = 0.028f - figure.bare(p);
      if (room <= 0) break;
      const float e = 0.01f;
      vec3 gradient(figure.bare(p + vec3(e, 0, 0)) - figure.bare(p - vec3(e, 0, 0)),
                    0.3f * (figure.bare(p + vec3(0, e, 0)) - figure.bare(p - vec3(0, e, 0))),
                    figure.bare(p + vec3(0, 0, e)) - figure.bare(p - vec3(0, 0, e)));
      // what hangs behind goes to the back, not through the neck
      const float ahead = glm::dot(p - head.origin, hanging.axes[2]) / s, push = glm::dot(gradient, hanging.axes[2]);
      if (ahead < 0.0f && push > 0) gradient -= 2 * push * hanging.axes[2];
      if (glm::length(gradient) > 0) p += std::min(room, 0.06f) * glm::normalize(gradient);
    }
  }
  smooth_normals(object);
}

SceneObject strands(const Figure& figure, const SceneObject& hair, RandomStream& rng, int count, float length_m,
                    float lift, float width_m, float curl) {
  SceneObject out;
  if (hair.triangles.empty()) return out;
  const vec3 middle = figure.skeleton.head.origin;
  for (int i = 0; i < count; ++i) {
    const glm::uvec3& t = hair.triangles[static_cast<std::size_t>(rng.below(static_cast<int>(hair.triangles.size())))];
    const vec3 n = hair.normals[t.x];
    vec3 p = hair.positions[t.x] - 0.003f * n;
    const vec3 random = rng.uniform3(-1, 1);
    const vec3 down = vec3(0, -1, 0) - n * glm::dot(vec3(0, -1, 0), n);
    vec3 direction = glm::normalize(down + lift * n + 0.5f * random + 0.02f * glm::normalize(p - middle));
    const float length = length_m * rng.uniform(0.3f, 1.2f);
    const float width = width_m * rng.uniform(0.5f, 1.3f);
    constexpr int kSteps = 4;
    const auto first = static_cast<unsigned>(out.positions.size());
    const vec3 bend = curl * rng.uniform3(-1, 1) + vec3(0, -0.15f, 0);
    for (int k = 0; k <= kSteps; ++k) {
      const vec3 side = glm::cross(direction, n) + 0.001f;
      const vec3 across = glm::normalize(side) * width * (1 - 0.85f * static_cast<float>(k) / kSteps);
      for (const vec3& q : {p - across, p + across}) {
        out.positions.push_back(q);
        out.normals.push_back(n);
        out.rest.push_back(hair.rest[t.x] + 0.02f * random);
      }
      if (k > 0) {
        const unsigned a = first + 2 * static_cast<unsigned>(k - 1);
        out.triangles.emplace_back(a, a + 1, a + 3);
        out.triangles.emplace_back(a, a + 3, a + 2);
      }
      p += direction * (length / kSteps);
      direction = glm::normalize(direction + bend + 0.25f * rng.uniform3(-1, 1));
    }
  }
  return out;
}

}  // namespace dualpixel::scenes
