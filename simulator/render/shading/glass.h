#pragma once
#include <glm/glm.hpp>

#include "simulator/render/shading/surface.h"

/// What light does where it passes a surface of KHR_materials_transmission: straight on through a thin pane, by Snell's
/// law into and out of solid glass, with GGX microfacets where the surface is rough. All of it is tinted by the base
/// color, at each surface; `transmission` is the share that enters. Glass lies in air: glass within glass bends light
/// as if there were air between. Reflection on the outside is layers.h's.
namespace dualpixel::simulator {

/// Below this roughness a pane is clear, and microfacets would blur less than a photosite sees.
inline constexpr float kClearRoughness = 0.03f;

/// Share of the light that passes one clear surface; `cosine`: of the angle outside; `leaves`: solid glass.
glm::vec3 passing(const Surface& surface, float cosine, bool leaves);

/// Where light that comes from `to_eye`'s side goes: `eta` is the ior on that side over the other's. False: it is
/// reflected in full. Unit vectors.
bool refract(glm::vec3 to_eye, glm::vec3 normal, float eta, glm::vec3& direction);

/// How often a path that meets the outside stays for what the surface reflects.
float stays(const Surface& surface, glm::vec3 to_eye);

/// A way on through the surface, or, inside solid glass, back from it: `share` is what of the light it carries.
struct Passage {
  glm::vec3 direction{0}, share{0};
};

/// `leaves`: the path is inside solid glass, to which there is no reflection but this. `choice`, `u`, `v` in [0, 1).
Passage sample_passage(const Surface& surface, glm::vec3 to_eye, bool leaves, float choice, float u, float v);

/// What is left after `distance_m` of solid glass.
glm::vec3 absorbed(const Layers& layers, float distance_m);

}  // namespace dualpixel::simulator
