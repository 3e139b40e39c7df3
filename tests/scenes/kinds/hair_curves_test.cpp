// Strands of hair on a ball, against what their parameters say; and that drawn people have them.
#include "scenes/kinds/hair_curves.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/kinds/portrait_people.h"
#include "simulator/simulate.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

constexpr float kBall_m = 0.1f, kHair_m = 0.06f;
constexpr std::size_t kPoints = 7;  // of a strand

/// A ball about the middle of a standing person's skull, with triangles of 3 mm.
SceneObject ball_of_hair(vec3 middle) {
  constexpr unsigned kRows = 100, kColumns = 200;
  SceneObject ball;
  ball.hair_m = kHair_m;
  for (unsigned i = 0; i <= kRows; ++i) {
    for (unsigned j = 0; j <= kColumns; ++j) {
      const float theta = std::numbers::pi_v<float> * static_cast<float>(i) / kRows,
                  phi = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / kColumns;
      const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      ball.positions.push_back(middle + kBall_m * n);
      ball.rest.push_back(kBall_m * n);
      ball.normals.push_back(n);
    }
  }
  for (unsigned i = 0; i < kRows; ++i) {
    for (unsigned j = 0; j < kColumns; ++j) {
      const unsigned a = i * (kColumns + 1) + j, b = a + kColumns + 1;
      if (i > 0) ball.triangles.push_back({a, a + 1, b + 1});
      if (i + 1 < kRows) ball.triangles.push_back({a, b + 1, b});
    }
  }
  return ball;
}

HairCurves hair_on(vec3 middle, const Figure& figure) {
  Material brown;
  brown.kind = Material::Kind::hair;
  return grow_hair(ball_of_hair(middle), brown, figure, RandomStream(2, false));
}

struct HairyBall {
  vec3 middle;
  HairCurves hair;
  std::size_t strands;

  HairyBall() {
    const Figure figure = pose_figure(RandomStream(1, false), {});
    middle = figure.skeleton.head.origin + vec3(0, 0.05f, 0);
    hair = hair_on(middle, figure);
    strands = hair.points.size() / kPoints;
  }
  const vec3* strand(std::size_t i) const { return &hair.points[kPoints * i]; }
  float height_m(vec3 p) const { return glm::length(p - middle) - kBall_m; }
};

const HairyBall& hairy_ball() {
  static const HairyBall ball;
  return ball;
}

TEST(HairCurves, AreTheSameForAnyThreads) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const HairCurves hair = hair_on(hairy_ball().middle, pose_figure(RandomStream(1, false), {}));
  EXPECT_EQ(hair.points, hairy_ball().hair.points);
  EXPECT_EQ(hair.segments, hairy_ball().hair.segments);
}

TEST(HairCurves, GrowOnNothing) {
  EXPECT_TRUE(grow_hair({}, {}, pose_figure(RandomStream(1, false), {}), RandomStream(2, false)).points.empty());
}

TEST(HairCurves, AreAsManyAsTheAreaSaysEvenlySpread) {
  const HairyBall& ball = hairy_ball();
  const double area = 4 * std::numbers::pi * kBall_m * kBall_m;
  EXPECT_NEAR(static_cast<double>(ball.strands), 300000 * area, 1e-3 * 300000 * area);  // triangles lie below the ball
  vec3 sum(0);
  for (std::size_t i = 0; i < ball.strands; ++i) {
    EXPECT_NEAR(ball.height_m(ball.strand(i)[0]), 0, 1e-4);
    sum += ball.strand(i)[0] - ball.middle;
  }
  const auto n = static_cast<float>(ball.strands);
  const float sigma_m = kBall_m / std::sqrt(3 * n);  // of each coordinate's mean
  // of each sixteenth of the unit interval a stream draws from the first four fifths: .00625 too low in the mean
  const float bias_m = 2 * kBall_m * 0.00625f;
  for (int k = 0; k < 3; ++k) EXPECT_LT(std::abs(sum[k] / n), bias_m + 4 * sigma_m) << k;
}

TEST(HairCurves, TaperAndKeepTheirColor) {
  const HairyBall& ball = hairy_ball();
  ASSERT_EQ(ball.hair.widths_m.size(), kPoints * ball.strands);
  ASSERT_EQ(ball.hair.segments.size(), (kPoints - 1) * ball.strands);
  for (std::size_t i = 0; i < ball.strands; ++i) {
    for (std::size_t s = 0; s < kPoints; ++s) {
      const double along = static_cast<double>(s) / (kPoints - 1);
      ASSERT_NEAR(ball.hair.widths_m[kPoints * i + s], 0.00022 * (1 - 0.7 * along * along), 1e-8);
      ASSERT_EQ(ball.hair.colors[kPoints * i + s], ball.hair.colors[kPoints * i]);
    }
    for (std::size_t s = 0; s + 1 < kPoints; ++s)
      ASSERT_EQ(ball.hair.segments[(kPoints - 1) * i + s], glm::uvec2(kPoints * i + s, kPoints * i + s + 1));
  }
}

/// A stray stands off by a fifth of its length, at least 6 mm; others lie within 4.8 mm, times 1.3 at their ends.
bool is_stray(const HairyBall& ball, std::size_t i) {
  return ball.height_m(ball.strand(i)[kPoints - 1]) > 1.3f * 0.0048f;
}

TEST(HairCurves, LieOnTheMassButForTwoInAHundred) {
  const HairyBall& ball = hairy_ball();
  double strays = 0, length = 0;
  for (std::size_t i = 0; i < ball.strands; ++i) {
    if (is_stray(ball, i)) {
      ++strays;
      continue;
    }
    for (std::size_t s = 0; s < kPoints; ++s) {
      ASSERT_GT(ball.height_m(ball.strand(i)[s]), -1e-4f) << i;
      if (s > 0) length += glm::length(ball.strand(i)[s] - ball.strand(i)[s - 1]);
    }
  }
  const auto n = static_cast<double>(ball.strands);
  EXPECT_NEAR(strays, 0.02 * n, 4 * std::sqrt(0.02 * 0.98 * n));
  EXPECT_NEAR(length / (n - strays), 0.95 * kHair_m,
              0.03 * kHair_m);  // .5 to 1.4 of it, evenly; rising makes it longer
}

TEST(SlowHairCurves, DrawnPeopleHaveThemAsPartOfThePerson) {
  const TemporaryFolder folder;
  SceneBuilder build;
  for (std::uint64_t i = 0; i < 4; ++i)  // one of them may be bald, or wear a hat
    add_person(build, RandomStream(5 + i, false), {.foot = {static_cast<float>(i), 0, -2}, .lowest_m = 0.4f});
  build.ambient(vec3(1000));
  build.camera({0, 1.5f, 0}, {0, 1.5f, -1});
  build.glb.write(folder / "scene.glb");
  build.scene["camera"]["focus_distance_m"] = 1;
  const simulator::Scene scene = simulator::load_scene(simulator::read_simulation(build.scene, folder / "scene.json"));
  EXPECT_EQ(scene.warnings, std::vector<std::string>());
  int heads = 0;
  for (const simulator::Mesh& mesh : scene.meshes) {
    EXPECT_TRUE(mesh.person);
    if (!mesh.is_hair()) continue;
    heads += mesh.triangles.size() > 6 * 3000 ? 1 : 0;
    EXPECT_NEAR(*std::max_element(mesh.radii.begin(), mesh.radii.end()), 0.00011, 1e-8);
  }
  EXPECT_GE(heads, 2);
}

}  // namespace
}  // namespace dualpixel::scenes
