#include "scenes/people/body/head.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {
namespace {

HeadShape draw_head_shape(const Body& body, RandomStream& rng) {
  HeadShape shape;
  const float child = body.child ? 1.0f : 0.0f;
  shape.jaw = 1.03f - 0.08f * body.woman + 0.05f * body.girth + 0.04f * rng.normal();
  shape.cheeks = 1 + 0.12f * child + 0.08f * body.girth + 0.06f * rng.normal();
  shape.nose = (1 - 0.12f * body.woman - 0.15f * child) * (1.05f + 0.14f * rng.normal());
  shape.nose_length = (1 - 0.2f * child) * (1 + 0.12f * rng.normal());
  shape.lips = 1 + 0.2f * body.woman + 0.2f * rng.normal();
  shape.brow = 1.03f - 0.06f * body.woman + 0.06f * rng.normal();
  shape.chin = 1 - 0.06f * body.woman - 0.1f * child + 0.08f * rng.normal();
  shape.long_face = 1 + 0.05f * rng.normal() - 0.08f * child;
  shape.lids = std::clamp(1 + 0.3f * rng.normal(), 0.2f, 2.5f);
  shape.ears = 1 + 0.1f * rng.normal();
  return shape;
}

void add_eyes(SceneModel& scene, const Figure& figure, RandomStream& rng) {
  Material eye;
  eye.kind = Material::Kind::eye;
  constexpr vec3 kIris[] = {
      {0.05f, 0.025f, 0.012f}, {0.1f, 0.055f, 0.025f}, {0.12f, 0.18f, 0.26f}, {0.12f, 0.16f, 0.09f}};
  eye.a = kIris[std::min(rng.below(7), 3)] * rng.uniform(0.7f, 1.4f);
  eye.seed = rng.seed();
  eye.gloss = 0.4f;
  eye.gloss_power = 200;
  SceneObject eyes;
  const vec3 gaze(0.18f * rng.normal() - 0.6f * figure.pose.head_yaw, -0.06f + 0.1f * rng.normal(), 1);
  for (const float x : {-1.0f, 1.0f}) {
    add_ellipsoid(eyes, vec3(0.031f * x, 0.0148f, 0.0715f), vec3(0.0121f),
                  axes_along({0, 1, 0.05f}, gaze + vec3(-0.03f * x, 0, 0)), 10);
  }
  move_to_head(figure, eyes);
  add_object(scene, figure, std::move(eyes), eye);
}

}  // namespace

float HeadShape::operator()(vec3 p) const {
  p.y = p.y < 0 ? p.y / long_face : p.y;
  const vec3 s(std::abs(p.x), p.y, p.z);  // the face is symmetric, near enough
  float d = skull(p);
  d = blend(d, ellipsoid(p, {0, -0.045f, 0.02f}, {0.056f * jaw, 0.062f, 0.066f}), 0.05f);
  if (p.z < -0.02f) {  // behind the ears
    return blend(d, capsule(p, {0, -0.05f, -0.02f}, {0, -0.11f, -0.025f}, 0.05f, 0.052f), 0.03f);
  }
  d = blend(d, ellipsoid(s, {0.04f, -0.018f, 0.056f}, vec3(0.027f, 0.025f, 0.024f) * cheeks), 0.03f);
  d = blend(d, ellipsoid(s, {0.024f, 0.036f, 0.077f}, vec3(0.027f, 0.008f, 0.013f) * brow), 0.02f);
  d = carve(d, ellipsoid(s, {0.031f, 0.016f, 0.098f}, {0.020f, 0.013f, 0.02f}), 0.016f);
  const float eye = glm::length(s - vec3(0.031f, 0.0148f, 0.0715f)) - 0.0134f;
  const float upper_lid = std::max(eye, 0.0034f * lids - (p.y - 0.0148f)),
              lower_lid = std::max(eye, p.y - 0.0148f + 0.0046f * lids);
  d = blend(d, std::min(upper_lid, lower_lid), 0.004f);
  const vec3 tip(0, -0.018f * nose_length, 0.09f + 0.008f * nose);
  d = blend(d, capsule(p, {0, 0.022f, 0.078f}, tip, 0.0075f, 0.0105f * nose), 0.012f);
  d = blend(d, ellipsoid(s, {0.0115f * nose, tip.y - 0.0055f, 0.088f}, {0.0085f * nose, 0.007f, 0.0095f}), 0.006f);
  d = blend(d, ellipsoid(p, {0, -0.0485f, 0.078f}, {0.023f, 0.0058f * lips, 0.0105f}), 0.006f);
  d = blend(d, ellipsoid(p, {0, -0.0605f, 0.077f}, {0.020f, 0.0066f * lips, 0.0105f}), 0.006f);
  d = carve(d, ellipsoid(p, {0, -0.0545f, 0.0905f}, {0.022f, 0.0011f, 0.006f}), 0.002f);
  d = blend(d, ellipsoid(p, {0, -0.088f, 0.063f}, vec3(0.022f, 0.017f, 0.018f) * chin), 0.02f);
  const float ear = carve(ellipsoid(s, {0.081f, 0.002f, -0.008f}, vec3(0.009f, 0.031f, 0.019f) * ears),
                          ellipsoid(s, {0.091f, 0.004f, -0.002f}, {0.007f, 0.021f, 0.011f}), 0.005f);
  return blend(d, ear, 0.008f);
}

void move_to_head(const Figure& figure, SceneObject& object) {
  const Frame& head = figure.skeleton.head;
  for (vec3& p : object.positions) p = head.to_world(figure.body.head_scale * p);
  for (vec3& n : object.normals) n = head.axes * n;
}

void add_head(SceneModel& scene, Figure& figure, RandomStream rng) {
  const Body& body = figure.body;
  const auto on_head = [&](vec3 p) { return figure.skeleton.head.to_world(body.head_scale * p); };
  figure.face_points = {on_head({0, -0.018f, 0.1f}), on_head({0.031f, 0.0148f, 0.083f}),
                        on_head({-0.031f, 0.0148f, 0.083f}), on_head({0.084f, 0.002f, -0.008f}),
                        on_head({-0.084f, 0.002f, -0.008f})};
  for (const vec3& p : {vec3(0, 0.045f, 0.088f), vec3(0, -0.104f, 0.07f), vec3(0.062f, 0, 0.05f),
                        vec3(-0.062f, 0, 0.05f), vec3(0.05f, -0.06f, 0.04f), vec3(-0.05f, -0.06f, 0.04f)}) {
    figure.face_outline.push_back(on_head(p));
  }
  const HeadShape shape = draw_head_shape(body, rng);
  const float s = body.head_scale;
  const float cell = figure.head_cell_m / s;
  SceneObject head = polygonize(shape, {-0.1f, -0.135f, -0.125f}, {0.1f, 0.15f, 0.125f}, cell);
  move_to_head(figure, head);
  add_object(scene, figure, std::move(head), figure.face);
  add_eyes(scene, figure, rng);
}

}  // namespace dualpixel::scenes
