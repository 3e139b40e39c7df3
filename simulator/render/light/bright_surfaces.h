#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "simulator/render/intersector.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

class Lights;

/// Surfaces so close to a lamp that the light they reflect is a light source of its own: a shade around its bulb. Paths
/// that looked for them by chance would be few and bright, which leaves blotches. So a share of the rays of diffuse
/// reflection is sent towards them, and the balance heuristic (Veach 1995) weighs both ways to the same light.
class BrightSurfaces {
 public:
  /// None.
  BrightSurfaces() = default;
  /// Finds them: triangles that a lamp throws far more light on than on the average surface that faces it.
  BrightSurfaces(const Scene& scene, const Lights& lights, const Intersector& intersector);

  /// Of the rays of diffuse reflection, those that are to be sent towards bright surfaces; 0 .. 0.5, 0: there are none.
  float share() const { return share_; }

  struct Target {
    glm::vec3 direction{0, 1, 0};  ///< unit
    int triangle = -1;             ///< of the bright ones
  };
  /// Towards a point on one of them; 0 <= u, v < 1.
  Target towards(glm::vec3 point, float u, float v) const;

  /// The bright triangle that a ray has met, or -1.
  int met(unsigned mesh, unsigned triangle) const { return index_[mesh].empty() ? -1 : index_[mesh][triangle]; }
  /// Solid-angle density of towards() in a direction in which bright `triangle` is met after `distance_m`.
  float pdf(int triangle, glm::vec3 direction, float distance_m) const;

 private:
  struct Triangle {
    glm::vec3 corner{0}, first_edge{0}, second_edge{0}, normal{0};  ///< normal: unit, of either side
    float area_m2 = 0;
  };
  static std::optional<Triangle> triangle_of(const Mesh& mesh, const glm::uvec3& corners);  ///< empty: it has no area

  std::vector<Triangle> triangles_;
  std::vector<float> shares_;            ///< running sums
  std::vector<std::vector<int>> index_;  ///< of each mesh's triangles in triangles_; empty: it has none
  float share_ = 0;
};

}  // namespace dualpixel::simulator
