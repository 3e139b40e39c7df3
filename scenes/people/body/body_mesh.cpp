#include "scenes/people/body/body_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/people/body/body_cones.h"
#include "scenes/people/shape/primitives.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

vec3 mirrored(vec3 p, float x) { return {x * p.x, p.y, p.z}; }

/// A right hand in its own frame: palm at the origin facing +z, fingers along +y, thumb towards +x.
float hand_shape(vec3 p, float curl) {
  float d = ellipsoid(p, {0, -0.005f, 0}, {0.038f, 0.046f, 0.015f});
  constexpr float kLength[4] = {0.033f, 0.038f, 0.036f, 0.027f};
  for (int finger = 0; finger < 4; ++finger) {
    const float x = 0.029f - 0.0195f * static_cast<float>(finger), length = kLength[finger];
    const float bend = 1.5f * curl, more = 2.9f * curl;
    const vec3 knuckle(x, 0.036f, 0);
    const vec3 middle = knuckle + length * vec3(0.1f * x / 0.03f, std::cos(bend), std::sin(bend));
    const vec3 tip = middle + 0.95f * length * vec3(0, std::cos(more), std::sin(more));
    d = blend(d, capsule(p, knuckle, middle, 0.0095f, 0.0085f), 0.006f);
    d = blend(d, capsule(p, middle, tip, 0.0085f, 0.007f), 0.003f);
  }
  const vec3 thumb(0.055f - 0.01f * curl, 0.012f, 0.014f + 0.012f * curl);
  d = blend(d, capsule(p, {0.027f, -0.02f, 0.004f}, thumb, 0.013f, 0.0105f), 0.01f);
  d = blend(d, capsule(p, thumb, thumb + vec3(0.004f - 0.025f * curl, 0.03f, 0.004f), 0.0105f, 0.0085f), 0.004f);
  return blend(d, capsule(p, {0, -0.035f, 0}, {0, -0.075f, 0}, 0.026f, 0.024f), 0.02f);
}

}  // namespace

SceneObject mesh_on_body(const Figure& figure, const Shape& shape, float folds_m, std::uint32_t seed,
                         const std::vector<Cone>& carved, float carve_fillet_m) {
  vec3 low(1e9f), high(-1e9f);
  for (const Cone& cone : shape.cones) {
    const float r = std::max(cone.radius_a, cone.radius_b) + 0.02f;
    low = glm::min(low, glm::min(cone.a, cone.b) - r);
    high = glm::max(high, glm::max(cone.a, cone.b) + r);
  }
  low.y = std::max(low.y, figure.lowest_m - 0.03f);
  if (low.y >= high.y) return {};
  const PreparedShape prepared(shape);
  std::vector<std::pair<Cone, PreparedCone>> carved_cones;
  for (const Cone& cone : carved) carved_cones.emplace_back(cone, PreparedCone(cone));
  SceneObject object = polygonize(
      [&](vec3 p) {
        float d = prepared(p);
        for (const auto& cone : carved_cones) d = carve(d, cone_distance(cone.first, cone.second, p), carve_fillet_m);
        return d;
      },
      low, high, figure.body_cell_m);
  const float chest_m = 0.72f * figure.body.stature_m;
  for (std::size_t i = 0; i < object.positions.size(); ++i) {
    vec3 rest = figure.skeleton.rest_position_of(object.positions[i]);
    rest.y -= chest_m;
    object.rest[i] = rest;
    if (folds_m <= 0) continue;
    const vec3 bent = rest + 0.06f * noise(seed + 1, rest * 9.0f);
    const float fold = fractal(seed, bent * vec3(15, 9, 13), 2) - 0.45f;
    const float crease = std::abs(noise(seed + 2, bent * vec3(11, 17, 11)) - 0.5f);  // sharp at its bottom
    object.positions[i] += object.normals[i] * (folds_m * (fold + crease - 0.15f));
  }
  if (folds_m > 0) smooth_normals(object);
  return object;
}

void add_body(SceneModel& scene, Figure& figure) {
  const Skeleton& k = figure.skeleton;
  figure.bare.cones = torso_cones(figure, 0);
  for (const Cone& cone : neck_cones(figure, 0)) figure.bare.cones.push_back(cone);
  Shape skin = figure.bare;
  for (int side = 0; side < 2; ++side) {
    for (const Cone& cone : arm_cones(figure, side, 0)) skin.cones.push_back(cone);
    if (k.knee[side].y < figure.lowest_m - 0.1f && k.hip[side].y < figure.lowest_m - 0.1f) continue;
    for (const Cone& cone : leg_cones(figure, side, 0)) skin.cones.push_back(cone);
  }
  add_object(scene, figure, mesh_on_body(figure, skin, 0, 0), figure.skin);
  const float hand_scale = 0.108f * figure.body.stature_m / 0.184f * (1 - 0.06f * figure.body.woman);
  for (int side = 0; side < 2; ++side) {
    const Frame& hand = k.hand[side];
    if (hand.origin.y < figure.lowest_m - 0.15f) continue;
    const float curl = figure.pose.arm[side].curl;
    const float mirror = side == 0 ? -1.0f : 1.0f;  // of hand_shape, a right hand
    const float cell = std::max(figure.head_cell_m / hand_scale, 0.004f);
    SceneObject object = polygonize([&](vec3 p) { return hand_shape(mirrored(p, mirror), curl); },
                                    {-0.09f, -0.1f, -0.04f}, {0.09f, 0.13f, 0.09f}, cell);
    for (vec3& p : object.positions) p = hand.to_world(hand_scale * p);
    for (vec3& n : object.normals) n = hand.axes * n;
    add_object(scene, figure, std::move(object), figure.skin);
  }
}

}  // namespace dualpixel::scenes
