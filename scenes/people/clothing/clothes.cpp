#include "scenes/people/clothing/clothes.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "scenes/people/body/body_cones.h"
#include "scenes/people/body/body_mesh.h"
#include "scenes/people/clothing/accessories.h"
#include "scenes/people/clothing/garments.h"
#include "scenes/people/clothing/trousers.h"

namespace dualpixel::scenes {
namespace {

/// A garment for the upper body: what all kinds are drawn with.
struct Top {
  SceneModel& scene;
  Figure& figure;
  Material material;
  float folds;
  std::uint32_t seed;
  float hem;                        ///< height over the pelvis as a fraction of stature
  float short_sleeve, long_sleeve;  ///< as fractions of the arm

  /// One layer of cloth with the cones `cuts` cut out.
  void add_layer(float room, float sleeves, float layer_hem, float flare, const std::vector<Cone>& cuts,
                 const Material& cloth) {
    figure.top_cloth_m = std::max(figure.top_cloth_m, 1.1f * room + folds);
    add_object(scene, figure,
               mesh_on_body(figure, upper_garment(figure, room, sleeves, layer_hem, flare), folds, seed, cuts), cloth);
  }
};

void add_t_shirt(Top& top, RandomStream& rng) {
  top.add_layer(rng.uniform(0.009f, 0.03f), top.short_sleeve, top.hem, rng.uniform(0, 0.03f),
                neckline(top.figure, rng.uniform(1.0f, 1.35f), rng.chance(0.25f) ? rng.uniform(0.3f, 0.9f) : 0),
                top.material);
}

void add_shirt(Top& top, RandomStream& rng) {
  top.add_layer(rng.uniform(0.01f, 0.024f), rng.chance(0.3f) ? top.short_sleeve : top.long_sleeve, top.hem, 0.01f,
                neckline(top.figure, 1.05f, rng.uniform(0.1f, 0.6f)), top.material);
  add_object(top.scene, top.figure, collar(top.figure, -0.008f, 0.026f, 0.008f, 0.022f, 1), top.material);
  if (rng.chance(0.25f)) add_tie(top.scene, top.figure, rng);
}

void add_sweater(Top& top, RandomStream& rng) {
  if (rng.chance(0.6f)) top.material.kind = Material::Kind::knit, top.material.scale_m = rng.uniform(0.015f, 0.04f);
  top.add_layer(rng.uniform(0.016f, 0.04f), top.long_sleeve, top.hem, 0,
                neckline(top.figure, 1.1f, rng.chance(0.3f) ? rng.uniform(0.3f, 0.9f) : 0), top.material);
  add_object(top.scene, top.figure, collar(top.figure, -0.012f, 0.008f, 0.008f, 0.016f, 0), top.material);
}

void add_tank_top(Top& top, RandomStream& rng) {
  top.add_layer(rng.uniform(0.007f, 0.014f), 0.02f, top.hem, 0,
                neckline(top.figure, rng.uniform(1.3f, 1.8f), rng.uniform(0, 0.8f)), top.material);
}

/// A blazer or a coat, open over a shirt or sweater.
void add_jacket(Top& top, RandomStream& rng, bool is_coat) {
  top.add_layer(0.009f, 0.1f, -0.02f, 0, neckline(top.figure, 1.05f, rng.chance(0.5f) ? 0.4f : 0), cloth_material(rng));
  if (rng.chance(0.7f)) {
    Material shirt = cloth_material(rng);
    add_object(top.scene, top.figure, collar(top.figure, -0.008f, 0.026f, 0.007f, 0.016f, 1), shirt);
    if (rng.chance(0.4f)) add_tie(top.scene, top.figure, rng);
  }
  const float room = is_coat ? rng.uniform(0.03f, 0.05f) : rng.uniform(0.02f, 0.03f);
  std::vector<Cone> cuts = neckline(top.figure, 1.45f, 0.3f);
  const Frame& chest = top.figure.skeleton.chest;
  const float h = top.figure.body.stature_m, open = rng.uniform(0.3f, 1);
  cuts.push_back({chest.to_world({0, 0.21f * h, 0.1f * h}), chest.to_world({0, -0.09f * h, 0.13f * h}),
                  0.052f * h * open, 0.022f * h * open});
  top.add_layer(room, 1, is_coat ? rng.uniform(-0.26f, -0.1f) : -0.07f, is_coat ? rng.uniform(0, 0.1f) : 0.01f, cuts,
                top.material);
  if (rng.chance(0.75f))
    add_object(top.scene, top.figure, collar(top.figure, -0.016f, rng.uniform(0.012f, 0.035f), 0.018f, 0.03f, 2.2f),
               top.material);
}

void add_hoodie(Top& top, RandomStream& rng) {
  top.add_layer(rng.uniform(0.02f, 0.045f), 1, top.hem, 0, neckline(top.figure, 1.15f, 0), top.material);
  if (rng.chance(0.7f)) {
    add_object(top.scene, top.figure,
               collar(top.figure, -0.02f, rng.uniform(0.02f, 0.04f), 0.014f, 0.035f, rng.uniform(0.5f, 2.5f)),
               top.material);
  }
}

void add_dress(Top& top, RandomStream& rng) {
  top.add_layer(rng.uniform(0.007f, 0.016f), rng.chance(0.5f) ? 0.02f : top.short_sleeve, rng.uniform(-0.42f, -0.2f),
                rng.uniform(0.03f, 0.2f), neckline(top.figure, rng.uniform(1.1f, 1.8f), rng.uniform(0, 1)),
                top.material);
}

void add_turtleneck(Top& top, RandomStream& rng) {
  top.add_layer(rng.uniform(0.01f, 0.022f), top.long_sleeve, top.hem, 0, neckline(top.figure, 0.9f, 0), top.material);
  add_object(top.scene, top.figure, collar(top.figure, -0.015f, rng.uniform(0.025f, 0.045f), 0.007f, 0.014f, 0),
             top.material);
}

void add_swimwear(Top& top, RandomStream&) {
  const Skeleton& k = top.figure.skeleton;
  const float h = top.figure.body.stature_m;
  Shape shape{torso_cones(top.figure, 0.006f)};
  // nothing above the breast
  const std::vector<Cone> cuts = {
      {k.chest.to_world({0.2f * h, 0.3f * h, 0}), k.chest.to_world({-0.2f * h, 0.3f * h, 0}), 0.145f * h, 0.145f * h}};
  if (top.figure.body.woman > 0.5f)
    add_object(top.scene, top.figure, mesh_on_body(top.figure, shape, top.folds * 0.5f, top.seed, cuts), top.material);
}

void add_blazer(Top& top, RandomStream& rng) { add_jacket(top, rng, false); }

void add_coat(Top& top, RandomStream& rng) { add_jacket(top, rng, true); }

enum { kTShirt, kShirt, kSweater, kTankTop, kBlazer, kCoat, kHoodie, kDress, kTurtleneck, kSwimwear, kTops };

/// In the order of the names above; tags say "top:NAME".
constexpr struct {
  const char* name;
  void (*add)(Top& top, RandomStream& rng);
} kTopTable[] = {{"t-shirt", add_t_shirt},        {"shirt", add_shirt},   {"jumper", add_sweater},
                 {"tank top", add_tank_top},      {"blazer", add_blazer}, {"coat", add_coat},
                 {"hoodie", add_hoodie},          {"dress", add_dress},   {"turtleneck", add_turtleneck},
                 {"bare shoulders", add_swimwear}};
static_assert(std::size(kTopTable) == kTops);

Top draw_top(SceneModel& scene, Figure& figure, int kind, RandomStream& rng) {
  Top top{scene, figure, cloth_material(rng), rng.uniform(0.006f, 0.024f), 0, 0, 0, 0};
  const bool closed_in_front = kind == kShirt || kind == kCoat || kind == kHoodie || kind == kBlazer;
  if (closed_in_front && rng.chance(0.7f)) top.material.v[kPlacket] = rng.uniform(0.2f, 1);
  top.seed = rng.seed();
  top.hem = rng.uniform(-0.11f, -0.03f);
  top.short_sleeve = rng.uniform(0.28f, 0.5f);
  top.long_sleeve = rng.chance(0.25f) ? rng.uniform(0.6f, 0.9f) : 1.0f;
  return top;
}

}  // namespace

void add_clothes(SceneModel& scene, Figure& figure, RandomStream rng) {
  int choice = rng.below(kTops - 1);
  if (figure.body.woman < 0.5f && choice == kDress) choice = kShirt;
  if (rng.chance(0.03f)) choice = kSwimwear;
  const auto& [name, add] = kTopTable[choice];
  figure.tags.push_back(std::string("top:") + name);
  Top top = draw_top(scene, figure, choice, rng);
  add(top, rng);
  if (choice != kDress) add_trousers(scene, figure, rng);
  if (rng.chance(0.08f)) add_scarf(scene, figure, rng);
}

}  // namespace dualpixel::scenes
