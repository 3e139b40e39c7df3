#include <numbers>

#include "scenes/people/body/figure.h"

namespace dualpixel::scenes {
namespace {

enum class Style : std::uint8_t {
  bald,
  cropped,
  short_cap,
  parted,
  curly,
  afro,
  bob,
  long_straight,
  long_wavy,
  bun,
  ponytail,
  braids
};
constexpr const char* kStyleNames[] = {"bald", "cropped", "short", "parted", "curly",    "afro",
                                       "bob",  "long",    "wavy",  "bun",    "ponytail", "braids"};
constexpr int kStyles = 12;

/// Shape of a head of hair in the head's frame at scale 1.
struct HairShape {
  float thick_m = 0.012f;     ///< over the skull
  float top_m = 0;            ///< more of it above
  float hairline_m = 0.078f;  ///< its height over the eyes' middle
  float nape_m = -0.05f;      ///< nothing below it
  float ear_cut = 1;          ///< 1: ears are free
  float rough_m = 0.004f, rough_per_m = 60;
  float fall_m = 0;      ///< hangs down this far below the chin's height
  float fall_front = 0;  ///< 0 behind the shoulders .. 1 in front of them
  float fall_thick = 0.03f;
  float part_x = 0;
  bool bun = false, tail = false, braids = false;
  vec3 bun_at{0, 0.1f, -0.09f};
  float bun_m = 0.04f, tail_m = 0.25f;
  std::uint32_t seed = 1;

