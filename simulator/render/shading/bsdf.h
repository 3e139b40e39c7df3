#pragma once
#include <array>
#include <glm/glm.hpp>

#include "simulator/render/shading/surface.h"

/// glTF's metallic-roughness reflection (glTF 2.0, Appendix B): a Lambertian base under a GGX coat with Schlick's
/// Fresnel term. A dielectric of roughness 1 is plainly Lambertian: its coat would cost time and change next to
/// nothing. Light that would bounce between microfacets is lost, as in glTF's own model: up to 60 % of a fully rough
/// metal's. Materials with glTF's extensions reflect as layers.h says.
/// Hair scatters as hair.h says, to all sides: of it, these functions speak of the half of the directions that `normal`
/// points to, as one of two that are taken at random, and so of twice as much. Directions are unit and point away from
/// the surface; `to_eye` and `to_light` lie above the geometric normal.
namespace dualpixel::simulator {

/// Reflected radiance per unit irradiance (1/sr), without the cosine.
glm::vec3 bsdf(const Surface& surface, glm::vec3 to_eye, glm::vec3 to_light);

/// The part of it that is the same for all directions: of a surface that is not Lambertian, base color under a coat
/// that reflects .04.
glm::vec3 diffuse_bsdf(const Surface& surface);

/// Solid-angle density with which sample_bsdf() picks `to_light`.
float bsdf_pdf(const Surface& surface, glm::vec3 to_eye, glm::vec3 to_light);

/// A direction for u, v in [0, 1): the cosine lobe or the GGX lobe, equally often where the surface is a dielectric,
/// the cosine lobe less often the more it is a metal, and alone where it is Lambertian. It may lie below the surface:
/// then it carries nothing.
glm::vec3 sample_bsdf(const Surface& surface, glm::vec3 to_eye, float u, float v);

/// The same of hair, for four numbers in [0, 1), to any side: normals are turned to that of the direction.
glm::vec3 sample_strand(Surface& surface, glm::vec3 to_eye, const std::array<float, 4>& numbers);

}  // namespace dualpixel::simulator
