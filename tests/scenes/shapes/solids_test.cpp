// Solids: closed surfaces of the size that was asked for, with normals that point outward and UVs in meters.
#include "scenes/shapes/solids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

double area(const Mesh& mesh) {
  double sum = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const vec3 p = mesh.positions[t.x];
    sum += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p));
  }
  return sum;
}

/// Smallest cosine between a vertex's normal and the way from `center`.
float least_outward(const Mesh& mesh, vec3 center) {
  float least = 1;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    least = std::min(least, glm::dot(mesh.normals[i], glm::normalize(mesh.positions[i] - center)));
  }
  return least;
}

TEST(Solids, SharpBoxHasItsArea) {
  Mesh box;
  add_solid_box(box, {1, 2, 3}, {0.1f, 0.2f, 0.3f});
  EXPECT_EQ(box.triangles.size(), 12U);
  EXPECT_NEAR(area(box), 8 * (0.1 * 0.2 + 0.2 * 0.3 + 0.3 * 0.1), 1e-5);
  EXPECT_GT(least_outward(box, {1, 2, 3}), 0);
}

TEST(Solids, RoundedBoxIsAChamferedOne) {
  Mesh box;
  const double a = 0.5, e = 0.1, face = 2 * (a - e), edge = std::numbers::sqrt2 * e;
  add_solid_box(box, vec3(0), vec3(0.5f), 0.1f);
  EXPECT_NEAR(area(box), 6 * face * face + 12 * face * edge + 8 * std::sqrt(3.0) / 4 * edge * edge, 1e-5);
  EXPECT_GT(least_outward(box, vec3(0)), 0);
}

TEST(Solids, BallAndLatheApproachTheirAreas) {
  Mesh ball, cylinder;
  add_ball(ball, {0, 1, 0}, vec3(0.2f), 48);
  EXPECT_NEAR(area(ball) / (4 * std::numbers::pi * 0.04), 1, 0.003);  // inscribed: 1 - pi^2 / (4 * 48^2) and less
  EXPECT_GT(least_outward(ball, {0, 1, 0}), 0.99f);
  add_lathe(cylinder, glm::mat4(1), {{0, 0}, {0.1f, 0}, {0.1f, 0.5f}, {0, 0.5f}}, 96);
  EXPECT_NEAR(area(cylinder) / (2 * std::numbers::pi * (0.01 + 0.05)), 1, 0.002);
  EXPECT_GT(least_outward(cylinder, {0, 0.25f, 0}), 0);
}

TEST(Solids, BumpyBallsNormalsFollowItsSurface) {
  Mesh ball;
  add_ball(ball, vec3(0), vec3(1), 64, [](vec3 n) { return 1 + 0.2f * n.y; });
  // r = 1 + .2 cos(theta): at the equator the normal leans by atan(.2) towards -y
  for (std::size_t i = 0; i < ball.positions.size(); ++i) {
    if (std::abs(ball.positions[i].y) > 0.01f) continue;
    EXPECT_NEAR(ball.normals[i].y, -std::sin(std::atan(0.2)), 0.01);
  }
}

TEST(Solids, PipeHasItsArea) {
  Mesh pipe;
  add_pipe(pipe, {{0, 0, 0}, {0, 1, 0}}, 0.1f, 64);
  EXPECT_NEAR(area(pipe) / (2 * std::numbers::pi * 0.1 + 2 * std::numbers::pi * 0.01), 1, 0.002);
}

TEST(Solids, SheetIsWhereItsFunctionSays) {
  Mesh sheet;
  add_sheet(sheet, 10, 20, {2, 3}, [](float u, float v) { return vec3(2 * u, 0, 3 * v); });
  EXPECT_NEAR(area(sheet), 6, 1e-4);
  EXPECT_EQ(sheet.uvs.back(), vec2(2, 3));
  for (const vec3& n : sheet.normals) EXPECT_NEAR(n.y, 1, 1e-5);
}

TEST(Meshes, FlatTrianglesAreDropped) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 0, 3}};
  drop_flat_triangles(mesh);
  ASSERT_EQ(mesh.triangles.size(), 1U);
  EXPECT_EQ(mesh.triangles[0], glm::uvec3(0, 1, 3));
}

TEST(Meshes, PlacingTurnsNormals) {
  Mesh mesh;
  add_solid_box(mesh, vec3(0), {1, 1, 1});
  const Mesh placed = placed_mesh(mesh, glm::scale(standing({0, 5, 0}, 0.5f), vec3(1, 2, 3)));
  EXPECT_NEAR(area(placed), 8 * (1 * 2 + 2 * 3 + 3 * 1), 1e-3);
  EXPECT_GT(least_outward(placed, {0, 5, 0}), 0);
}

}  // namespace
}  // namespace dualpixel::scenes
