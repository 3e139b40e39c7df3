#include "scenes/people/hair/hats.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>

#include "scenes/people/body/head.h"
#include "scenes/people/hair/strands.h"
#include "scenes/people/shape/primitives.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

/// What all kinds of hats are drawn with.
struct Hat {
  Material material;
  std::uint32_t seed = 0;
  float tilt = 0, edge = 0;  ///< of the rim
  float turned = 1;          ///< -1: the visor is at the back
  float brim = 0, crown = 0, loose = 0;
};

Hat draw_hat(RandomStream& rng) {
  Hat hat;
  hat.material = cloth_material(rng);
  hat.seed = rng.seed();
  hat.tilt = rng.uniform(-0.25f, 0.15f), hat.edge = rng.uniform(0.042f, 0.066f);
  hat.turned = rng.chance(0.15f) ? -1.0f : 1.0f;
  hat.brim = rng.uniform(0.13f, 0.2f), hat.crown = rng.uniform(0.02f, 0.06f), hat.loose = rng.uniform(0.012f, 0.03f);
  return hat;
}

float hat_cell_m(const Figure& figure) { return figure.head_cell_m / figure.body.head_scale; }

template <typename Distance>
void add_on_head(SceneModel& scene, const Figure& figure, const Hat& hat, const Distance& distance, vec3 low,
                 vec3 high) {
  SceneObject object = polygonize(distance, low, high, hat_cell_m(figure) * 1.2f);
  move_to_head(figure, object);
  add_object(scene, figure, std::move(object), hat.material);
}

void add_cap(SceneModel& scene, const Figure& figure, const Hat& hat) {
  add_on_head(scene, figure, hat,
              [&](vec3 p) {
                float d = ellipsoid(p, {0, 0.045f, -0.012f}, {0.092f, 0.11f, 0.112f});
                d = std::max(d, hat.edge + hat.tilt * p.z - p.y);
                constexpr float kVisor_m = 0.075f;
                const vec3 q(p.x, p.y, hat.turned * (p.z + 0.012f));
                return blend(
                    d, ellipsoid(q, {0, hat.edge + 0.006f, 0.125f}, {kVisor_m, 0.006f + 0.001f * std::abs(q.x), 0.07f}),
                    0.01f);
              },
              {-0.12f, 0.0f, -0.22f}, {0.12f, 0.18f, 0.22f});
}

void add_beanie(SceneModel& scene, const Figure& figure, Hat& hat, RandomStream& rng) {
  if (rng.chance(0.7f)) hat.material.kind = Material::Kind::knit, hat.material.scale_m = rng.uniform(0.015f, 0.035f);
  const float pompom = rng.chance(0.3f) ? 0.035f : 0;
  add_on_head(
      scene, figure, hat,
      [&](vec3 p) {
        float d = ellipsoid(p, {0, 0.045f, -0.016f}, vec3(0.084f, 0.105f + hat.crown, 0.104f) + 0.6f * hat.loose);
        d = std::max(d, hat.edge - 0.012f + 0.35f * p.z - p.y);
        const float fold = std::max(ellipsoid(p, {0, 0.045f, -0.014f}, {0.099f, 0.125f, 0.119f}),
                                    std::abs(p.y - hat.edge - 0.008f - 0.35f * p.z) - 0.022f);
        d = blend(d, fold, 0.006f);
        if (pompom > 0)
          d = std::min(
              d, glm::length(p - vec3(0, 0.17f + hat.crown, -0.016f)) - pompom + 0.01f * noise(hat.seed, p * 120.0f));
        return d + 0.002f * noise(hat.seed, p * 90.0f);
      },
      {-0.13f, -0.03f, -0.16f}, {0.13f, 0.3f, 0.14f});
}

