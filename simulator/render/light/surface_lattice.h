#pragma once
#include <array>
#include <cstdint>

#include "simulator/render/ray_packet.h"
#include "simulator/scene/scene.h"

/// Points on triangles at which light is computed, to be interpolated between.
///
/// A triangle is cut into rows parallel to its shortest edge, and each row into equal pieces, so that neighbors lie no
/// further apart than a spacing, however thin the triangle is. Points depend on the triangle and the spacing alone, and
/// there is one such lattice for each spacing that is asked for; spacings come in steps of a half octave. Triangles
/// smaller than the spacing share the points at their vertices, where the mesh has normals there.
namespace dualpixel::simulator {

struct LatticePoint {
  std::uint64_t key = 0;    ///< names the point among all of the scene; never 0
  std::uint64_t group = 0;  ///< the same for points nearby
  float u = 0, v = 0;       ///< barycentric weights of the triangle's second and third corner
  int vertex = -1;          ///< of the mesh, where the point is one; else -1
  bool behind = false;      ///< of a vertex: on the side that its normal points away from
};

/// A position among the points around it.
struct LatticeCell {
  struct Row {
    int row = 0, left = 0, pieces = 0;  ///< point `left` of its 0 .. pieces; no pieces: the only point of the row
    float share = 0, beyond = 0;        ///< weight of the row, and in it of the point right of `left`
  } rows[2];
};

class TriangleLattice {
 public:
  TriangleLattice() = default;
  /// The side that a ray in `direction` meets of the triangle that `hit` lies on. `spacing_m` > 0 is rounded down to 1
  /// or 1.5 times a power of two.
  TriangleLattice(const Scene& scene, const Hit& hit, glm::vec3 direction, float spacing_m);

  /// Whether it would be the same lattice.
  bool is_of(const Hit& hit, glm::vec3 direction, float spacing_m) const;

  LatticeCell cell(float u, float v) const;
  /// Names a cell among all of the scene; never 0.
  std::uint64_t key_of(const LatticeCell& cell) const;
  LatticePoint point(int row, int piece, int pieces) const;

  const Hit& hit() const { return hit_; }
  glm::vec3 view() const { return glm::dot(normal_, direction_) > 0 ? normal_ : -normal_; }
  float spacing_m() const;
  /// spacing_m(), or the length of a triangle that is no longer than that.
  float reach_m() const { return reach_m_; }
  /// Difference of the normals of neighboring points, at most: nearly the angle between them in radians. Of vertices
  /// less than a quarter of the spacing apart 0: closer points would hardly tell them apart.
  float turn() const { return turn_; }
  /// Of the light samples that points get, the power of 4 by which these get fewer, as they lie closer: 0 to 2.
  int fewer() const { return fewer_; }
  /// Whether the triangle is no longer than the spacing, as rounded.
  bool is_small() const { return rows_ == 1; }

 private:
  int pieces_of(int row) const;
  LatticePoint vertex_point(int row, int piece) const;

  Hit hit_{};  ///< u, v and t mean nothing
  std::uint64_t key_ = 0;
  std::uint32_t step_ = 0;  ///< of the spacing: exponent and first bit of the fraction
  glm::vec3 normal_{0}, direction_{0};
  std::array<int, 3> corner_{};  ///< the triangle's corners; the first is opposite the shortest edge
  int rows_ = 0;                 ///< the first corner not counted
  float last_row_ = 0;           ///< spacings along the shortest edge
  int fewer_ = 0;
  float reach_m_ = 0, turn_ = 0;
  const Mesh* shared_ = nullptr;  ///< set: points are vertices of it
};

}  // namespace dualpixel::simulator
