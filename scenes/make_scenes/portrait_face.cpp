#include "scenes/make_scenes/portrait_face.h"

#include <algorithm>
#include <cmath>

#include "scenes/make_scenes/sdf_mesh.h"
#include "scenes/procedural/signed_distance.h"
#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

/// The mouth bends upwards towards its corners.
vec3 mouth_space(vec3 p) { return {p.x, p.y - 5.5f * p.x * p.x, p.z + 6 * p.x * p.x}; }

float upper_lip(vec3 p) {
  const vec3 m = mouth_space(p);
  return sdf_ellipsoid({std::abs(m.x), m.y, m.z}, {0.0070f, -0.0508f, 0.0880f}, {0.0160f, 0.0038f, 0.0066f});
}

float lower_lip(vec3 p) { return sdf_ellipsoid(mouth_space(p), {0, -0.0602f, 0.0865f}, {0.0205f, 0.0052f, 0.0078f}); }

float with_jaw_and_cheeks(float d, vec3 p, vec3 s) {
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.045f, 0.022f}, {0.0460f, 0.0575f, 0.062f}), 0.045f);  // jaw
  d = sdf_union(d, sdf_capsule(s, {0.047f, -0.040f, 0.0f}, {0.011f, -0.0885f, 0.060f}, 0.011f, 0.012f),
                0.03f);                                                                             // its edge
  d = sdf_union(d, sdf_ellipsoid(s, {0.042f, -0.005f, 0.047f}, {0.019f, 0.013f, 0.019f}), 0.03f);   // cheekbones
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.052f, 0.064f}, {0.028f, 0.026f, 0.021f}), 0.022f);       // around the mouth
  return sdf_union(d, sdf_ellipsoid(p, {0, -0.0865f, 0.061f}, {0.017f, 0.0130f, 0.0140f}), 0.02f);  // chin
}

float with_eyes(float d, vec3 p, vec3 s) {
  d = sdf_union(d, sdf_ellipsoid(s, {0.022f, 0.034f, 0.0765f}, {0.024f, 0.0065f, 0.010f}), 0.022f);       // brows
  d = sdf_subtract(d, sdf_ellipsoid(s, {0.031f, 0.0150f, 0.099f}, {0.0195f, 0.0120f, 0.0195f}), 0.016f);  // sockets
  const float lids = glm::length(s - kEye) - kLidRadius_m, x = s.x - kEye.x, y = p.y - kEye.y;
  const float upper = std::max(lids, upper_lid_m(x) - y), lower = std::max(lids, y - lower_lid_m(x));
  return sdf_union(d, std::min(upper, lower), 0.003f);
}

float with_nose(float d, vec3 p, vec3 s) {
  d = sdf_union(d, sdf_capsule(p, {0, 0.022f, 0.0785f}, {0, -0.016f, 0.0985f}, 0.0062f, 0.0088f), 0.012f);  // bridge
  d = sdf_union(d, glm::length(p - vec3(0, -0.0180f, 0.0985f)) - 0.0090f, 0.008f);                          // tip
  d = sdf_union(d, sdf_ellipsoid(s, {0.0118f, -0.0232f, 0.0885f}, {0.0068f, 0.0066f, 0.0092f}), 0.006f);    // wings
  return sdf_subtract(d, sdf_ellipsoid(s, {0.0066f, -0.0300f, 0.0925f}, {0.0034f, 0.003f, 0.006f}),
                      0.003f);  // nostrils
}

float with_mouth(float d, vec3 p) {
  d = sdf_subtract(d, sdf_capsule(p, {0, -0.0335f, 0.0985f}, {0, -0.0435f, 0.0955f}, 0.0035f, 0.0035f),
                   0.006f);  // philtrum
  d = sdf_union(d, upper_lip(p), 0.005f);
  d = sdf_union(d, lower_lip(p), 0.005f);
  d = sdf_subtract(d, sdf_ellipsoid(mouth_space(p), {0, -0.0550f, 0.0945f}, {0.0250f, 0.0008f, 0.0090f}), 0.0022f);
  return sdf_subtract(d, sdf_ellipsoid(p, {0, -0.0725f, 0.0925f}, {0.018f, 0.004f, 0.0085f}), 0.010f);  // under the lip
}

float with_ears_and_neck(float d, vec3 p, vec3 s) {
  const float ear = sdf_subtract(sdf_ellipsoid(s, {0.0795f, 0.002f, -0.012f}, {0.009f, 0.030f, 0.018f}),
                                 sdf_ellipsoid(s, {0.0895f, 0.004f, -0.006f}, {0.007f, 0.020f, 0.010f}), 0.005f);
  d = sdf_union(d, ear, 0.008f);
  d = sdf_union(d, sdf_capsule(p, {0, -0.05f, -0.025f}, {0, -0.2f, -0.035f}, 0.047f, 0.055f), 0.028f);
  return sdf_union(d, sdf_capsule(s, {0.05f, -0.06f, -0.03f}, {0.012f, -0.185f, 0.018f}, 0.008f, 0.009f), 0.02f);
}

float bell(vec3 p, vec3 center, float sigma_m) {
  const vec3 q = (p - center) / sigma_m;
  return std::exp(-0.5f * glm::dot(q, q));
}

}  // namespace

float upper_lid_m(float x) {
  const float t = x / 0.0148f;
  return 0.0044f * (1 - t * t) - 0.0004f + 0.02f * x;  // the outer corner is the higher one
}

float lower_lid_m(float x) {
  const float t = x / 0.0148f;
  return -0.0046f * (1 - t * t) - 0.0004f + 0.02f * x;
}

float portrait_head(vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);  // the face is symmetric, near enough
  float d = sdf_ellipsoid(p, kSkullCenter, kSkullRadii);
  d = with_jaw_and_cheeks(d, p, s);
  d = with_eyes(d, p, s);
  d = with_nose(d, p, s);
  d = with_mouth(d, p);
  d = with_ears_and_neck(d, p, s);
  return d + 0.00025f * (value_noise(71, p * 420.0f) - 0.5f);  // pores
}

vec3 on_face(float x, float y) {
  vec3 p(x, y, 0.115f);
  for (int step = 0; step < 40; ++step) p.z -= 0.7f * portrait_head(p);
  return p;
}

vec3 skin_tint(vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);
  const auto tint = [](vec3& color, float amount, vec3 by) { color *= glm::mix(vec3(1), by, std::min(amount, 1.0f)); };
  vec3 color(0.97f, 0.96f, 0.95f);
  tint(color, bell(s, {0.043f, -0.022f, 0.062f}, 0.017f), {1.0f, 0.88f, 0.86f});        // cheeks
  tint(color, bell(p, {0, -0.019f, 0.105f}, 0.011f), {1.0f, 0.88f, 0.85f});             // tip of the nose
  tint(color, bell(s, {0.085f, 0, -0.01f}, 0.02f), {1.0f, 0.80f, 0.76f});               // ears
  tint(color, bell(s, kEye + vec3(0, 0.002f, 0.012f), 0.010f), {0.88f, 0.78f, 0.77f});  // lids
  tint(color, bell(p, {0, -0.095f, 0.08f}, 0.014f), {1.0f, 0.92f, 0.90f});              // chin
  const float lips = std::min(upper_lip(p), lower_lip(p));
  tint(color, std::clamp((0.0013f - lips) / 0.0016f, 0.0f, 1.0f), {0.74f, 0.42f, 0.42f});
  return color;
}

}  // namespace dualpixel::scenes
