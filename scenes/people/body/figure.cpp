#include "scenes/people/body/figure.h"

#include <utility>

namespace dualpixel::scenes {
namespace {

/// What does not depend on the place.
struct PreparedCone {
  explicit PreparedCone(const Cone& cone) : ab(cone.b - cone.a) {
    ab += (cone.flat - 1) * glm::dot(ab, cone.flat_axis) * cone.flat_axis;
    length2 = std::max(glm::dot(ab, ab), 1e-9f);
  }
  vec3 ab;  ///< squeezed
  float length2;
};

float cone_distance(const Cone& cone, const PreparedCone& prepared, vec3 p) {
  vec3 pa = p - cone.a;
  pa += (cone.flat - 1) * glm::dot(pa, cone.flat_axis) * cone.flat_axis;
  const float t = std::clamp(glm::dot(pa, prepared.ab) / prepared.length2, 0.0f, 1.0f);
  const float d = glm::length(pa - t * prepared.ab) - (cone.radius_a + (cone.radius_b - cone.radius_a) * t);
  return cone.end_normal == vec3(0) ? d : std::max(d, glm::dot(p - cone.b, cone.end_normal));
}

/// A shape for many lookups: what does not depend on the place is worked out once, and cones that are too far away to
/// matter are passed over. The same numbers as Shape's.
class PreparedShape {
 public:
  explicit PreparedShape(const Shape& shape) : shape_(shape) {
    for (const Cone& cone : shape.cones) {
      const float reach = 0.5f * glm::length(cone.b - cone.a) + std::max(cone.radius_a, cone.radius_b) + cone.fillet_m;
      spheres_.push_back({0.5f * (cone.a + cone.b), reach + 1e-4f, PreparedCone(cone)});
    }
  }

  float operator()(vec3 p) const {
    float d = 10;
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      const Prepared& s = spheres_[i];
      const vec3 from = p - s.middle;
      const float matters = d + s.reach;  // a union's fillet ends where the other surface is fillet_m further away
      if (matters <= 0 || glm::dot(from, from) > matters * matters) continue;
      const Cone& cone = shape_.cones[i];
      d = blend(d, cone_distance(cone, s.cone, p), cone.fillet_m);
    }
    return shape_.cut_normal == vec3(0) ? d : std::max(d, glm::dot(p - shape_.cut_point, shape_.cut_normal));
  }

