#pragma once
#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "simulator/render/vec3_packet.h"
#include "simulator/scene/scene.h"

/// Choosing where light may come from: environment and directional lights in proportion to the light that they throw on
/// a surface with its normal if nothing is in their way, near lights (punctual ones, emissive triangles) in proportion
/// to what they throw on an average point of the scene.
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
  void set(int i, const LightSample& s) {
    direction.set(i, s.direction);
    radiance.set(i, s.radiance);
    distance_m[i] = s.distance_m;
    pdf[i] = s.pdf;
  }
};

class Lights {
 public:
  /// Keeps a pointer to `scene`. `low`, `high`: the scene's bounds.
  Lights(const Scene& scene, glm::vec3 low, glm::vec3 high);

  /// A sample for each lane with lanes[i] != 0; 0 <= u, v < 1. `normal`: of the surface to be lit, so that light from
  /// behind it is rarely asked for.
  void sample(const int lanes[kPacket], const Vec3Packet& point, const Vec3Packet& normal, const float u[kPacket],
              const float v[kPacket], LightPacket& out) const;

  /// Densities with which sample() at a surface with this normal would have found what a ray met by other means.
  float environment_pdf(glm::vec3 normal, glm::vec3 direction) const;
  float triangle_pdf(glm::vec3 normal, unsigned mesh, unsigned triangle, float distance_m,
                     float abs_cos_at_light) const;

 private:
  static constexpr int kRows = 16, kColumns = 32;  ///< cells of the sphere; rows equal in angle
  /// Where in the environment to look from a surface with a normal like this one: running sums over the cells of
  /// radiance times cosine.
  struct EnvironmentTable {
    std::array<float, kRows> rows{};
    std::array<std::array<float, kColumns>, kRows> cells{};  ///< of each row by itself
  };
  /// Luminance of the environment at points spread over the cells, and the directions to them.
  struct EnvironmentProbes;
  void fill_environment_table(const EnvironmentProbes& probes, int normal);
  void make_environment_tables();
  void make_near_lights(float radius_squared);

  // Of one cell of a row: cosine from straight up at its top (the last: at the bottom of all), and how many such cells
  // make a steradian.
  static const std::array<float, kRows + 1> kRowCosine;
  static const std::array<float, kRows> kCellsPerSteradian;
  /// Unoccluded illuminance on a surface, which shares out the samples.
  struct Choice {
    int cell = 0;  ///< of environment_tables_
    float environment_lux = 0, all_lux = 0;
  };
  Choice choice_at(glm::vec3 normal) const;
  void sample_environment(const int lanes[kPacket], const int cell[kPacket], const float u[kPacket],
                          const float v[kPacket], const float all_lux[kPacket], LightPacket& out) const;
  LightSample sample_punctual(const PunctualLight& light, glm::vec3 point) const;
  /// Of punctual lights and emissive triangles; `u`: where among their shares, 0..1.
  void sample_near(const int lanes[kPacket], const Vec3Packet& point, const float u[kPacket], const float v[kPacket],
                   const float all_lux[kPacket], LightPacket& out) const;

  struct EmissiveTriangle {
    unsigned mesh = 0, triangle = 0;
    float area_m2 = 0;
    glm::vec3 corner{0}, first_edge{0}, second_edge{0}, normal{0};  ///< normal: unit, of either side
  };
  const Scene& scene_;
  struct Directional {
    PunctualLight light;
    float lux = 0;
  };
  std::vector<Directional> directional_;
  std::vector<float> near_;  ///< running sums of the shares of punctual lights (directional: 0), then of triangles_
  float near_lux_ = 0;       ///< ... which throw this in all on an average point
  std::vector<EmissiveTriangle> triangles_;
  std::vector<int> first_triangle_of_mesh_;  ///< index into triangles_, -1: the mesh does not emit

  std::vector<EnvironmentTable> environment_tables_;  ///< one for each cell of an octahedral map of normals
  std::vector<float> environment_lux_;                ///< ... in all
};

/// Radiance of the environment in direction `d` (unit), bilinear.
glm::vec3 environment_radiance(const Environment& environment, glm::vec3 d);

}  // namespace dualpixel::simulator
