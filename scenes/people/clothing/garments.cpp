#include "scenes/people/clothing/garments.h"

#include <algorithm>
#include <cmath>

#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {

Shape upper_garment(const Figure& figure, float room_m, float sleeves, float hem, float flare_m) {
  const Skeleton& k = figure.skeleton;
  Shape shape{torso_cones(figure, room_m)};
  for (int side = 0; side < 2 && sleeves > 0; ++side) {
    for (const Cone& cone : arm_cones(figure, side, room_m * 1.1f, sleeves)) shape.cones.push_back(cone);
  }
  const float h = figure.body.stature_m;
  shape.cut_point = k.pelvis.to_world({0, (figure.pose.sitting ? -0.03f : hem) * h, 0});
  shape.cut_normal = -k.pelvis.axes[1];
  const float hips = (0.075f + 0.008f * figure.body.woman) * h * (1 + 0.22f * figure.body.girth) + room_m;
  if (hem < 0 && !figure.pose.sitting) {
    const vec3 bottom = k.pelvis.to_world({0, hem * h, 0});
    Cone skirt{k.pelvis.origin, bottom, hips * 1.06f, hips * 1.06f + 0.012f + flare_m, 0.03f, k.pelvis.axes[2], 1.2f};
    skirt.end_normal = -k.pelvis.axes[1];
    shape.cones.push_back(skirt);
  }
  return shape;
}

std::vector<Cone> neckline(const Figure& figure, float width, float depth) {
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m;
  const vec3 top = k.chest.to_world({0, 0.26f * h, 0.02f * h}), middle = k.chest.to_world({0, 0.222f * h, 0.018f * h});
  std::vector<Cone> cuts = {{middle, top, width * 0.036f * h, width * 0.06f * h}};
  if (depth > 0) {
    const vec3 low = k.chest.to_world({0, (0.205f - 0.09f * depth) * h, 0.1f * h});
    cuts.push_back({k.chest.to_world({0, 0.215f * h, 0.06f * h}), low, width * 0.032f * h, 0.004f});
  }
  return cuts;
}

SceneObject collar(const Figure& figure, float low, float high, float room_m, float spread_m, float open) {
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m;
  const Cone neck = neck_cones(figure, 0)[0];
  const vec3 up = glm::normalize(neck.b - neck.a), forward = k.chest.axes[2];
  const vec3 base = k.neck_base + up * (low * h) + 0.006f * forward,
             top = k.neck_base + up * (high * h) + 0.006f * forward;
  const float inner = neck.radius_a + room_m;
  const auto distance = [&](vec3 p) {
    const vec3 q = p - base;
    const float along = glm::dot(q, up), length = glm::dot(top - base, up);
    const float t = std::clamp(along / length, 0.0f, 1.0f);
    const float radius = inner + spread_m * (1 - t);
    const float round = glm::length(q - up * along) - radius;
    // lower in front than at the nape
    const float tilt = 0.35f * glm::dot(q, forward);
    float d = std::max(std::abs(round) - 0.005f, std::max(-(along + tilt * 0.6f), along + tilt - length));
    if (open > 0) {
      const float wedge =
          std::abs(glm::dot(q, k.chest.axes[0])) - open * (0.012f + 0.5f * std::max(along + tilt, 0.0f));
      if (glm::dot(q, forward) > 0) d = std::max(d, -wedge);
    }
    return d;
  };
  const float r = inner + spread_m + 0.02f;
  const vec3 middle = 0.5f * (base + top);
  const float half = 0.5f * glm::distance(base, top) + 0.05f;
  SceneObject object =
      polygonize(distance, middle - vec3(r, half, r), middle + vec3(r, half, r), std::max(figure.head_cell_m, 0.005f));
  for (std::size_t i = 0; i < object.positions.size(); ++i) {
    object.rest[i] = (object.positions[i] - base) * k.chest.axes + vec3(0, 0.1f, 0);
  }
  return object;
}

}  // namespace dualpixel::scenes
