#include "scenes/make_scenes/portrait_face.h"

#include <algorithm>
#include <cmath>

#include "scenes/make_scenes/sdf_mesh.h"
#include "scenes/math.h"
#include "scenes/procedural/signed_distance.h"
#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

/// A ridge or groove at a distance `x`, 1 in its middle.
float ridge(float x, float width_m) { return std::exp(-x * x / (width_m * width_m)); }

struct Lips {
  float inside_m = -1;  ///< how far a point, seen from the front, is inside them
  float bulge_m = 0;    ///< how far they stand out there
  float gap = 0;        ///< 1 on the line where they meet, corners included
};

Lips lips_at(vec3 p) {
  constexpr float kMiddle_m = -0.0525f, kHalfWidth_m = 0.0235f, kUpper_m = 0.0080f, kLower_m = 0.0088f;
  const float t = p.x / kHalfWidth_m, taper = 1 - t * t;  // to 0 at the corners
  const float y = p.y - kMiddle_m - 9.0f * p.x * p.x;     // the corners are higher
  if (taper <= 0 || p.z < 0.05f) return {};               // beside them, or at the back of the head
  const float bow = 1 - 0.2f * ridge(p.x, 0.0042f);       // the dip in the middle of the upper lip
  const float height = y > 0 ? kUpper_m * taper * bow : kLower_m * std::pow(taper, 0.75f);
  const float share = std::min(std::abs(y) / height, 1.0f), gap = ridge(y, 0.0012f);
  const float bulge = (y > 0 ? 0.0028f : 0.0036f) * std::sin(kPi * std::pow(share, 0.75f)) - 0.0010f * gap;
  return {height - std::abs(y), std::sqrt(taper) * bulge, gap};
}

float with_jaw_and_cheeks(float d, vec3 p, vec3 s) {
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.043f, 0.022f}, {0.0370f, 0.0520f, 0.063f}), 0.045f);  // jaw
  d = sdf_union(d, sdf_capsule(s, {0.0415f, -0.040f, 0.0f}, {0.009f, -0.0835f, 0.0600f}, 0.010f, 0.011f),
                0.03f);                                                                            // its edge
  d = sdf_union(d, sdf_ellipsoid(s, {0.041f, -0.008f, 0.050f}, {0.019f, 0.015f, 0.019f}), 0.03f);  // cheekbones
  d = sdf_union(d, sdf_ellipsoid(s, {0.037f, -0.034f, 0.046f}, {0.011f, 0.020f, 0.013f}), 0.02f);  // under them
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.050f, 0.064f}, {0.0265f, 0.025f, 0.021f}), 0.022f);     // around the mouth
  return sdf_union(d, sdf_ellipsoid(p, {0, -0.0800f, 0.0640f}, {0.0130f, 0.0120f, 0.0140f}), 0.02f);  // chin
}

float with_eyes(float d, vec3 p, vec3 s) {
  d = sdf_union(d, sdf_ellipsoid(s, {0.022f, 0.034f, 0.0765f}, {0.024f, 0.0065f, 0.010f}), 0.022f);        // brows
  d = sdf_subtract(d, sdf_ellipsoid(s, {0.0325f, 0.0150f, 0.099f}, {0.0235f, 0.0130f, 0.0200f}), 0.016f);  // sockets
  const float lids = glm::length(s - kEye) - kLidRadius_m, x = s.x - kEye.x, y = p.y - kEye.y;
  const float upper = std::max(lids, upper_lid_m(x) - y), lower = std::max(lids, y - lower_lid_m(x));
  d = sdf_union(d, std::min(upper, lower), 0.003f);
  if (p.z < 0.05f) return d;  // the back of the head
  const float fold = ridge(y - upper_lid_m(x) - 0.0040f, 0.0011f), bag = ridge(y - lower_lid_m(x) + 0.0052f, 0.0018f);
  return d + ridge(x, 0.0135f) * (0.0013f * fold + 0.0005f * bag);
}

float with_nose(float d, vec3 p, vec3 s) {
  d = sdf_union(d, sdf_capsule(p, {0, 0.024f, 0.0790f}, {0, -0.015f, 0.0995f}, 0.0044f, 0.0070f), 0.010f);  // bridge
  d = sdf_union(d, glm::length(p - vec3(0, -0.0172f, 0.1000f)) - 0.0068f, 0.009f);                          // tip
  d = sdf_union(d, sdf_ellipsoid(s, {0.0110f, -0.0225f, 0.0888f}, {0.0052f, 0.0058f, 0.0090f}), 0.009f);    // wings
  return sdf_subtract(d, sdf_ellipsoid(s, {0.0066f, -0.0292f, 0.0925f}, {0.0034f, 0.003f, 0.006f}),
                      0.003f);  // nostrils
}

