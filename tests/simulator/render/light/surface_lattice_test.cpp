#include "simulator/render/light/surface_lattice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "simulator/sampling/hash.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

Scene one_triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  Mesh mesh;
  mesh.positions = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  scene.meshes = {mesh};
  return scene;
}

glm::vec3 position(const Mesh& mesh, float u, float v) {
  return (1 - u - v) * mesh.positions[0] + u * mesh.positions[1] + v * mesh.positions[2];
}

glm::vec2 random_inside(int i) {
  float u = unit_float(static_cast<std::uint32_t>(hash(i, 1))), v = unit_float(static_cast<std::uint32_t>(hash(i, 2)));
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {u, v};
}

const glm::vec3 kView(0, 0, 1);

// A linear function comes back up to the inset of the points, whatever the triangle's shape: equilateral, a ribbon, a
// sliver, one smaller than the spacing.
TEST(SurfaceLattice, InterpolatesLinearFunctions) {
  const glm::vec3 triangles[][3] = {{{0, 0, 0}, {1, 0, 0}, {0.5f, 0.9f, 0}},
                                    {{0, 0, 0}, {0.01f, 0, 0}, {0.005f, 2, 0}},
                                    {{2, 0, 0}, {0, 0, 0}, {1, 1e-4f, 0}},
                                    {{0, 0, 0}, {0.01f, 0, 0}, {0, 0.01f, 0}}};
  const glm::vec3 slope(3, -2, 0);
  for (const auto& t : triangles) {
    const Scene scene = one_triangle(t[0], t[1], t[2]);
    for (float spacing : {0.5f, 0.06f, 0.011f}) {
      const TriangleLattice lattice(scene, {0, 0, 0, 0, 0, 0}, kView, spacing);
      for (int i = 0; i < 200; ++i) {
        const glm::vec2 at = random_inside(i);
        const LatticeCell cell = lattice.cell(at.x, at.y);
        float sum = 0, weights = 0;
        for (const LatticeCell::Row& row : cell.rows) {
          for (int side = 0; side < (row.pieces == 0 ? 1 : 2); ++side) {
            const LatticePoint point = lattice.point(row.row, row.left + side, row.pieces);
            const float weight = row.share * (row.pieces == 0 ? 1 : side == 1 ? row.beyond : 1 - row.beyond);
            EXPECT_GE(weight, -1e-5f);
            weights += weight;
            sum += weight * glm::dot(slope, position(scene.meshes[0], point.u, point.v));
          }
        }
        EXPECT_NEAR(weights, 1, 1e-5f);
        // points are moved by a fiftieth of a row, and one point stands for a row of up to half a spacing
        const float off = glm::length(slope) * (0.02f * spacing + 0.25f * spacing);
        EXPECT_NEAR(sum, glm::dot(slope, position(scene.meshes[0], at.x, at.y)), off + 1e-4f);
      }
    }
  }
}

// Neighbors lie at most a spacing apart, and a ribbon of a hundredth of its length takes about as many points as it is
// spacings long.
TEST(SurfaceLattice, PointsAreAsDenseAsAsked) {
  const auto points_of = [](const Scene& scene, float spacing) {
    const TriangleLattice lattice(scene, {0, 0, 0, 0, 0, 0}, kView, spacing);
    std::map<std::uint64_t, glm::vec2> points;
    for (int i = 0; i < 20000; ++i) {
      const glm::vec2 at = random_inside(i);
      float nearest = 1e9f;
      for (const LatticeCell::Row& row : lattice.cell(at.x, at.y).rows) {
        for (int side = 0; side < (row.pieces == 0 ? 1 : 2); ++side) {
          const LatticePoint point = lattice.point(row.row, row.left + side, row.pieces);
          points[point.key] = {point.u, point.v};
          const glm::vec3 apart = position(scene.meshes[0], at.x, at.y) - position(scene.meshes[0], point.u, point.v);
          nearest = std::min(nearest, glm::length(apart));
        }
      }
      EXPECT_LE(nearest, spacing);
    }
    return points.size();
  };
  const std::size_t square = points_of(one_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 0.0625f);
  EXPECT_GT(square, 150u);  // 16 x 16 / 2 cells
  EXPECT_LT(square, 400u);
  const std::size_t ribbon = points_of(one_triangle({0, 0, 0}, {0.01f, 0, 0}, {0.005f, 1, 0}), 0.0625f);
  EXPECT_GE(ribbon, 17u);
  EXPECT_LE(ribbon, 20u);
}