 private:
  struct Prepared {
    vec3 middle;
    float reach;
    PreparedCone cone;
  };
  const Shape& shape_;
  std::vector<Prepared> spheres_;
};

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

float Shape::operator()(vec3 p) const {
  float d = 10;
  for (const Cone& cone : cones) d = blend(d, cone_distance(cone, PreparedCone(cone), p), cone.fillet_m);
  return cut_normal == vec3(0) ? d : std::max(d, glm::dot(p - cut_point, cut_normal));
}

std::vector<Cone> torso_cones(const Figure& figure, float offset_m) {
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m, woman = figure.body.woman, girth = figure.body.girth;
  const vec3 z = k.chest.axes[2], pelvis_z = k.pelvis.axes[2];
  const float heavy = 1 + 0.22f * girth;
  std::vector<Cone> cones;
  const auto add = [&](vec3 a, vec3 b, float ra, float rb, float fillet, vec3 axis, float flat) {
    cones.push_back({a, b, ra * h + offset_m, rb * h + offset_m, fillet * h, axis, flat});
  };
  const float waist = (0.077f - 0.012f * woman) * (1 + 0.35f * girth);
  const float chest = 0.089f - 0.008f * woman;
  const float hips = 0.066f + 0.006f * woman;
  add(k.pelvis.to_world({0.035f * h, -0.015f * h, 0}), k.pelvis.to_world({-0.035f * h, -0.015f * h, 0}), hips * heavy,
      hips * heavy, 0.03f, pelvis_z, 1.15f);
  add(k.pelvis.to_world({0, 0, 0}), k.chest.to_world({0, 0.03f * h, 0}), waist * 1.1f, waist, 0.035f, z, 1.35f);
  add(k.chest.to_world({0, 0.03f * h, 0}), k.chest.to_world({0, 0.15f * h, 0}), waist * 1.05f, chest * heavy, 0.035f, z,
      1.4f);
  const float shoulder = 0.031f * (1 + 0.15f * girth) * (1 - 0.1f * woman);
  for (int side = 0; side < 2; ++side) {
    const float x = side == 0 ? 1.0f : -1.0f;
    add(k.chest.to_world({0, 0.178f * h, -0.01f * h}), k.shoulder[side], shoulder * 1.2f, shoulder, 0.04f, z, 1);
    // the slope from neck to shoulder
    add(k.neck_base + 0.022f * h * k.chest.axes[1], glm::mix(k.neck_base, k.shoulder[side], 0.75f), 0.022f, 0.02f,
        0.03f, z, 1);
    const vec3 breast = k.chest.to_world({0.043f * h * x, 0.118f * h, (0.03f + 0.016f * woman) * h});
    const float bust = 0.026f + 0.016f * woman * (1 + 0.3f * girth);
    add(breast, breast, bust, bust, 0.03f, z, 1);
  }
  if (girth > 0) {
    const vec3 belly = k.pelvis.to_world({0, 0.04f * h, (0.012f + 0.03f * girth) * h});
    add(belly, belly, 0.055f + 0.03f * girth, 0.055f + 0.03f * girth, 0.05f, z, 1);
  }
  return cones;
}

std::vector<Cone> neck_cones(const Figure& figure, float offset_m) {
  const Skeleton& k = figure.skeleton;
  const float radius = 0.056f - 0.008f * figure.body.woman + 0.008f * figure.body.girth;
  const float scale = figure.body.child ? 0.82f : 1.0f, s = figure.body.head_scale;
  const vec3 top = k.head.to_world(s * vec3(0, -0.035f, -0.018f));
  const float r = radius * scale + offset_m;
  return {{k.neck_base - 0.02f * figure.body.stature_m * k.chest.axes[1], top, r * 1.06f, r, 0.02f}};
}

std::vector<Cone> arm_cones(const Figure& figure, int side, float offset_m, float until) {
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m, scale = (1 + 0.25f * figure.body.girth) * (1 - 0.14f * figure.body.woman);
  const auto radius = [&](float share) { return share * h * scale + offset_m; };
  std::vector<Cone> cones;
  constexpr float kElbow = 0.55f, kFillet = 0.025f;
  const vec3 shoulder = k.shoulder[side], elbow = k.elbow[side], wrist = k.wrist[side];
  const float upper = std::min(until / kElbow, 1.0f);
  Cone arm{shoulder, glm::mix(shoulder, elbow, upper), radius(0.0315f), radius(0.0315f + upper * (0.0235f - 0.0315f)),
           kFillet};
  if (upper < 1) arm.end_normal = glm::normalize(elbow - shoulder);
  cones.push_back(arm);
  if (until <= kElbow) return cones;
  const float fore = std::min((until - kElbow) / (1 - kElbow), 1.0f);
  const vec3 belly = glm::mix(elbow, wrist, 0.25f);
  cones.push_back({elbow, belly, radius(0.0235f), radius(0.0265f), kFillet});
  Cone last{belly, glm::mix(elbow, wrist, std::max(fore, 0.3f)), radius(0.0265f),
            radius(0.0265f - std::max(fore, 0.3f) * 0.0105f), kFillet};
  last.end_normal = offset_m > 0 ? glm::normalize(wrist - elbow) : vec3(0);
  cones.push_back(last);
  return cones;
}

std::vector<Cone> leg_cones(const Figure& figure, int side, float offset_m, float until) {
  const Skeleton& k = figure.skeleton;
  const float h = figure.body.stature_m, scale = 1 + 0.25f * figure.body.girth;
  const auto radius = [&](float share) { return share * h * scale + offset_m; };
  constexpr float kKnee = 0.5f, kFillet = 0.03f;
  const float upper = std::min(until / kKnee, 1.0f);
  std::vector<Cone> cones;
  Cone thigh{k.hip[side], glm::mix(k.hip[side], k.knee[side], upper), radius(0.052f), radius(0.052f - 0.018f * upper),
             kFillet};
  if (upper < 1) thigh.end_normal = glm::normalize(k.knee[side] - k.hip[side]);
  cones.push_back(thigh);
  if (until <= kKnee) return cones;
  const float lower = std::min((until - kKnee) / (1 - kKnee), 1.0f);
  const vec3 calf = glm::mix(k.knee[side], k.ankle[side], 0.3f);
  cones.push_back({k.knee[side], calf, radius(0.033f), radius(0.034f), kFillet});
  Cone shin{calf, glm::mix(k.knee[side], k.ankle[side], std::max(lower, 0.35f)), radius(0.034f), radius(0.022f),
            kFillet};
  if (offset_m > 0) shin.end_normal = glm::normalize(k.ankle[side] - k.knee[side]);
  cones.push_back(shin);
  return cones;
}

float skull(vec3 p) { return ellipsoid(p, {0, 0.035f, -0.012f}, {0.077f, 0.1f, 0.096f}); }

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

void add_object(SceneModel& scene, const Figure& figure, SceneObject object, const Material& material) {
  if (object.triangles.empty()) return;
  object.person = figure.person;
  object.material = scene.add(material);
  scene.objects.push_back(std::move(object));
}

SceneObject cloth_object(const Figure& figure, const Shape& shape, float folds_m, std::uint32_t seed,
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
  add_object(scene, figure, cloth_object(figure, skin, 0, 0), figure.skin);
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
  const float s = body.head_scale;
  const float cell = figure.head_cell_m / s;
  SceneObject head = polygonize(shape, {-0.1f, -0.135f, -0.125f}, {0.1f, 0.15f, 0.125f}, cell);
  move_to_head(figure, head);
  add_object(scene, figure, std::move(head), figure.face);
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

Figure pose_figure(RandomStream rng, const FigureOptions& options) {
  Figure figure;
  RandomStream body_rng = rng.substream(1), pose_rng = rng.substream(2);
  figure.body = make_body(body_rng);
  figure.pose = make_pose(pose_rng, figure.body, options.gesture);
  figure.pose.head_yaw = std::clamp(figure.pose.head_yaw + options.head_yaw, -1.25f, 1.25f);
  figure.skeleton = make_skeleton(figure.body, figure.pose, options.place, options.yaw, proportions_of(figure.body));
  figure.person = options.person;
  figure.head_cell_m = std::clamp(1.1f * options.meters_per_px, 0.0038f, 0.014f);
  figure.body_cell_m = std::clamp(2.4f * options.meters_per_px, 0.009f, 0.024f);
  figure.lowest_m = options.lowest_m;
  return figure;
}

Figure add_figure(SceneModel& scene, RandomStream rng, const FigureOptions& options) {
  Figure figure = pose_figure(rng, options);
  RandomStream material_rng = rng.substream(3);
  if (figure.body.child) figure.tags.emplace_back("child");

  Material& skin = figure.skin;
  skin.kind = Material::Kind::skin;
  skin.a = skin_color(material_rng);
  skin.seed = material_rng.seed();
  skin.softness = material_rng.uniform(0.15f, 0.45f);
  skin.gloss = material_rng.uniform(0.05f, 0.3f);
  skin.gloss_power = material_rng.uniform(8, 30);
  Material& hair = figure.hair;
  hair.kind = Material::Kind::hair;
  const float pallor = skin.a.y;
  hair.a = hair_color(material_rng, figure.body.old);
  if (pallor < 0.15f && !figure.body.old && material_rng.chance(0.9f))
    hair.a = vec3(0.012f, 0.01f, 0.009f) * material_rng.uniform(0.5f, 2.5f);
  hair.b = hair.a * material_rng.uniform(1.0f, 2.2f);
  hair.seed = material_rng.seed();
  hair.gloss = material_rng.uniform(0.03f, 0.3f);
  hair.gloss_power = material_rng.uniform(5, 20);
  hair.softness = 0.2f;
  Material& face = figure.face;
  face = skin;
  face.kind = Material::Kind::face;
  const bool made_up = figure.body.woman > 0.5f && material_rng.chance(0.5f);
  face.b = skin.a * vec3(0.86f, 0.52f, 0.53f);
  if (made_up)
    face.b =
        glm::mix(face.b, vec3(0.4f, 0.04f, 0.07f) * material_rng.uniform(0.6f, 1.4f), material_rng.uniform(0.3f, 1));
  face.c = figure.body.old ? glm::mix(hair.a, vec3(0.2f), 0.5f) : glm::min(hair.a, vec3(0.12f));
  face.v[kStubble] =
      figure.body.woman < 0.5f && !figure.body.child && material_rng.chance(0.6f) ? material_rng.uniform(0, 0.7f) : 0;
  face.v[kBrowThickness] = 1.05f - 0.3f * figure.body.woman + 0.25f * material_rng.normal();
  face.v[kMouthOpen] = material_rng.chance(0.35f) ? material_rng.uniform(0.35f, 1) : material_rng.uniform(0, 0.25f);
  face.v[kBlush] = material_rng.uniform(0.2f, 1);
  face.v[kEyeLine] = made_up ? material_rng.uniform(0.3f, 1) : material_rng.uniform(0, 0.3f);
  face.v[kScalpHair] = 0.6f;

  add_body(scene, figure);
  add_clothes(scene, figure, rng.substream(5));
  add_hair_and_hat(scene, figure, rng.substream(6));
  add_head(scene, figure, rng.substream(7));
  add_held_thing(scene, figure, rng.substream(8));
  if (figure.pose.sitting) add_seat(scene, figure, rng.substream(9));
  return figure;
}

}  // namespace dualpixel::scenes
