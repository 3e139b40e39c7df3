#pragma once
#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "simulator/render/ray_packet.h"
#include "simulator/render/shading/environment_light.h"
#include "simulator/render/shading/near_lights.h"
#include "simulator/render/shading/visible_sky.h"
#include "simulator/render/vec3_packet.h"
#include "simulator/scene/scene.h"

/// Choosing where light may come from: the environment in proportion to the light that a surface here gets of it
/// (VisibleSky), directional lights to their illuminance and those that stand in the scene (NearLights) to an estimate
/// of it, with nothing in their way.
namespace dualpixel::simulator {

struct LightSample {
  glm::vec3 direction{0, 1, 0};  ///< unit, towards the light
  float distance_m = 0;          ///< infinity for environment and directional lights
  glm::vec3 radiance{0};         ///< radiance (or a punctual light's illuminance) over the density; 0: no light
  float pdf = 0;                 ///< solid-angle density, the choice of the light included; 0 for punctual lights
  unsigned mesh = kNoMesh;       ///< of an emissive triangle
  unsigned triangle = 0;
};

struct LightPacket {
  Vec3Packet direction, radiance;
  alignas(64) float distance_m[kPacket], pdf[kPacket];
  alignas(64) unsigned mesh[kPacket], triangle[kPacket];
  void set(int i, const LightSample& s) {
    direction.set(i, s.direction);
    radiance.set(i, s.radiance);
    distance_m[i] = s.distance_m;
    pdf[i] = s.pdf;
    mesh[i] = s.mesh, triangle[i] = s.triangle;
  }
};

class Lights {
 public:
  /// Keeps pointers to both.
  Lights(const Scene& scene, const Intersector& intersector);

  /// A sample of these kinds of light for each lane with lanes[i] != 0; 0 <= u, v < 1. `normal`: of the surface to be
  /// lit, so that light from behind it is rarely asked for.
  void sample(const int lanes[kPacket], const Vec3Packet& point, const Vec3Packet& normal, const float u[kPacket],
              const float v[kPacket], LightPacket& out, LightKinds kinds = LightKinds::all) const;

  /// Lights without extent, and what one of them would throw on a point: `pdf` 0, probability 1.
  std::size_t hard_count() const { return scene_.lights.size(); }
  LightSample hard(std::size_t light, glm::vec3 point) const { return sample_punctual(scene_.lights[light], point); }

  bool has_soft() const { return !environment_.dark() || has_emissive(); }
  bool has_emissive() const { return !near_.triangles().empty(); }
  /// NearLights::average_lux() of all kinds, and its share of all light on surfaces of any direction, as if
  /// each faced them.
  float near_lux() const { return near_.average_lux(LightKinds::all); }
  float near_share() const;

  /// Densities with which sample() of these kinds (not hard), at this point of a surface, would have found what a ray
  /// met by other means.
  float environment_pdf(glm::vec3 point, glm::vec3 normal, glm::vec3 direction,
                        LightKinds kinds = LightKinds::all) const;
  float triangle_pdf(glm::vec3 point, glm::vec3 normal, unsigned mesh, unsigned triangle, float distance_m,
                     float abs_cos_at_light, LightKinds kinds = LightKinds::all) const;

 private:
  /// How the samples of a surface are shared out: by illuminance.
  struct Choice {
    EnvironmentLight::Choice environment;
    NearLights::Weights near;
    float environment_lux = 0, near_lux = 0, all_lux = 0;
  };
  float directional_lux(glm::vec3 normal) const;
  Choice choice_at(glm::vec3 point, glm::vec3 normal, LightKinds kinds) const;
  /// Its part that the environment has; not dark().
  Choice sky_at(glm::vec3 point, glm::vec3 normal) const;
  void sample_environment(const int lanes[kPacket], const Choice choice[kPacket], const float u[kPacket],
                          const float v[kPacket], const float all_lux[kPacket], LightPacket& out) const;
  LightSample sample_punctual(const PunctualLight& light, glm::vec3 point) const;
  /// The near lights' estimate, capped where a lamp is so near that the others would get no samples: as it may be
  /// hidden, they keep a quarter, or what average light leaves them.
  float near_lux_beside(float others, float estimate, LightKinds kinds) const;
  /// Of punctual lights and emissive triangles, which have `near_lux` of `all_lux`; `u`: where among them, 0..1.
  void sample_near(const int lanes[kPacket], const Vec3Packet& point, const float u[kPacket], const float v[kPacket],
                   const NearLights::Choice& choice, const float near_lux[kPacket], const float all_lux[kPacket],
                   LightPacket& out) const;

  const Scene& scene_;
  EnvironmentLight environment_;
  VisibleSky sky_;
  struct Directional {
    PunctualLight light;
    float lux = 0;
  };
  std::vector<Directional> directional_;
  NearLights near_;
};

}  // namespace dualpixel::simulator