// Triangles smaller than the spacing share their vertices' points, each side its own; without normals they share none.
TEST(SurfaceLattice, SmallTrianglesShareVertices) {
  Scene scene = one_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scene.meshes[0].positions.push_back({1, 1, 0});
  scene.meshes[0].triangles.push_back({1, 3, 2});
  const auto keys_of = [&](glm::vec3 view) {
    std::set<std::uint64_t> keys;
    for (unsigned triangle : {0u, 1u}) {
      const TriangleLattice lattice(scene, {0, 0, triangle, 0, 0, 0}, view, 1.5f);
      for (const LatticeCell::Row& row : lattice.cell(0.3f, 0.3f).rows) {
        for (int side = 0; side < (row.pieces == 0 ? 1 : 2); ++side) {
          keys.insert(lattice.point(row.row, row.left + side, row.pieces).key);
        }
      }
    }
    return keys;
  };
  EXPECT_GT(keys_of(kView).size(), 4u);
  scene.meshes[0].normals.assign(4, glm::vec3(0, 0, 1));
  const std::set<std::uint64_t> front = keys_of(kView), back = keys_of(-kView);
  EXPECT_EQ(front.size(), 4u);
  EXPECT_EQ(back.size(), 4u);
  for (std::uint64_t key : back) EXPECT_EQ(front.count(key), 0u);
}

// Normals that turn by a right angle along edges of 1 and 1.4 m: by a quarter of their difference between points .25 m
// apart, by all of it in a triangle that is smaller than the spacing. In one far smaller it does not count.
TEST(SurfaceLattice, KnowsHowFarTheSurfaceTurnsBetweenPoints) {
  Scene scene = one_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const auto lattice = [&](float spacing_m) { return TriangleLattice(scene, {0, 0, 0, 0, 0, 0}, kView, spacing_m); };
  EXPECT_EQ(lattice(0.25f).turn(), 0);
  scene.meshes[0].normals = {{0, 0, 1}, {1, 0, 0}, {0, 0, 1}};
  EXPECT_FLOAT_EQ(lattice(0.25f).turn(), std::sqrt(2.0f) / 4);
  EXPECT_FLOAT_EQ(lattice(0.25f).reach_m(), 0.25f);
  EXPECT_FLOAT_EQ(lattice(4).turn(), std::sqrt(2.0f));
  EXPECT_FLOAT_EQ(lattice(4).reach_m(), std::sqrt(2.0f));
  EXPECT_EQ(lattice(8).turn(), 0);
}

// Keys tell apart sides, spacings, triangles, placements and points.
TEST(SurfaceLattice, KeysAreDifferent) {
  Scene scene = one_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes[1].placements.resize(2);
  std::set<std::uint64_t> keys;
  std::size_t count = 0;
  for (const Hit& hit : {Hit{0, 0, 0, 0, 0, 0}, Hit{0, 1, 0, 0, 0, 0}, Hit{0, 1, 0, 0, 0, 1}}) {
    for (float side : {1.0f, -1.0f}) {
      for (float spacing : {0.25f, 0.125f}) {
        const TriangleLattice lattice(scene, hit, side * kView, spacing);
        for (int piece = 0; piece <= 4; ++piece, ++count) keys.insert(lattice.point(4, piece, 4).key);
      }
    }
  }
  EXPECT_EQ(keys.size(), count);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
