#pragma once
#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "simulator/render/intersector.h"
#include "simulator/render/shading/environment_light.h"

/// What of the environment is seen from each part of a scene. In a room almost all of it is hidden, so light samples
/// that are shared out by its light alone would hardly ever find the window. Here some rays find out what is seen from
/// a cube of the scene by surfaces that face one way, and a share of the samples follows them. What they have missed
/// still gets the other samples, so that nothing is lost; surfaces under an open sky sample as if this did not exist.
namespace dualpixel::simulator {

class VisibleSky {
 public:
  /// Keeps pointers to both.
  VisibleSky(const EnvironmentLight& environment, const Intersector& intersector);
  ~VisibleSky();
  VisibleSky(const VisibleSky&) = delete;
  VisibleSky& operator=(const VisibleSky&) = delete;

  struct View {
    /// Of the light that a surface would get from all of it, the share that arrives; kLeast at least.
    float visible = 1;
    float share = 0;                                ///< of samples, to follow `seen`
    std::unique_ptr<EnvironmentLight::Table> seen;  ///< null: no share
  };
  static constexpr float kLeast = 0.02f;
  /// From a surface here; found when first wanted. It depends on the scene alone. Not of a dark environment.
  const View& from(glm::vec3 point, glm::vec3 normal) const;

 private:
  /// The side of a cube: of surfaces in it that face this way.
  struct Place {
    glm::ivec3 cube;
    int side;
    std::uint64_t key() const;
  };
  std::vector<glm::vec3> origins_in(const Place& place) const;
  std::unique_ptr<View> look_from(const Place& place) const;

  const EnvironmentLight& environment_;
  const Intersector& intersector_;
  float cube_m_ = 1;                               ///< a power of two
  glm::ivec3 first_{0}, cubes_{1};                 ///< the scene's cubes, counted from the origin of the world
  mutable std::vector<std::atomic<View*>> views_;  ///< six for each cube: -x, +x, -y ...
};

}  // namespace dualpixel::simulator