void add_brimmed_hat(SceneModel& scene, const Figure& figure, Hat& hat, RandomStream& rng) {
  if (rng.chance(0.5f)) hat.material.kind = Material::Kind::heather;
  add_on_head(scene, figure, hat,
              [&](vec3 p) {
                float d = std::max(ellipsoid(p, {0, 0.05f, -0.012f}, {0.093f, 0.1f + hat.crown, 0.112f}),
                                   hat.edge + hat.tilt * p.z - p.y);
                const vec3 q = p - vec3(0, hat.edge + hat.tilt * p.z + 0.15f * p.x * p.x, -0.01f);
                const float disc = std::max(std::hypot(q.x, q.z * 0.92f) - hat.brim, std::abs(q.y) - 0.004f);
                return blend(d, disc, 0.012f);
              },
              {-0.21f, -0.04f, -0.24f}, {0.21f, 0.24f, 0.22f});
}

/// A hood, or a headscarf, which is tighter.
void add_hood(SceneModel& scene, const Figure& figure, const Hat& hat, bool is_hood, RandomStream& rng) {
  const float open = is_hood ? rng.uniform(0.075f, 0.09f) : rng.uniform(0.064f, 0.074f);
  const float room = is_hood ? hat.loose + 0.012f : 0.012f;
  SceneObject object = polygonize(
      [&](vec3 p) {
        float d = ellipsoid(p, {0, 0.025f, -0.02f}, vec3(0.082f, 0.115f, 0.105f) + room);
        d = blend(d,
                  capsule(p, {0, -0.06f, -0.02f}, {0, -0.17f, -0.025f}, 0.075f + 0.5f * room, is_hood ? 0.085f : 0.11f),
                  0.04f);
        d = carve(d, ellipsoid(p, {0, -0.012f, 0.1f}, {open, 0.1f + (is_hood ? 0.02f : 0.0f), 0.105f}), 0.01f);
        return d - 0.006f * (noise(hat.seed, p * 28.0f) - 0.5f);
      },
      {-0.16f, -0.27f, -0.18f}, {0.16f, 0.2f, 0.13f}, hat_cell_m(figure) * 1.3f);
  let_hang(figure, object);
  add_object(scene, figure, std::move(object), hat.material);
}

void add_helmet(SceneModel& scene, const Figure& figure, Hat& hat) {
  hat.material.gloss = 0.5f;
  add_on_head(scene, figure, hat,
              [&](vec3 p) {
                float d = ellipsoid(p, {0, 0.045f, -0.014f}, {0.105f, 0.115f, 0.135f});
                return std::max(d, hat.edge - 0.01f + 0.15f * p.z - p.y);
              },
              {-0.13f, -0.02f, -0.18f}, {0.13f, 0.19f, 0.16f});
}

void add_headphones(SceneModel& scene, const Figure& figure, const HairShape& hair, RandomStream& rng) {
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
  move_to_head(figure, object);
  add_object(scene, figure, std::move(object), plastic);
}

}  // namespace

bool add_hat(SceneModel& scene, Figure& figure, RandomStream& rng, HairShape& hair) {
  enum { kCap, kBeanie, kBrimmedHat, kHood, kHeadscarf, kHelmet, kHeadphones, kKinds };
  constexpr const char* kNames[] = {"cap", "beanie", "brimmed hat", "hood", "headscarf", "helmet", "headphones"};
  static_assert(std::size(kNames) == kKinds);
  const int kind = rng.below(kKinds);
  figure.tags.push_back(std::string("hat:") + kNames[kind]);
  Hat hat = draw_hat(rng);
  switch (kind) {
    case kCap:
      add_cap(scene, figure, hat);
      break;
    case kBeanie:
      add_beanie(scene, figure, hat, rng);
      break;
    case kBrimmedHat:
      add_brimmed_hat(scene, figure, hat, rng);
      break;
    case kHood:
    case kHeadscarf:
      add_hood(scene, figure, hat, kind == kHood, rng);
      break;
    case kHelmet:
      add_helmet(scene, figure, hat);
      break;
    default:
      add_headphones(scene, figure, hair, rng);
      return false;
  }
  hair.thick_m = std::min(hair.thick_m, 0.008f);
  hair.top_m = 0;
  hair.rough_m = std::min(hair.rough_m, 0.004f);
  hair.bun = false;
  return kind == kHood || kind == kHeadscarf;
}

}  // namespace dualpixel::scenes