  float operator()(vec3 p) const {
    const vec3 s(std::abs(p.x), p.y, p.z);
    float d = ellipsoid(p, {0, 0.035f + 0.4f * top_m, -0.014f}, vec3(0.079f, 0.102f + 0.6f * top_m, 0.098f) + thick_m);
    d = std::max(d, nape_m - 0.15f * p.z - p.y);
    // face: everything before a slanted sheet below the hairline
    const float side = p.x - part_x;
    const float line = hairline_m - 2.2f * side * side - 0.004f * std::sin(p.x * 110);
    const float face =
        std::max(p.y - line, 0.022f + 0.25f * std::max(p.y, 0.0f) + 0.1f * ear_cut * std::max(-p.y, 0.0f) - p.z);
    d = carve(d, face, 0.012f);
    if (ear_cut > 0.5f) d = carve(d, ellipsoid(s, {0.09f, -0.012f, 0.006f}, {0.045f, 0.05f, 0.034f}), 0.012f);
    if (fall_m > 0) {
      const float front = -0.035f + 0.075f * fall_front;
      const vec3 temple(0.078f, 0.02f, -0.012f), end(0.085f + 0.012f * fall_front, -0.1f - fall_m, front);
      d = blend(d, capsule(s, temple, end, 0.018f + thick_m, fall_thick), 0.03f);
      d = blend(d, capsule(p, {0, 0.0f, -0.075f}, {0, -0.1f - fall_m, -0.085f}, 0.055f, 0.045f + fall_thick), 0.05f);
    }
    if (fall_m > 0) {  // the neck and the throat are free
      d = carve(d, capsule(p, {0, -0.07f, 0.06f}, {0, -0.5f, 0.08f}, 0.062f, 0.05f), 0.02f);
      d = carve(d, capsule(p, {0, -0.1f, 0.0f}, {0, -0.5f, 0.03f}, 0.05f, 0.075f), 0.02f);
    }
    if (bun) d = blend(d, glm::length(p - bun_at) - bun_m, 0.012f);
    if (tail) d = blend(d, capsule(p, {0, 0.07f, -0.115f}, {0.03f, 0.07f - tail_m, -0.15f}, 0.03f, 0.022f), 0.02f);
    if (braids)
      d = blend(d, capsule(s, {0.06f, -0.02f, -0.05f}, {0.095f, -0.12f - fall_thick * 4, 0.02f}, 0.02f, 0.014f), 0.02f);
    const float lumps = noise(seed, p * vec3(rough_per_m, 0.55f * rough_per_m, rough_per_m));
    const float locks = noise(seed + 1, p * rough_per_m * vec3(2.3f, 0.9f, 2.3f));
    return d - rough_m * (lumps + 0.5f * locks - 0.7f);
  }
};

/// Hair below the chin hangs from the body, not from the head; and it lies on the shoulders, not in them.
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

/// Thin ribbons that leave the surface: the soft edge of real hair.
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

SceneObject on_head(const Figure& figure, SceneObject object) {
  move_to_head(figure, object);
  return object;
}

void add_beard(SceneModel& scene, Figure& figure, RandomStream& rng) {
  const float full = rng.uniform(0.004f, 0.02f), length = rng.chance(0.3f) ? rng.uniform(0.01f, 0.06f) : 0;
  const bool whiskers = rng.chance(0.6f), chin_only = rng.chance(0.3f);
  const auto seed = rng.seed();
  const auto distance = [&](vec3 p) {
    const vec3 s(std::abs(p.x), p.y, p.z);
    float d = ellipsoid(p, {0, -0.092f - 0.4f * length, 0.06f},
                        vec3(0.024f + full, 0.022f + full + 0.6f * length, 0.022f + full));
    if (!chin_only) {
      d = blend(d, capsule(s, {0.03f, -0.085f, 0.05f}, {0.06f, -0.045f, 0.015f}, 0.012f + full, 0.008f + full), 0.02f);
      if (whiskers)
        d = blend(d, capsule(s, {0.058f, -0.05f, 0.018f}, {0.071f, 0.0f, 0.006f}, 0.009f + full, 0.006f), 0.01f);
    }
    const float lip = capsule(s, {0, -0.037f, 0.0885f}, {0.024f, -0.051f, 0.076f}, 0.005f + 0.2f * full, 0.004f);
    d = blend(d, lip, 0.004f);
    d = carve(d, ellipsoid(p, {0, -0.056f, 0.085f}, {0.022f, 0.0115f, 0.03f}), 0.006f);
    return d - 0.007f * (noise(seed, p * 110.0f) + 0.6f * noise(seed + 1, p * 260.0f) - 0.8f);
  };
  SceneObject beard =
      polygonize(distance, {-0.1f, -0.2f, -0.01f}, {0.1f, 0.02f, 0.13f}, figure.head_cell_m / figure.body.head_scale);
  move_to_head(figure, beard);
  SceneObject soft = strands(figure, beard, rng, 250, 0.02f, 0.6f, 0.0007f, 0.4f);
  Material material = figure.hair;
  material.a *= rng.uniform(0.7f, 1.3f);
  material.gloss *= 0.3f;
  add_object(scene, figure, std::move(beard), material);
  add_object(scene, figure, std::move(soft), material);
  figure.face.v[kStubble] = std::max(figure.face.v[kStubble], rng.uniform(0.6f, 1.1f));
  figure.tags.emplace_back("beard");
}

void add_glasses(SceneModel& scene, Figure& figure, RandomStream& rng) {
  const bool sun = rng.chance(0.4f);
  Material frame;
  frame.a = rng.chance(0.6f) ? vec3(0.02f) : random_color(rng);
  frame.gloss = 0.5f;
  frame.gloss_power = 60;
  const float wide = rng.uniform(0.02f, 0.026f), tall = rng.uniform(0.014f, 0.024f),
              thick = rng.uniform(0.0009f, 0.0022f);
  const float z = 0.1f, y = 0.01f, square = rng.uniform(2, 4);
  SceneObject rims, lenses;
  for (const float x : {-1.0f, 1.0f}) {
    std::vector<vec3> path;
    for (int i = 0; i <= 16; ++i) {
      const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / 16;
      const float c = std::cos(turn), s = std::sin(turn);
      const float r = 1 / std::pow(std::pow(std::abs(c), square) + std::pow(std::abs(s), square), 1 / square);
      path.emplace_back(x * 0.0315f + wide * r * c, y + tall * r * s,
                        z - 0.3f * std::abs(x * 0.0315f + wide * r * c) * 0.4f);
    }
    add_tube(rims, path, std::vector<float>(path.size(), thick), 5);
    const float outer = x * (0.0315f + wide);
    add_tube(rims,
             {{outer, y + 0.004f, z - 0.008f}, {x * 0.079f, y + 0.006f, 0.03f}, {x * 0.083f, y + 0.004f, -0.012f}},
             std::vector<float>(3, thick * 1.2f), 5);
    if (sun) add_ellipsoid(lenses, {x * 0.0315f, y, z - 0.004f}, {wide * 1.02f, tall * 1.02f, 0.002f}, mat3(1), 8);
  }
  add_tube(rims,
           {{-0.0315f + wide, y + 0.003f, z - 0.002f},
            {0, y + 0.006f, z + 0.003f},
            {0.0315f - wide, y + 0.003f, z - 0.002f}},
           std::vector<float>(3, thick), 5);
  add_object(scene, figure, on_head(figure, std::move(rims)), frame);
  if (sun) {
    Material dark;
    dark.a = glm::mix(vec3(0.015f), random_color(rng), 0.1f);
    dark.gloss = 0.8f;
    dark.gloss_power = 90;
    add_object(scene, figure, on_head(figure, std::move(lenses)), dark);
  }
  figure.tags.emplace_back(sun ? "sunglasses" : "glasses");
}

/// Returns whether hair above the hat's edge must go.
bool add_hat(SceneModel& scene, Figure& figure, RandomStream& rng, HairShape& hair) {
  constexpr const char* kNames[] = {"cap", "beanie", "brimmed hat", "hood", "headscarf", "helmet", "headphones"};
  const int kind = rng.below(7);
  figure.tags.push_back(std::string("hat:") + kNames[kind]);
  Material material = cloth_material(rng);
  const float cell = figure.head_cell_m / figure.body.head_scale;
  const auto seed = rng.seed();
  const float tilt = rng.uniform(-0.25f, 0.15f), edge = rng.uniform(0.042f, 0.066f);
  const float visor_x = 0.075f, turned = rng.chance(0.15f) ? -1.0f : 1.0f;
  const float brim = rng.uniform(0.13f, 0.2f), crown = rng.uniform(0.02f, 0.06f), loose = rng.uniform(0.012f, 0.03f);
  const auto mesh = [&](const auto& distance, vec3 low, vec3 high) {
    SceneObject object = polygonize(distance, low, high, cell * 1.2f);
    move_to_head(figure, object);
    add_object(scene, figure, std::move(object), material);
  };
  switch (kind) {
    case 0:
      mesh(
          [&](vec3 p) {
            float d = ellipsoid(p, {0, 0.045f, -0.012f}, {0.092f, 0.11f, 0.112f});
            d = std::max(d, edge + tilt * p.z - p.y);
            const vec3 q(p.x, p.y, turned * (p.z + 0.012f));
            return blend(d, ellipsoid(q, {0, edge + 0.006f, 0.125f}, {visor_x, 0.006f + 0.001f * std::abs(q.x), 0.07f}),
                         0.01f);
          },
          {-0.12f, 0.0f, -0.22f}, {0.12f, 0.18f, 0.22f});
      break;
    case 1: {
      if (rng.chance(0.7f)) material.kind = Material::Kind::knit, material.scale_m = rng.uniform(0.015f, 0.035f);
      const float pompom = rng.chance(0.3f) ? 0.035f : 0;
      mesh(
          [&](vec3 p) {
            float d = ellipsoid(p, {0, 0.045f, -0.016f}, vec3(0.084f, 0.105f + crown, 0.104f) + 0.6f * loose);
            d = std::max(d, edge - 0.012f + 0.35f * p.z - p.y);
            const float fold = std::max(ellipsoid(p, {0, 0.045f, -0.014f}, {0.099f, 0.125f, 0.119f}),
                                        std::abs(p.y - edge - 0.008f - 0.35f * p.z) - 0.022f);
            d = blend(d, fold, 0.006f);
            if (pompom > 0)
              d = std::min(d,
                           glm::length(p - vec3(0, 0.17f + crown, -0.016f)) - pompom + 0.01f * noise(seed, p * 120.0f));
            return d + 0.002f * noise(seed, p * 90.0f);
          },
          {-0.13f, -0.03f, -0.16f}, {0.13f, 0.3f, 0.14f});
      break;
    }
    case 2:
      if (rng.chance(0.5f)) material.kind = Material::Kind::heather;
      mesh(
          [&](vec3 p) {
            float d =
                std::max(ellipsoid(p, {0, 0.05f, -0.012f}, {0.093f, 0.1f + crown, 0.112f}), edge + tilt * p.z - p.y);
            const vec3 q = p - vec3(0, edge + tilt * p.z + 0.15f * p.x * p.x, -0.01f);
            const float disc = std::max(std::hypot(q.x, q.z * 0.92f) - brim, std::abs(q.y) - 0.004f);
            return blend(d, disc, 0.012f);
          },
          {-0.21f, -0.04f, -0.24f}, {0.21f, 0.24f, 0.22f});
      break;
    case 3:
    case 4: {
      const float open = kind == 3 ? rng.uniform(0.075f, 0.09f) : rng.uniform(0.064f, 0.074f);
      const float room = kind == 3 ? loose + 0.012f : 0.012f;
      SceneObject object = polygonize(
          [&](vec3 p) {
            float d = ellipsoid(p, {0, 0.025f, -0.02f}, vec3(0.082f, 0.115f, 0.105f) + room);
            d = blend(
                d,
                capsule(p, {0, -0.06f, -0.02f}, {0, -0.17f, -0.025f}, 0.075f + 0.5f * room, kind == 3 ? 0.085f : 0.11f),
                0.04f);
            d = carve(d, ellipsoid(p, {0, -0.012f, 0.1f}, {open, 0.1f + (kind == 3 ? 0.02f : 0.0f), 0.105f}), 0.01f);
            return d - 0.006f * (noise(seed, p * 28.0f) - 0.5f);
          },
          {-0.16f, -0.27f, -0.18f}, {0.16f, 0.2f, 0.13f}, cell * 1.3f);
      let_hang(figure, object);
      add_object(scene, figure, std::move(object), material);
      break;
    }
    case 5:
      material.gloss = 0.5f;
      mesh(
          [&](vec3 p) {
            float d = ellipsoid(p, {0, 0.045f, -0.014f}, {0.105f, 0.115f, 0.135f});
            return std::max(d, edge - 0.01f + 0.15f * p.z - p.y);
          },
          {-0.13f, -0.02f, -0.18f}, {0.13f, 0.19f, 0.16f});
      break;
    default: {
      Material plastic;
      plastic.a = random_color(rng);
      plastic.gloss = 0.4f;
      SceneObject object;
      std::vector<vec3> path;
      for (int i = 0; i <= 12; ++i) {
        const float turn = std::numbers::pi_v<float> * static_cast<float>(i) / 12;
        path.emplace_back(0.096f * std::cos(turn), 0.01f + (0.138f + hair.thick_m) * std::sin(turn), -0.01f);
      }
      add_tube(object, path, std::vector<float>(path.size(), 0.008f), 6);
      for (const float x : {-1.0f, 1.0f})
        add_ellipsoid(object, {0.097f * x, 0.0f, -0.008f}, {0.018f, 0.036f, 0.032f}, mat3(1), 8);
      add_object(scene, figure, on_head(figure, std::move(object)), plastic);
      return false;
    }
  }
  hair.thick_m = std::min(hair.thick_m, 0.008f);
  hair.top_m = 0;
  hair.rough_m = std::min(hair.rough_m, 0.004f);
  hair.bun = false;
  return kind == 3 || kind == 4;
}

}  // namespace

void add_hair_and_hat(SceneModel& scene, Figure& figure, RandomStream rng) {
  const Body& body = figure.body;
  const bool man = body.woman < 0.5f;
  // men wear short hair four times in five, women long hair as often
  constexpr int kShortStyles = 6;
  const bool is_short = rng.chance(man ? 0.82f : 0.16f);
  int kind = is_short ? rng.below(kShortStyles) : kShortStyles + rng.below(kStyles - kShortStyles);
  if (kind == 0 && (!man || body.child)) kind = 2;
  const auto style = static_cast<Style>(kind);
  figure.tags.push_back(std::string("hair:") + kStyleNames[kind]);
  HairShape shape;
  shape.seed = rng.seed();
  shape.thick_m = rng.uniform(0.008f, 0.022f);
  shape.hairline_m = rng.uniform(0.066f, 0.092f);
  shape.part_x = rng.uniform(-0.03f, 0.03f);
  shape.rough_m = rng.uniform(0.004f, 0.012f);
  shape.rough_per_m = rng.uniform(35, 80);
  const bool fringe = rng.chance(is_short ? 0.2f : 0.35f);
  if (fringe) shape.hairline_m = rng.uniform(0.036f, 0.055f);
  int ribbons = 500;
  float ribbon_m = 0.03f, lift = 0.25f, curl = 0.1f;
  switch (style) {
    case Style::bald:
      break;
    case Style::cropped:
      shape.thick_m = rng.uniform(0.002f, 0.005f);
      shape.rough_m = 0.001f;
      shape.hairline_m = rng.uniform(0.072f, 0.1f);
      ribbons = 150, ribbon_m = 0.008f, lift = 1;
      break;
    case Style::short_cap:
      shape.thick_m = rng.uniform(0.007f, 0.016f);
      shape.top_m = rng.uniform(0, 0.03f);
      lift = rng.uniform(0.2f, 1);
      break;
    case Style::parted:
      shape.part_x = rng.sign() * rng.uniform(0.025f, 0.045f);
      shape.top_m = rng.uniform(0.01f, 0.035f);
      break;
    case Style::curly:
      shape.thick_m = rng.uniform(0.015f, 0.035f);
      shape.top_m = rng.uniform(0, 0.03f);
      shape.rough_m = rng.uniform(0.012f, 0.022f);
      shape.rough_per_m = rng.uniform(50, 90);
      ribbons = 900, lift = 0.9f, curl = 0.8f, ribbon_m = 0.025f;
      break;
    case Style::afro:
      shape.thick_m = rng.uniform(0.035f, 0.09f);
      shape.rough_m = 0.014f;
      shape.nape_m = -0.09f;
      ribbons = 1200, lift = 2, curl = 0.9f, ribbon_m = 0.02f;
      break;
    case Style::bob:
      shape.fall_m = rng.uniform(-0.04f, 0.03f) + 0.06f;
      shape.fall_front = rng.uniform(0.3f, 0.8f);
      shape.ear_cut = 0;
      shape.nape_m = -0.15f;
      shape.fall_thick = rng.uniform(0.025f, 0.05f);
      break;
    case Style::long_straight:
    case Style::long_wavy:
      shape.fall_m = rng.uniform(0.08f, 0.32f);
      shape.fall_front = rng.uniform(0, 1);
      shape.ear_cut = rng.chance(0.4f) ? 1.0f : 0.0f;
      shape.nape_m = -0.2f;
      shape.fall_thick = rng.uniform(0.022f, 0.05f);
      if (style == Style::long_wavy)
        shape.rough_m = rng.uniform(0.014f, 0.026f), shape.rough_per_m = rng.uniform(30, 60), curl = 0.5f;
      ribbons = 900, ribbon_m = 0.06f;
      break;
    case Style::bun:
      shape.bun = true;
      shape.bun_at = rng.chance(0.5f) ? vec3(0, 0.155f, -0.05f) : vec3(0, 0.06f, -0.135f);
      shape.bun_m = rng.uniform(0.028f, 0.05f);
      break;
    case Style::ponytail:
      shape.tail = true;
      shape.tail_m = rng.uniform(0.12f, 0.35f);
      break;
    case Style::braids:
      shape.braids = true;
      shape.fall_thick = rng.uniform(0.02f, 0.05f);
      break;
  }
  const bool hat = rng.chance(0.17f);
  const bool hidden = hat && add_hat(scene, figure, rng, shape);
  if (style == Style::bald) figure.face.v[kScalpHair] = rng.uniform(0, 0.35f);
  if (style != Style::bald && !hidden) {
    const float low = -0.16f - shape.fall_m - (shape.tail ? shape.tail_m : 0) - (shape.braids ? 0.25f : 0);
    const float r = 0.14f + shape.thick_m + shape.fall_thick;
    const float cell = std::max(figure.head_cell_m * 1.25f, 0.005f) / body.head_scale;
    SceneObject hair = polygonize(shape, {-r, low, -r - 0.06f}, {r, 0.2f + shape.thick_m + shape.top_m, r}, cell);
    let_hang(figure, hair);
    const float width = 0.00075f + 0.00012f * static_cast<float>(rng.below(6));
    SceneObject soft = strands(figure, hair, rng, ribbons, ribbon_m, lift, width, curl);
    add_object(scene, figure, std::move(hair), figure.hair);
    if (figure.head_cell_m < 0.009f) add_object(scene, figure, std::move(soft), figure.hair);
  }
  if (man && !body.child && rng.chance(0.3f)) add_beard(scene, figure, rng);
  if (rng.chance(0.22f)) add_glasses(scene, figure, rng);
}

}  // namespace dualpixel::scenes