float with_mouth(float d, vec3 p, vec3 s) {
  d = sdf_subtract(d, sdf_capsule(p, {0, -0.0325f, 0.0985f}, {0, -0.0415f, 0.0955f}, 0.0035f, 0.0035f),
                   0.006f);  // philtrum
  d -= lips_at(p).bulge_m;
  d = sdf_subtract(d, sdf_capsule(s, {0.0180f, -0.0250f, 0.0900f}, {0.0300f, -0.0480f, 0.0800f}, 0.0010f, 0.0010f),
                   0.008f);  // beside nose and mouth
  return sdf_subtract(d, sdf_ellipsoid(p, {0, -0.0685f, 0.0925f}, {0.016f, 0.004f, 0.0085f}), 0.010f);  // under the lip
}

float with_ears_and_neck(float d, vec3 p, vec3 s) {
  const float ear = sdf_subtract(sdf_ellipsoid(s, {0.0770f, 0.005f, -0.012f}, {0.009f, 0.0275f, 0.0165f}),
                                 sdf_ellipsoid(s, {0.0870f, 0.008f, -0.006f}, {0.007f, 0.018f, 0.0095f}), 0.005f);
  d = sdf_union(d, ear, 0.008f);
  d = sdf_union(d, sdf_capsule(p, {0, -0.05f, -0.025f}, {0, -0.2f, -0.035f}, 0.044f, 0.054f), 0.022f);
  return sdf_union(d, sdf_capsule(s, {0.046f, -0.06f, -0.035f}, {0.012f, -0.185f, 0.018f}, 0.008f, 0.009f), 0.02f);
}

float bell(vec3 p, vec3 center, float sigma_m) {
  const vec3 q = (p - center) / sigma_m;
  return std::exp(-0.5f * glm::dot(q, q));
}

/// The line through the corners of an eye: under its middle, as it looks down to the camera; the outer one is higher.
float corners_m(float x) { return 0.03f * x - 0.0014f; }

}  // namespace

float upper_lid_m(float x) {
  const float t = x / kEyeHalfWidth_m;
  return 0.0046f * (1 - t * t) * (1 - 0.2f * t) + corners_m(x);  // highest towards the nose
}

float lower_lid_m(float x) {
  const float t = x / kEyeHalfWidth_m;
  return -0.0048f * (1 - t * t) * (1 + 0.2f * t) + corners_m(x);  // lowest away from it
}

float portrait_head(vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);  // the face is symmetric, near enough
  float d = sdf_ellipsoid(p, kSkullCenter, kSkullRadii);
  d = with_jaw_and_cheeks(d, p, s);
  d = with_eyes(d, p, s);
  d = with_nose(d, p, s);
  d = with_mouth(d, p, s);
  d = with_ears_and_neck(d, p, s);
  return d + 0.00012f * (value_noise(71, p * 420.0f) - 0.5f);  // pores
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
  tint(color, bell(s, {0.043f, -0.022f, 0.062f}, 0.019f), {1.0f, 0.92f, 0.90f});        // cheeks
  tint(color, bell(p, {0, -0.019f, 0.105f}, 0.011f), {1.0f, 0.88f, 0.85f});             // tip of the nose
  tint(color, bell(s, {0.085f, 0, -0.01f}, 0.02f), {1.0f, 0.80f, 0.76f});               // ears
  tint(color, bell(s, kEye + vec3(0, 0.002f, 0.012f), 0.010f), {0.89f, 0.80f, 0.79f});  // lids
  tint(color, bell(p, {0, -0.088f, 0.08f}, 0.014f), {1.0f, 0.92f, 0.90f});              // chin
  const Lips lips = lips_at(p);
  tint(color, std::clamp(0.5f + lips.inside_m / 0.0012f, 0.0f, 1.0f), {0.84f, 0.62f, 0.60f});
  tint(color, lips.gap, {0.62f, 0.47f, 0.45f});
  return color;
}

}  // namespace dualpixel::scenes
