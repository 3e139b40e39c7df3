#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/math.h"
#include "scenes/things/things.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

Surface wire_surface(RandomStream& rng) {
  if (rng.chance(0.4f)) return plain_surface(rng.substream(90), paint_color(rng), 0.5f);
  return metal_surface(rng.substream(90), rng.chance(0.7f) ? vec3(0.55f) : vec3(0.7f, 0.5f, 0.3f),
                       rng.uniform(0.2f, 0.5f));
}

/// A pencil from foot to tip: wood, paint, lead.
void add_pencil(SceneBuilder& build, RandomStream& rng, const glm::mat4& pose, vec3 foot, vec3 tip) {
  const vec3 along = glm::normalize(tip - foot), neck = tip - 0.018f * along;
  Mesh shaft, point;
  add_pipe(shaft, {foot, neck}, 0.0036f, 6);
  add_pipe(point, {neck, tip}, {0.0034f, 0.0004f}, 8);
  build.add("pencil", placed_mesh(shaft, pose), Surface{.color = paint_color(rng), .roughness = 0.4f});
  build.add("pencil point", placed_mesh(point, pose), Surface{.color = vec3(0.5f, 0.36f, 0.22f)});
}

}  // namespace

void add_pencil_holder(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.035f, 0.045f), h = rng.uniform(0.08f, 0.11f), wire = rng.uniform(0.0005f, 0.0009f);
  const int around = 28 + rng.below(24);
  const float slope = rng.uniform(0.8f, 1.6f) * h / r;
  Mesh net;
  for (int i = 0; i < around; ++i) {  // two families of helices: diamonds
    for (const float turn : {-1.0f, 1.0f}) {
      const float phi0 = 2 * kPi * static_cast<float>(i) / static_cast<float>(around);
      add_pipe(net,
               curve(14,
                     [&](float t) {
                       const float phi = phi0 + turn * slope * t;
                       return vec3(r * std::cos(phi), 0.002f + (h - 0.004f) * t, r * std::sin(phi));
                     }),
               wire, 5);
    }
  }
  for (const float y : {0.0022f, h - 0.002f}) add_pipe(net, ring({0, y, 0}, r, 48), 0.0018f, 8);
  add_lathe(net, glm::mat4(1), {{0, 0.001f}, {r, 0.001f}, {r, 0.003f}, {0, 0.003f}});
  build.add("net", placed_mesh(net, pose), wire_surface(rng));
  const int pencils = 2 + rng.below(7);
  for (int i = 0; i < pencils; ++i) {
    const float phi = rng.uniform(0, 2 * kPi), other = phi + kPi + rng.uniform(-1, 1);
    const vec3 foot(0.6f * r * std::cos(phi), 0.006f, 0.6f * r * std::sin(phi));
    const vec3 rim(0.85f * r * std::cos(other), h, 0.85f * r * std::sin(other));
    add_pencil(build, rng, pose, foot, foot + glm::normalize(rim - foot) * rng.uniform(0.13f, 0.19f));
  }
}

void add_wire_basket(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float r = rng.uniform(0.07f, 0.12f), h = rng.uniform(0.05f, 0.11f), foot = r * rng.uniform(0.6f, 0.95f);
  const float wire = rng.uniform(0.001f, 0.002f);
  const int ribs = 16 + rng.below(16), hoops = 3 + rng.below(5);
  Mesh basket;
  for (int i = 0; i < ribs; ++i) {
    const float phi = 2 * kPi * static_cast<float>(i) / static_cast<float>(ribs);
    const vec3 out(std::cos(phi), 0, std::sin(phi));
    add_pipe(basket,
             {0.15f * foot * out + vec3(0, wire, 0), 0.9f * foot * out + vec3(0, wire, 0),
              foot * out + vec3(0, 0.08f * h, 0), r * out + vec3(0, h, 0)},
             wire, 6);
  }
  for (int i = 0; i < hoops; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(hoops);
    add_pipe(basket, ring({0, h * t, 0}, foot + (r - foot) * t + wire, 56), wire * 0.8f, 6);
  }
  add_pipe(basket, ring({0, h, 0}, r, 56), 2 * wire, 8);
  add_pipe(basket, ring({0, wire, 0}, 0.45f * foot, 40), wire, 6);
  build.add("basket", placed_mesh(basket, pose), wire_surface(rng));
  const int content = rng.below(5);
  for (int i = 0; i < content; ++i) {
    const float phi = 2.2f * static_cast<float>(i) + 1;
    add_fruit(build, rng.substream(40 + i),
              glm::translate(pose, vec3(0.5f * foot * std::cos(phi), 2 * wire, 0.5f * foot * std::sin(phi))));
  }
}

void add_whisk(SceneBuilder& build, RandomStream rng, const glm::mat4& pose) {
  const float length = rng.uniform(0.2f, 0.27f), r = rng.uniform(0.022f, 0.032f), from = 0.45f * length;
  const int loops = 5 + rng.below(4);
  Mesh wires, handle;
  for (int i = 0; i < loops; ++i) {
    const float phi = kPi * static_cast<float>(i) / static_cast<float>(loops);
    add_pipe(wires,
             curve(28,
                   [&](float t) {
                     const float a = kPi * (2 * t - 1);
                     const float out = r * std::sin(a) * (1 - 0.35f * std::cos(a));
                     return vec3(from + (length - from) * 0.5f * (1 + std::cos(a)), r + out * std::cos(phi),
                                 out * std::sin(phi));
                   }),
             0.0008f, 6);
  }
  add_pipe(handle, curve(10, [&](float t) { return vec3(from * t, r * (0.45f + 0.55f * t), 0); }),
           {0.004f, 0.008f, 0.009f, 0.0085f, 0.0075f, 0.007f, 0.007f, 0.0075f, 0.007f, 0.006f}, 14);
  const glm::mat4 lying = glm::translate(pose, vec3(-0.5f * length, 0, 0));
  build.add("whisk", placed_mesh(wires, lying), metal_surface(rng.substream(1), vec3(0.6f), 0.2f));
  build.add("handle", placed_mesh(handle, lying), wood_surface(rng.substream(2), wood_color(rng), 0, 0.2f));
}

}  // namespace dualpixel::scenes
