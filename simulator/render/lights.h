#pragma once
#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "simulator/render/vec3_packet.h"
#include "simulator/scene/scene.h"

/// Choosing where light may come from: environment, punctual lights and emissive triangles, in proportion to the
/// light that they throw on an average place of the scene.
namespace dualpixel::simulator {

struct LightSample {
  glm::vec3 direction{0, 1, 0};  ///< unit, towards the light
  float distance_m = 0;          ///< infinity for environment and directional lights
  glm::vec3 radiance{0};         ///< radiance (or a punctual light's illuminance) over the density; 0: no light
  float pdf = 0;                 ///< solid-angle density, the choice of the light included; 0 for punctual lights
};

struct LightPacket {
  Vec3Packet direction, radiance;
  alignas(64) float distance_m[kPacket], pdf[kPacket];
};

class Lights {
 public:
  /// Keeps a pointer to `scene`. `low`, `high`: the scene's bounds.
  Lights(const Scene& scene, glm::vec3 low, glm::vec3 high);

  bool empty() const { return cumulative_.empty(); }
  /// A sample for each lane with lanes[i] != 0; 0 <= u, v < 1. `normal`: of the surface to be lit, so that light from
  /// behind it is rarely asked for.
  void sample(const int lanes[kPacket], const Vec3Packet& point, const Vec3Packet& normal, const float u[kPacket],
              const float v[kPacket], LightPacket& out) const;

  /// Densities with which sample() would have found what a ray met by other means.
  float environment_pdf(glm::vec3 normal, glm::vec3 direction) const;
  float triangle_pdf(unsigned mesh, unsigned triangle, float distance_m, float abs_cos_at_light) const;

 private:
  int pick(float& u, float& probability) const;
  void sample_environment(const int lanes[kPacket], const Vec3Packet& normal, const float u[kPacket],
                          const float v[kPacket], const float probability[kPacket], LightPacket& out) const;
  LightSample sample_punctual(const PunctualLight& light, glm::vec3 point) const;
  LightSample sample_triangle(std::size_t index, glm::vec3 point, float u, float v) const;

  struct EmissiveTriangle {
    unsigned mesh = 0, triangle = 0;
    float area_m2 = 0;
  };
  const Scene& scene_;
  // entries of the choice: the environment (if lit), then punctual lights, then emissive triangles
  std::vector<float> cumulative_;
  std::vector<EmissiveTriangle> triangles_;
  std::vector<int> first_triangle_of_mesh_;  ///< index into triangles_, -1: the mesh does not emit
  std::size_t environment_entries_ = 0;

  /// Where in the environment to look from a surface with a normal like this one: running sums over kRows x kColumns
  /// cells of the sphere, rows equal in angle, of radiance times cosine.
  struct EnvironmentTable {
    static constexpr int kRows = 16;
    static constexpr int kColumns = 32;
    std::array<float, kRows> rows{};
    std::array<std::array<float, kColumns>, kRows> cells{};  ///< of each row by itself
  };
  static constexpr int kRows = EnvironmentTable::kRows;
  static constexpr int kColumns = EnvironmentTable::kColumns;
  std::vector<EnvironmentTable> environment_tables_;  ///< one for each cell of an octahedral map of normals
};

/// Radiance of the environment in direction `d` (unit), bilinear.
glm::vec3 environment_radiance(const Environment& environment, glm::vec3 d);

}  // namespace dualpixel::simulator
