#include "simulator/render/light/surface_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "simulator/sampling/hash.h"

namespace dualpixel::simulator {
namespace {

constexpr std::uint64_t kRow = 0x9e3779b97f4a7c15, kPiece = 0xd1b54a32d192ed03;  // odd, as in a linear hash

std::uint32_t step_of(float spacing_m) { return std::bit_cast<std::uint32_t>(spacing_m) >> 22; }

/// Difference of the normals of two vertices, or of points a spacing apart on the edge between them.
float turn_along(const glm::vec3& normal, const glm::vec3& other, float edge_m, float spacing_m) {
  if (!(edge_m > spacing_m / 4)) return 0;
  return glm::distance(normal, other) * std::min(spacing_m / edge_m, 1.0f);
}

/// Rows and pieces of one triangle that are told apart: points of a millionth of its edge.
constexpr float kMost = 1 << 20;

/// Moves a point a little towards the middle of its triangle: one on an edge would lie in the plane of the wall that
/// stands there, and light could reach it from behind.
constexpr float kInset = 0.02f;  // of a row

}  // namespace

TriangleLattice::TriangleLattice(const Scene& scene, const Hit& hit, glm::vec3 direction, float spacing_m)
    : hit_(hit), step_(step_of(spacing_m)), direction_(direction) {
  const Mesh& mesh = scene.meshes[hit.mesh];
  const glm::uvec3& t = mesh.triangles[hit.triangle];
  std::array<glm::vec3, 3> edge;  // edge[i] is opposite corner i
  for (int i = 0; i < 3; ++i) edge[i] = mesh.positions[t[(i + 2) % 3]] - mesh.positions[t[(i + 1) % 3]];
  if (mesh.placements.empty()) {
    hit_.placement = 0;
  } else {
    const glm::mat3 placed(mesh.placements[hit.placement].world_from_mesh);
    for (glm::vec3& e : edge) e = placed * e;
  }
  normal_ = glm::cross(edge[2], edge[0]);
  std::array<float, 3> squared;
  for (int i = 0; i < 3; ++i) squared[i] = glm::dot(edge[i], edge[i]);
  const int apex = static_cast<int>(std::min_element(squared.begin(), squared.end()) - squared.begin());
  corner_ = {apex, (apex + 1) % 3, (apex + 2) % 3};
  const float spacing = this->spacing_m(), per_m = 1 / spacing;
  const float longest = std::sqrt(std::max(squared[corner_[1]], squared[corner_[2]])), rows = longest * per_m;
  rows_ = static_cast<int>(std::clamp(std::ceil(rows), 1.0f, kMost));
  fewer_ = rows > 0.5f ? 0 : rows > 0.25f ? 1 : 2;
  reach_m_ = std::min(longest, spacing);
  for (int i = 0; i < 3 && !mesh.normals.empty(); ++i) {
    const glm::vec3 &normal = mesh.normals[t[(i + 1) % 3]], &other = mesh.normals[t[(i + 2) % 3]];
    turn_ = std::max(turn_, turn_along(normal, other, std::sqrt(squared[i]), spacing));
  }
  if (rows_ == 1 && !mesh.normals.empty() && mesh.placements.empty()) shared_ = &mesh;
  last_row_ = std::min(std::sqrt(squared[apex]) * per_m, kMost);
  const bool behind = glm::dot(normal_, direction) > 0;
  key_ = hash(std::uint64_t{hit.mesh} << 32 | hit.triangle,
              std::uint64_t{hit_.placement} << 16 | std::uint64_t{step_} << 1 | (behind ? 1 : 0));
}

bool TriangleLattice::is_of(const Hit& hit, glm::vec3 direction, float spacing_m) const {
  return rows_ > 0 && hit.mesh == hit_.mesh && hit.triangle == hit_.triangle && hit.placement == hit_.placement &&
         step_of(spacing_m) == step_ && (glm::dot(normal_, direction) > 0) == (glm::dot(normal_, direction_) > 0);
}

float TriangleLattice::spacing_m() const { return std::bit_cast<float>(step_ << 22); }

int TriangleLattice::pieces_of(int row) const {
  if (shared_) return row;
  const float length = last_row_ * static_cast<float>(row) / static_cast<float>(rows_);
  return length < 0.5f ? 0 : static_cast<int>(std::ceil(length));
}

LatticeCell TriangleLattice::cell(float u, float v) const {
  const std::array<float, 3> weight = {1 - u - v, u, v};
  const float t = std::clamp(1 - weight[corner_[0]], 0.0f, 1.0f);
  const float x = t > 0 ? std::clamp(weight[corner_[2]] / t, 0.0f, 1.0f) : 0.0f;
  const float at = t * static_cast<float>(rows_);
  const int low = std::min(static_cast<int>(at), rows_ - 1);
  LatticeCell cell;
  for (int k = 0; k < 2; ++k) {
    LatticeCell::Row& row = cell.rows[k];
    row.row = low + k;
    row.share = k == 0 ? 1 - (at - static_cast<float>(low)) : at - static_cast<float>(low);
    row.pieces = pieces_of(row.row);
    if (row.pieces == 0) continue;
    const float along = x * static_cast<float>(row.pieces);
    row.left = std::min(static_cast<int>(along), row.pieces - 1);
    row.beyond = along - static_cast<float>(row.left);
  }
  return cell;
}

std::uint64_t TriangleLattice::key_of(const LatticeCell& cell) const {
  const std::uint64_t lefts = std::uint64_t(cell.rows[0].left) << 32 | unsigned(cell.rows[1].left);
  return hash(key_ + cell.rows[0].row * kRow + lefts * kPiece) | 1;
}

LatticePoint TriangleLattice::vertex_point(int row, int piece) const {
  const int corner = corner_[row + piece];
  const unsigned vertex = shared_->triangles[hit_.triangle][corner];
  LatticePoint point;
  point.vertex = static_cast<int>(vertex);
  point.behind = glm::dot(shared_->normals[vertex], view()) > 0;
  const std::uint64_t side = std::uint64_t{step_} << 3 | std::uint64_t(fewer_) << 1 | (point.behind ? 1 : 0);
  point.group = hash(std::uint64_t{hit_.mesh} << 32 | vertex >> 4, side);
  point.key = hash(point.group + vertex * kRow) | 1;
  return point;
}

LatticePoint TriangleLattice::point(int row, int piece, int pieces) const {
  if (shared_) return vertex_point(row, piece);
  const float inset = kInset / static_cast<float>(rows_);
  const float t = static_cast<float>(row) / static_cast<float>(rows_);
  const float along = pieces == 0 ? 0.5f : static_cast<float>(piece) / static_cast<float>(pieces);
  std::array<float, 3> weight{};
  weight[corner_[0]] = 1 - t;
  weight[corner_[1]] = t * (1 - along);
  weight[corner_[2]] = t * along;
  LatticePoint point;
  point.key = hash(key_ + row * kRow + piece * kPiece) | 1;
  point.group = key_ + (row >> 3) * kRow + (piece >> 3) * kPiece;
  point.u = weight[1] + inset * (1.0f / 3 - weight[1]);
  point.v = weight[2] + inset * (1.0f / 3 - weight[2]);
  return point;
}

}  // namespace dualpixel::simulator
