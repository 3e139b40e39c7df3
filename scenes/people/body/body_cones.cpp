#include "scenes/people/body/body_cones.h"

#include <algorithm>

namespace dualpixel::scenes {

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

}  // namespace dualpixel::scenes
