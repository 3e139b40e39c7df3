#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {
namespace {

enum class Top : std::uint8_t { t_shirt, shirt, jumper, tank, blazer, coat, hoodie, dress, turtleneck, swimwear };
constexpr const char* kTopNames[] = {"t-shirt", "shirt",  "jumper", "tank top",   "blazer",
                                     "coat",    "hoodie", "dress",  "turtleneck", "bare shoulders"};

/// A garment for the upper body: torso and sleeves with room, down to the height `hem` (share of stature, about the
/// pelvis; negative is lower), flaring by `flare` there.
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

/// What the neckline leaves open: a round or pointed cut below the neck.
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

/// A band around the neck: collar, turtleneck, hood at rest.
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

void add_lower(SceneModel& scene, Figure& figure, RandomStream& rng) {
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
  add_object(scene, figure, cloth_object(figure, shape, kFolds_m, rng.seed()), material);
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

}  // namespace

void add_clothes(SceneModel& scene, Figure& figure, RandomStream rng) {
  const float woman = figure.body.woman;
  constexpr int kTops = 10;
  int choice = rng.below(kTops - 1);
  if (woman < 0.5f && choice == static_cast<int>(Top::dress)) choice = static_cast<int>(Top::shirt);
  if (rng.chance(0.03f)) choice = static_cast<int>(Top::swimwear);
  const auto top = static_cast<Top>(choice);
  figure.tags.push_back(std::string("top:") + kTopNames[choice]);
  Material material = cloth_material(rng);
  const float folds = rng.uniform(0.006f, 0.024f);
  const bool closed_in_front = top == Top::shirt || top == Top::coat || top == Top::hoodie || top == Top::blazer;
  if (closed_in_front && rng.chance(0.7f)) material.v[kPlacket] = rng.uniform(0.2f, 1);
  const auto seed = rng.seed();
  const float hem = rng.uniform(-0.11f, -0.03f);
  const float short_sleeve = rng.uniform(0.28f, 0.5f), long_sleeve = rng.chance(0.25f) ? rng.uniform(0.6f, 0.9f) : 1.0f;
  const auto layer = [&](float room, float sleeves, float layer_hem, float flare, const std::vector<Cone>& cuts,
                         const Material& cloth) {
    figure.top_cloth_m = std::max(figure.top_cloth_m, 1.1f * room + folds);
    add_object(scene, figure,
               cloth_object(figure, upper_garment(figure, room, sleeves, layer_hem, flare), folds, seed, cuts), cloth);
  };
  switch (top) {
    case Top::t_shirt:
      layer(rng.uniform(0.009f, 0.03f), short_sleeve, hem, rng.uniform(0, 0.03f),
            neckline(figure, rng.uniform(1.0f, 1.35f), rng.chance(0.25f) ? rng.uniform(0.3f, 0.9f) : 0), material);
      break;
    case Top::shirt: {
      layer(rng.uniform(0.01f, 0.024f), rng.chance(0.3f) ? short_sleeve : long_sleeve, hem, 0.01f,
            neckline(figure, 1.05f, rng.uniform(0.1f, 0.6f)), material);
      add_object(scene, figure, collar(figure, -0.008f, 0.026f, 0.008f, 0.022f, 1), material);
      if (rng.chance(0.25f)) add_tie(scene, figure, rng);
      break;
    }
    case Top::jumper: {
      if (rng.chance(0.6f)) material.kind = Material::Kind::knit, material.scale_m = rng.uniform(0.015f, 0.04f);
      layer(rng.uniform(0.016f, 0.04f), long_sleeve, hem, 0,
            neckline(figure, 1.1f, rng.chance(0.3f) ? rng.uniform(0.3f, 0.9f) : 0), material);
      add_object(scene, figure, collar(figure, -0.012f, 0.008f, 0.008f, 0.016f, 0), material);
      break;
    }
    case Top::tank:
      layer(rng.uniform(0.007f, 0.014f), 0.02f, hem, 0, neckline(figure, rng.uniform(1.3f, 1.8f), rng.uniform(0, 0.8f)),
            material);
      break;
    case Top::blazer:
    case Top::coat: {
      // a shirt or jumper beneath an open front
      layer(0.009f, 0.1f, -0.02f, 0, neckline(figure, 1.05f, rng.chance(0.5f) ? 0.4f : 0), cloth_material(rng));
      if (rng.chance(0.7f)) {
        Material shirt = cloth_material(rng);
        add_object(scene, figure, collar(figure, -0.008f, 0.026f, 0.007f, 0.016f, 1), shirt);
        if (rng.chance(0.4f)) add_tie(scene, figure, rng);
      }
      const float room = top == Top::coat ? rng.uniform(0.03f, 0.05f) : rng.uniform(0.02f, 0.03f);
      std::vector<Cone> cuts = neckline(figure, 1.45f, 0.3f);
      const Frame& chest = figure.skeleton.chest;
      const float h = figure.body.stature_m, open = rng.uniform(0.3f, 1);
      cuts.push_back({chest.to_world({0, 0.21f * h, 0.1f * h}), chest.to_world({0, -0.09f * h, 0.13f * h}),
                      0.052f * h * open, 0.022f * h * open});
      layer(room, 1, top == Top::coat ? rng.uniform(-0.26f, -0.1f) : -0.07f,
            top == Top::coat ? rng.uniform(0, 0.1f) : 0.01f, cuts, material);
      if (rng.chance(0.75f))
        add_object(scene, figure, collar(figure, -0.016f, rng.uniform(0.012f, 0.035f), 0.018f, 0.03f, 2.2f), material);
      break;
    }
    case Top::hoodie: {
      layer(rng.uniform(0.02f, 0.045f), 1, hem, 0, neckline(figure, 1.15f, 0), material);
      if (rng.chance(0.7f)) {
        add_object(scene, figure,
                   collar(figure, -0.02f, rng.uniform(0.02f, 0.04f), 0.014f, 0.035f, rng.uniform(0.5f, 2.5f)),
                   material);
      }
      break;
    }
    case Top::dress:
      layer(rng.uniform(0.007f, 0.016f), rng.chance(0.5f) ? 0.02f : short_sleeve, rng.uniform(-0.42f, -0.2f),
            rng.uniform(0.03f, 0.2f), neckline(figure, rng.uniform(1.1f, 1.8f), rng.uniform(0, 1)), material);
      break;
    case Top::turtleneck:
      layer(rng.uniform(0.01f, 0.022f), long_sleeve, hem, 0, neckline(figure, 0.9f, 0), material);
      add_object(scene, figure, collar(figure, -0.015f, rng.uniform(0.025f, 0.045f), 0.007f, 0.014f, 0), material);
      break;
    case Top::swimwear: {
      const Skeleton& k = figure.skeleton;
      const float h = figure.body.stature_m;
      Shape shape{torso_cones(figure, 0.006f)};
      // nothing above the breast
      const std::vector<Cone> cuts = {{k.chest.to_world({0.2f * h, 0.3f * h, 0}),
                                       k.chest.to_world({-0.2f * h, 0.3f * h, 0}), 0.145f * h, 0.145f * h}};
      if (woman > 0.5f) add_object(scene, figure, cloth_object(figure, shape, folds * 0.5f, seed, cuts), material);
      break;
    }
  }
  if (top != Top::dress) add_lower(scene, figure, rng);
  if (rng.chance(0.08f)) add_scarf(scene, figure, rng);
}

}  // namespace dualpixel::scenes
