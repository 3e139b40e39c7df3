#include "scenes/people/body/body.h"

#include <algorithm>

namespace dualpixel::scenes {

Body make_body(RandomStream& rng) {
  Body body;
  body.child = rng.chance(0.12f);
  body.old = !body.child && rng.chance(0.15f);
  body.woman = rng.chance(0.5f) ? rng.uniform(0.7f, 1) : rng.uniform(0, 0.2f);
  body.girth = std::clamp(0.45f * rng.normal(), -1.0f, 1.2f);
  if (body.child) {
    body.stature_m = rng.uniform(0.95f, 1.5f);
    body.head_scale = 0.84f + 0.1f * (body.stature_m - 0.95f) / 0.55f + 0.02f * rng.normal();
    body.woman *= 0.3f;
    body.girth *= 0.5f;
  } else {
    body.stature_m = 1.765f - 0.13f * body.woman + 0.065f * rng.normal();
    body.head_scale = 1.02f - 0.05f * body.woman + 0.025f * rng.normal();
  }
  body.shoulder_half_m = body.stature_m * (0.109f - 0.008f * body.woman + 0.006f * body.girth) + 0.006f * rng.normal();
  body.hip_half_m = body.stature_m * (0.05f + 0.004f * body.woman);
  return body;
}

Proportions proportions_of(const Body& body) {
  const float h = body.stature_m, s = body.head_scale;
  Proportions p;
  p.pelvis_m = 0.535f * h;
  p.sitting_pelvis_m = 0.28f * h;
  p.chest = {0, 0.065f * h, 0};
  p.neck_base = {0, 0.218f * h, -0.012f * h};
  // what stature leaves over the neck's base, less what of the head is above its origin
  const float head_top = 0.137f * s;
  p.neck = {0, std::max(h * (1 - 0.535f - 0.065f - 0.218f) - head_top, 0.055f * s), 0.004f * h};
  p.head_forward_m = 0.012f * s;
  p.shoulder = {body.shoulder_half_m, 0.192f * h, -0.004f * h};
  p.hip = {body.hip_half_m, -0.01f * h, 0};
  const float arm_scale = body.child ? 0.96f : 1.0f;
  p.upper_arm_m = 0.182f * h * arm_scale;
  p.fore_arm_m = 0.15f * h * arm_scale;
  p.thigh_m = 0.245f * h;
  p.shank_m = 0.246f * h;
  return p;
}

}  // namespace dualpixel::scenes
