#pragma once
#include <utility>
#include <vector>

#include "scenes/procedural/signed_distance.h"

/// Blends of round cones: the shape of bodies and garments.
namespace dualpixel::scenes {

/// A round cone from a to b, flattened along one direction.
struct Cone {
  vec3 a, b;
  float radius_a, radius_b;
  float fillet_m = 0.03f;
  vec3 flat_axis{0, 0, 1};
  float flat = 1;      ///< how many times thinner along flat_axis
  vec3 end_normal{0};  ///< not 0: cut off square beyond b, along this direction
};

/// A smooth union of cones, cut off beyond a plane.
struct Shape {
  std::vector<Cone> cones;
  vec3 cut_point{0}, cut_normal{0};  ///< not 0: nothing beyond the plane
  float operator()(vec3 p) const;
};

/// The parts of a cone that do not depend on the point.
struct PreparedCone {
  explicit PreparedCone(const Cone& cone) : ab(cone.b - cone.a) {
    ab += (cone.flat - 1) * glm::dot(ab, cone.flat_axis) * cone.flat_axis;
    length2 = std::max(glm::dot(ab, ab), 1e-9f);
  }
  vec3 ab;  ///< squeezed
  float length2;
};

inline float cone_distance(const Cone& cone, const PreparedCone& prepared, vec3 p) {
  vec3 pa = p - cone.a;
  pa += (cone.flat - 1) * glm::dot(pa, cone.flat_axis) * cone.flat_axis;
  const float t = std::clamp(glm::dot(pa, prepared.ab) / prepared.length2, 0.0f, 1.0f);
  const float d = glm::length(pa - t * prepared.ab) - (cone.radius_a + (cone.radius_b - cone.radius_a) * t);
  return cone.end_normal == vec3(0) ? d : std::max(d, glm::dot(p - cone.b, cone.end_normal));
}

/// A shape for many evaluations: constants are precomputed, and cones that are too far away to matter are skipped. The
/// same numbers as Shape.
class PreparedShape {
 public:
  explicit PreparedShape(const Shape& shape) : shape_(shape) {
    for (const Cone& cone : shape.cones) {
      const float reach = 0.5f * glm::length(cone.b - cone.a) + std::max(cone.radius_a, cone.radius_b) + cone.fillet_m;
      spheres_.push_back({0.5f * (cone.a + cone.b), reach + 1e-4f, PreparedCone(cone)});
    }
  }

  float operator()(vec3 p) const {
    float d = 10;
    for (std::size_t i = 0; i < spheres_.size(); ++i) {
      const Prepared& s = spheres_[i];
      const vec3 from = p - s.middle;
      const float matters = d + s.reach;  // the fillet ends where the other surface is fillet_m further away
      if (matters <= 0 || glm::dot(from, from) > matters * matters) continue;
      const Cone& cone = shape_.cones[i];
      d = blend(d, cone_distance(cone, s.cone, p), cone.fillet_m);
    }
    return shape_.cut_normal == vec3(0) ? d : std::max(d, glm::dot(p - shape_.cut_point, shape_.cut_normal));
  }

 private:
  struct Prepared {
    vec3 middle;
    float reach;
    PreparedCone cone;
  };
  const Shape& shape_;
  std::vector<Prepared> spheres_;
};

}  // namespace dualpixel::scenes
