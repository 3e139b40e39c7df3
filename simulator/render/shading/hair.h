#pragma once
#include <array>
#include <glm/glm.hpp>

/// Light on hair and fur: a rough cylinder of tinted horn that reflects at its front (R), lets light through (TT) and
/// reflects it at its back (TRT and all that follow), as Marschner et al. 2003 found. The lobes are those of d'Eon et
/// al. 2011, their roughness and color those of Chiang et al. 2016, without the tilt of the cuticle's scales. White
/// hair gives back all light that it gets. Like its sources, the model is not reciprocal: it goes by the eye's angle.
namespace dualpixel::simulator {

struct HairStrand {
  glm::vec3 tangent{1, 0, 0};  ///< unit, along the strand
  float across = 0;            ///< where between the sides of the strand, -1 to 1, the eye meets it
  glm::vec3 color{0};          ///< of a mass of such hair under even light
  float roughness = 0.3f;
};

/// Offset of a hit on the strand from its axis, as seen along `to_eye`: HairStrand::across.
float across_strand(glm::vec3 tangent, glm::vec3 to_eye, glm::vec3 offset_over_radius);

/// Scattered radiance per radiance and steradian, the cosine to the strand included: 1 / sr. Unit directions, away from
/// the strand.
glm::vec3 hair_scattering(const HairStrand& strand, glm::vec3 to_eye, glm::vec3 to_light);

/// Solid-angle density with which sample_hair() picks `to_light`.
float hair_pdf(const HairStrand& strand, glm::vec3 to_eye, glm::vec3 to_light);

/// A direction anywhere on the sphere, for four numbers in [0, 1).
glm::vec3 sample_hair(const HairStrand& strand, glm::vec3 to_eye, const std::array<float, 4>& numbers);

}  // namespace dualpixel::simulator
