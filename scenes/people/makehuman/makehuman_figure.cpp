#include "scenes/people/makehuman/makehuman_figure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/error.h"
#include "scenes/people/body/body_cones.h"
#include "scenes/people/body/seat.h"
#include "scenes/people/hair/hair.h"
#include "scenes/people/held/held_things.h"
#include "scenes/people/makehuman/dressing.h"
#include "scenes/people/makehuman/morph.h"
#include "scenes/people/makehuman/pick.h"

namespace dualpixel::scenes {
namespace {

/// Distance between the eyes of a head of scale 1.
constexpr float kEyes_m = 0.062f;

Proportions proportions_of(const MorphedBody& morphed, const RestFrames& rest, float stature_m) {
  Proportions p;
  p.pelvis_m = rest.pelvis.y;
  p.sitting_pelvis_m = 0.28f * stature_m;
  p.chest = rest.chest - rest.pelvis;
  p.neck_base = rest.neck - rest.chest;
  p.neck = rest.head - rest.neck;
  p.shoulder = morphed.joint(0, "shoulder") - rest.chest;
  p.hip = morphed.joint(0, "upper-leg") - rest.pelvis;
  p.upper_arm_m = glm::distance(morphed.joint(0, "shoulder"), morphed.joint(0, "elbow"));
  p.fore_arm_m = glm::distance(morphed.joint(0, "elbow"), morphed.joint(0, "hand"));
  p.thigh_m = glm::distance(morphed.joint(0, "upper-leg"), morphed.joint(0, "knee"));
  p.shank_m = glm::distance(morphed.joint(0, "knee"), morphed.joint(0, "ankle"));
  return p;
}

/// Face keypoints: the eyes are joints; nose and ears are the outermost vertices of the head.
void set_face_points(Figure& figure, const MorphedBody& morphed, const RestFrames& rest, const PartMotion& head) {
  const float s = figure.body.head_scale;
  const vec3 left_eye = morphed.joint("l-eye"), right_eye = morphed.joint("r-eye");
  vec3 nose(0, 0, -1);
  std::array<vec3, 2> ear{left_eye, right_eye};
  for (const int v : morphed.base->body.vertex) {
    const vec3 p = morphed.rest[static_cast<std::size_t>(v)], q = (p - rest.head) / s;
    if (std::abs(q.x) < 0.01f && q.y > -0.05f && q.y < 0.005f && p.z > nose.z) nose = p;
    if (q.y > -0.03f && q.y < 0.03f && q.z < 0.03f && q.z > -0.05f) {
      if (p.x > ear[0].x) ear[0] = p;
      if (p.x < ear[1].x) ear[1] = p;
    }
  }
  const vec3 cornea(0, 0, 0.012f * s);
  figure.face_points = {head.moved(nose), head.moved(left_eye + cornea), head.moved(right_eye + cornea),
                        head.moved(ear[0]), head.moved(ear[1])};
  const vec3 chin = morphed.joint("jaw");
  for (const vec3& p : {rest.head + s * vec3(0, 0.045f, 0.088f), chin, rest.head + s * vec3(0.062f, 0, 0.05f),
                        rest.head + s * vec3(-0.062f, 0, 0.05f)}) {
    figure.face_outline.push_back(head.moved(p));
  }
}

/// Colors of hair and skin; `skin`: the texture, if there is one.
void draw_materials(Figure& figure, const Morph& morph, RandomStream& rng) {
  constexpr int kCaucasian = 2;
  Material& hair = figure.hair;
  hair.kind = Material::Kind::hair;
  hair.a = hair_color(rng, figure.body.old);
  if (morph.origin != kCaucasian && !figure.body.old && rng.chance(0.8f))
    hair.a = vec3(0.012f, 0.01f, 0.009f) * rng.uniform(0.5f, 2.5f);
  hair.b = hair.a * rng.uniform(1.0f, 2.2f);
  hair.seed = rng.seed();
  hair.gloss = rng.uniform(0.03f, 0.2f);
  hair.gloss_power = rng.uniform(5, 20);
  figure.skin.kind = Material::Kind::skin;
  figure.skin.a = skin_color(rng);
  figure.skin.softness = rng.uniform(0.15f, 0.45f);
  figure.skin.gloss = rng.uniform(0.05f, 0.25f);
  figure.skin.gloss_power = rng.uniform(8, 30);
  figure.face = figure.skin;
  if (!morph.skin) return;
  figure.skin.kind = Material::Kind::textured;
  figure.skin.texture = morph.skin->texture;
  figure.skin.a = vec3(rng.uniform(0.7f, 1.25f)) * (1.0f + 0.06f * vec3(rng.normal(), rng.normal(), rng.normal()));
}

/// A fitted suit or shell clothes, shoes, and the body where they do not cover it.
void add_clothed_body(Dressing& dressing, const MakeHumanAssets& assets, bool textured_skin, RandomStream rng) {
  Figure& figure = dressing.figure;
  const bool man = figure.body.woman < 0.5f;
  if (!assets.clothes.empty() && rng.chance(0.5f)) {
    const FittedAsset& suit = *pick(
        rng, assets.clothes, [](const FittedAsset& one) { return is_for_women(one.name) ? 1 : 0; }, man ? 0 : 1);
    Material material = tinted(suit, random_color(rng), false);
    if (suit.texture && rng.chance(0.5f)) material.a = vec3(rng.uniform(0.6f, 1.3f));
    if (!suit.texture) material = cloth_material(rng);
    add_fitted(dressing, suit, material);
    dressing.hidden = suit.hides;
    figure.tags.push_back("top:" + suit.name);
  } else {
    add_shell_clothes(dressing, rng);
    figure.tags.emplace_back("top:shell");
  }
  if (!assets.shoes.empty() && figure.skeleton.ankle[0].y > figure.lowest_m) {
    const FittedAsset& shoes = *pick(rng, assets.shoes);
    add_fitted(dressing, shoes, tinted(shoes, random_color(rng), false));
  }
  add_object(dressing.scene, figure,
             mesh_object(dressing.morphed.base->body, dressing.posed, dressing.morphed.rest, textured_skin,
                         dressing.hidden, figure.lowest_m - 0.05f),
             figure.skin);
}

void add_eyes_brows_and_lashes(Dressing& dressing, const MakeHumanAssets& assets, RandomStream& rng) {
  if (const FittedAsset* eye = pick(rng, assets.eyes)) {
    Material material;
    material.a = vec3(0.9f);
    material.gloss = 0.4f;
    material.gloss_power = 200;
    if (!assets.irises.empty()) {
      material.kind = Material::Kind::textured;
      material.texture = *pick(rng, assets.irises);
      material.iris = true;
    }
    add_fitted(dressing, *eye, material);
  }
  if (const FittedAsset* brow = pick(rng, assets.brows))
    add_fitted(dressing, *brow, tinted(*brow, glm::min(dressing.figure.hair.a, vec3(0.15f)), true));
  if (const FittedAsset* lash = pick(rng, assets.lashes)) add_fitted(dressing, *lash, tinted(*lash, vec3(0.02f), true));
}

/// Fitted hair, at times with a hat. Returns whether there is any.
bool add_fitted_hair(Dressing& dressing, const MakeHumanAssets& assets, RandomStream& rng) {
  Figure& figure = dressing.figure;
  const bool man = figure.body.woman < 0.5f;
  const FittedAsset* cut = pick(rng, assets.hair);
  if (!(cut && rng.chance(0.55f) && (!man || cut->name.rfind("short", 0) == 0 || rng.chance(0.15f)))) return false;
  Material material = tinted(*cut, figure.hair.a, true);
  material.gloss = figure.hair.gloss;
  material.gloss_power = figure.hair.gloss_power;
  add_fitted(dressing, *cut, material);
  figure.tags.push_back("hair:" + cut->name);
  if (!rng.chance(0.12f)) return true;
  if (const FittedAsset* hat = pick(rng, assets.hats)) {
    add_fitted(dressing, *hat, cloth_material(rng), 0.004f);
    figure.tags.push_back("hat:" + hat->name);
  }
  return true;
}

/// Procedural hair, as large as the skull under it.
void add_procedural_hair(Dressing& dressing, vec3 rest_head, RandomStream rng) {
  Figure& figure = dressing.figure;
  const float s = figure.body.head_scale;
  vec3 reach(0);
  for (const int v : dressing.morphed.base->body.vertex) {
    const vec3 q = dressing.morphed.rest[static_cast<std::size_t>(v)] - rest_head;
    if (q.y < 0.03f * s) continue;
    reach = glm::max(reach, vec3(std::abs(q.x) / 0.078f, q.y / 0.136f, -q.z / 0.109f));
  }
  // bounded, whatever a morph made of the skull
  figure.body.head_scale = std::clamp(std::max({reach.x, reach.y, reach.z}), 0.7f * s, 1.5f * s);
  add_hair_and_hat(dressing.scene, figure, rng);
  figure.body.head_scale = s;
}

}  // namespace

Figure add_makehuman_figure(SceneModel& scene, const MakeHumanAssets& assets, RandomStream rng,
                            const FigureOptions& options) {
  RandomStream body_rng = rng.substream(1), pose_rng = rng.substream(2), material_rng = rng.substream(3);
  Figure figure = draw_body_and_pose(body_rng, pose_rng, options);
  figure.tags.emplace_back("makehuman");

  Morph morph = draw_morph(assets, figure.body, body_rng, material_rng);
  const MorphedBody& morphed = morph.body;
  figure.body.stature_m =
      scale_to_stature(morph.body, figure.body, printable(assets.folder) + "/targets: of a morphed body");
  const RestFrames rest = rest_frames(morphed, figure.body.stature_m);
  figure.body.head_scale = glm::distance(morphed.joint("l-eye"), morphed.joint("r-eye")) / kEyes_m;
  const Proportions proportions = proportions_of(morphed, rest, figure.body.stature_m);
  figure.body.shoulder_half_m = proportions.shoulder.x;
  figure.body.hip_half_m = proportions.hip.x;
  figure.skeleton = make_skeleton(figure.body, figure.pose, options.position, options.yaw, proportions);
  figure.top_cloth_m = figure.legs_cloth_m = 0.04f;  // of shell clothes; suits are about as wide
  figure.bare.cones = torso_cones(figure, 0);

  const std::vector<PartMotion> motion = motions_of(morphed, rest, figure.skeleton, figure.pose);
  set_face_points(figure, morphed, rest, motion[kHead]);
  Dressing dressing{scene, figure, morphed, motion, {}, std::vector<bool>(morphed.rest.size(), false)};
  for (std::size_t v = 0; v < morphed.rest.size(); ++v)
    dressing.posed.push_back(moved(motion, assets.base.weights.of_vertex[v], morphed.rest[v]));

  draw_materials(figure, morph, material_rng);
  add_clothed_body(dressing, assets, morph.skin != nullptr, rng.substream(5));
  RandomStream head_rng = rng.substream(6);
  add_eyes_brows_and_lashes(dressing, assets, head_rng);
  if (!add_fitted_hair(dressing, assets, head_rng)) add_procedural_hair(dressing, rest.head, rng.substream(7));
  add_held_thing(scene, figure, rng.substream(8));
  if (figure.pose.sitting) add_seat(scene, figure, rng.substream(9));
  return figure;
}

}  // namespace dualpixel::scenes
