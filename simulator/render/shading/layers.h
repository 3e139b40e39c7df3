#pragma once
#include <glm/glm.hpp>

#include "simulator/render/shading/surface.h"

/// Reflection of materials with glTF's extensions (Layers): from the outside in, a coat, sheen, and a metal or
/// dielectric of any ior whose base is diffuse or lets light pass. GGX for coat and surface; Charlie's distribution for
/// sheen (Estevez and Kulla 2017), as glTF has it, made less where it would gain light (low roughness, grazing angles).
/// What a layer reflects is taken off what lies below so that the whole is reciprocal and gives back no more than it
/// gets: below the surface's reflection by both angles (Kelemen and Szirmay-Kalos 2001), where glTF's own formula goes
/// by the half vector and gains light at grazing angles. `surface` has layers; otherwise as in bsdf.h, which calls
/// these.
/// Skin: light that enters and comes back from within, as of a deep layer that scatters evenly (Chandrasekhar 1960,
/// with the H function of Hapke 2002), whose reflection of even light is the base color. It is flatter than Lambert's,
/// and brighter at grazing angles. Approximated: light comes out where it went in, so that shadows stay sharp.
namespace dualpixel::simulator {

glm::vec3 layered_bsdf(const Surface& surface, glm::vec3 to_eye, glm::vec3 to_light);

/// About what of it is the same for all directions.
glm::vec3 layered_diffuse_bsdf(const Surface& surface);

float layered_pdf(const Surface& surface, glm::vec3 to_eye, glm::vec3 to_light);

glm::vec3 sample_layered(const Surface& surface, glm::vec3 to_eye, float u, float v);

/// Share of light that a smooth surface reflects, by the cosine of the angle outside of it (Schlick 1994).
glm::vec3 fresnel(const Layers& layers, float cosine);

/// The same of the coat, times its share of the surface.
float coat_reflects(const Layers& layers, float cosine);

/// Share of light that sheen of color 1 reflects, over all directions.
float sheen_albedo(float roughness, float cosine);

}  // namespace dualpixel::simulator
