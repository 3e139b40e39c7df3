#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "simulator/render/intersector.h"
#include "simulator/render/shading/light_groups.h"
#include "simulator/render/vec3_packet.h"
#include "simulator/scene/scene.h"

/// Choosing among the lights that stand in the scene: punctual ones and emissive triangles. Those that lie close
/// together form a group, and each surface weighs the groups by power, distance and a bound of the cosine, as nodes of
/// a light tree are weighed (Conty Estevez and Kulla 2018), but in one level and whatever way the lights face. As
/// something may be in the way, half of the samples go by average light: a defensive mixture (Hesterberg 1995).
namespace dualpixel::simulator {

/// Lights without extent (punctual ones), or all others.
enum class LightKinds { all, hard, soft };

class NearLights {
 public:
  /// `bounds`: of the scene.
  NearLights(const Scene& scene, const Intersector::Bounds& bounds);

  struct Triangle {
    unsigned mesh = 0, triangle = 0;
    float area_m2 = 0;
    glm::vec3 corner{0}, first_edge{0}, second_edge{0}, normal{0};  ///< normal: unit, of either side
  };
  const std::vector<Triangle>& triangles() const { return triangles_; }
  /// Index into triangles(), -1: the mesh does not emit.
  int index_of(unsigned mesh, unsigned triangle) const {
    const int first = first_triangle_of_mesh_[mesh];
    return first < 0 ? -1 : first + static_cast<int>(triangle);
  }

  /// Illuminance by these kinds on a surface somewhere in the scene that faces them; more, where a weak one counts for
  /// more than it gives.
  float average_lux(LightKinds kinds) const {
    return (kinds == LightKinds::soft ? 0 : hard_lux_) + (kinds == LightKinds::hard ? 0 : soft_lux_);
  }

  /// Estimates for one surface, with nothing in the way; cones, ranges and the cosine at the light do not count.
  struct Weights {
    float lux = 0;          ///< 0: no light is above the surface
    float average_lux = 0;  ///< of those that are
  };
  Weights weights(glm::vec3 point, glm::vec3 normal, LightKinds kinds) const;

  static constexpr std::size_t kMostGroups = 32;  ///< of each kind
  /// Weights::lux for each lane of a packet, and how its samples are shared out among the groups.
  struct Choice {
    alignas(64) float lux[kPacket];
    alignas(64) float shares[2 * kMostGroups][kPacket];
    std::size_t first_group = 0, end_group = 0;
  };
  void choose(const Vec3Packet& point, const Vec3Packet& normal, LightKinds kinds, Choice& out) const;

  struct Picked {
    std::size_t light = 0;  ///< of Scene::lights, then of triangles()
    float probability = 0;
  };
  /// The light to which 0 <= u < 1 belongs, in a lane whose lux are not 0; u becomes the position within its share.
  Picked pick(const Choice& choice, int lane, float& u) const;
  /// Probability with which pick() takes one of triangles() at a surface with these weights.
  float probability(glm::vec3 point, glm::vec3 normal, const Weights& weights, int triangle) const;

 private:
  void add_groups(std::vector<LightSource>& lights, std::size_t first_triangle);
  std::size_t first_group(LightKinds kinds) const { return kinds == LightKinds::soft ? hard_groups_ : 0; }
  std::size_t end_group(LightKinds kinds) const { return kinds == LightKinds::hard ? hard_groups_ : groups_.size(); }

  float hard_lux_ = 0, soft_lux_ = 0;
  std::vector<Triangle> triangles_;
  std::vector<int> first_triangle_of_mesh_;  ///< index into triangles_, -1: the mesh does not emit
  std::vector<LightGroup> groups_;           ///< of punctual lights, then of triangles
  std::size_t hard_groups_ = 0;
  std::vector<std::size_t> lights_;  ///< as Picked::light, by groups
  std::vector<float> sums_;          ///< of lights_' shares of their group, from its first on
  struct Place {
    std::size_t group = 0;
    float share = 0;  ///< of the group; 0: in none
  };
  std::vector<Place> places_;  ///< of triangles()
};

}  // namespace dualpixel::simulator
