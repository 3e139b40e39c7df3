#include "scenes/people/shape/patterns.h"

namespace dualpixel::scenes {
namespace {

float gaussian(vec3 d, vec3 sigma) {
  const vec3 q = d / sigma;
  return std::exp(-0.5f * glm::dot(q, q));
}

}  // namespace

vec3 face_pattern(const Material& material, vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);
  const float mottle = fractal(material.seed, p * 45.0f, 3) - 0.5f;
  vec3 color = material.a * (1 + 0.14f * mottle);
  const bool front = p.z > 0.02f;
  // blood under cheeks, nose and ears
  float red = 0.5f * material.v[kBlush] * gaussian(s - vec3(0.044f, -0.02f, 0.06f), {0.018f, 0.015f, 0.03f});
  red += 0.4f * material.v[kBlush] * gaussian(p - vec3(0, -0.02f, 0.1f), {0.011f, 0.011f, 0.02f});
  red += 0.25f * gaussian(s - vec3(0.085f, 0, -0.01f), {0.008f, 0.03f, 0.02f});
  color *= glm::mix(vec3(1), vec3(1.02f, 0.72f, 0.74f), std::min(red, 1.0f));
  // shadows under the eyes
  color *= 1 - 0.18f * gaussian(s - vec3(0.031f, 0.0f, 0.075f), {0.012f, 0.005f, 0.02f});
  if (!front) {
    const float scalp = smooth_step(p.y - 0.02f + 0.5f * p.z, 0.02f);
    return glm::mix(color, material.c, material.v[kScalpHair] * scalp);
  }
  const float scalp = smooth_step(p.y - 0.082f + 0.006f * std::sin(p.x * 90), 0.008f);
  color = glm::mix(color, material.c, material.v[kScalpHair] * scalp);
  // beard's shadow: jaw, chin, upper lip
  const float around_mouth = glm::length(vec2(p.x / 0.024f, (p.y + 0.0545f) / 0.0135f));
  const float beard = smooth_step(-0.03f - p.y + 0.45f * s.x, 0.02f) * smooth_step(around_mouth - 1, 0.25f) *
                      smooth_step(p.y + 0.13f, 0.02f);
  const float hairs = 0.6f + 0.8f * noise(material.seed + 7, p * 600.0f);
  color = glm::mix(color, material.c * 1.3f, std::clamp(material.v[kStubble] * beard * hairs, 0.0f, 0.95f));
  // brows
  const float along = (s.x - 0.012f) / 0.038f;
  if (along > 0 && along < 1) {
    const float height = 0.034f + 0.008f * std::sin(2.1f * along) - 0.002f * along;
    const float half = material.v[kBrowThickness] * 0.0062f * (1.1f - 0.75f * along);
    const float brow =
        smooth_step(half - std::abs(p.y - height), 0.0025f) * (0.65f + 0.5f * noise(material.seed + 9, p * 500.0f));
    color = glm::mix(color, material.c, std::clamp(brow, 0.0f, 0.9f));
  }
  // lashes: a dark rim about the eye's opening, stronger above
  const vec2 eye((s.x - 0.031f) / 0.0165f, (p.y - 0.0145f) / 0.0085f);
  const float rim = std::exp(-14 * (glm::length(eye) - 1) * (glm::length(eye) - 1));
  color *= 1 - rim * (eye.y > 0 ? 0.45f + 0.5f * material.v[kEyeLine] : 0.2f + 0.4f * material.v[kEyeLine]);
  // lips and what shows between them
  const float lips = std::min(ellipsoid(p, {0, -0.0485f, 0.078f}, {0.0236f, 0.0062f, 0.02f}),
                              ellipsoid(p, {0, -0.0605f, 0.077f}, {0.0208f, 0.007f, 0.02f}));
  color = glm::mix(color, material.b, smooth_step(0.0012f - lips, 0.0016f));
  const float open = material.v[kMouthOpen];
  const float corner = 0.006f * (s.x / 0.02f) * (s.x / 0.02f);
  const float slit = std::abs(p.y + 0.0545f - (open > 0.3f ? corner : 0.0f)) -
                     (0.0008f + 0.0052f * open) * std::sqrt(std::max(0.0f, 1 - s.x * s.x / (0.021f * 0.021f)));
  if (slit < 0 && s.x < 0.021f && p.z > 0.05f) {
    const bool teeth = open > 0.3f && p.y > -0.0585f;
    color = teeth ? vec3(0.62f, 0.57f, 0.49f) * (0.8f + 0.2f * triangle(p.x / 0.0075f)) : vec3(0.06f, 0.02f, 0.02f);
  }
  // nostrils
  return color * (1 - 0.75f * gaussian(s - vec3(0.0068f, -0.0305f, 0.095f), {0.003f, 0.0028f, 0.02f}));
}

vec3 eye_pattern(const Material& material, vec3 d) {
  const float r = std::sqrt(d.x * d.x + d.y * d.y);
  if (d.z > 0 && r < 0.17f) return vec3(0.01f);
  if (d.z > 0 && glm::length(vec2(d.x + 0.12f, d.y - 0.14f)) < 0.06f) return vec3(1.6f);  // a window's reflection
  if (d.z > 0 && r < 0.48f) return material.a * (r > 0.43f ? 0.35f : 0.7f + 0.6f * noise(material.seed, d * 30.0f));
  return vec3(0.52f, 0.48f, 0.46f) - vec3(0, 0.08f, 0.1f) * smooth_step(r - 0.7f, 0.3f);
}

vec3 hair_pattern(const Material& material, vec3 p) {
  // streaks run downwards: fine around the head, long along it
  const float around = std::atan2(p.x, p.z);
  const float streak = noise(material.seed, {around * 40, p.y * 9, 5 * glm::length(vec2(p.x, p.z))});
  const float fine = noise(material.seed + 3, {around * 150, p.y * 25, 20 * p.z});
  const float tone = 0.45f + 0.7f * streak + 0.5f * (fine - 0.5f);
  return glm::mix(material.a, material.b, smooth_step(streak - 0.55f, 0.5f)) * std::max(tone, 0.15f);
}

}  // namespace dualpixel::scenes
