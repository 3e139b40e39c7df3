#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "scenes/people/shape/primitives.h"
#include "tests/scenes/people/figures.h"

namespace dualpixel::scenes {
namespace {

TEST(PeopleRendering, MasksAreTheFractionOfEachPixelThatShowsAPerson) {
  const Pair pair = Pair::make(3);
  const RayTracer tracer(pair.scene);
  const Rendering exposure = render(tracer, pair.camera, 2, 5);
  // Independently: single rays through a 4 x 4 grid in every pixel. Both count 16 points, so at a pixel that an edge
  // crosses each errs by at most sqrt(1/4 / 16) = 1/8 (unstratified), all else agrees.
  std::array<double, 2> counted{}, summed{};
  double edge_pixels = 0;
  const auto& sensor = pair.camera.lens.sensor();
  for (int y = 0; y < sensor.height_px; ++y) {
    for (int x = 0; x < sensor.width_px; ++x) {
      std::array<int, 2> hits{};
      for (int i = 0; i < 16; ++i) {
        const int column = i % 4, row = i / 4;
        const auto at = sensor.middle_m(x + (column - 1.5) / 4, y + (row - 1.5) / 4);
        const simulator::Ray ray{
            vec3(pair.camera.world_from_camera[3]),
            mat3(pair.camera.world_from_camera) * vec3(pair.camera.lens.chief_slope(at.x, at.y), 1)};
        const auto hit = tracer.intersector().intersect(ray);
        const int person = hit ? pair.scene.objects[hit->mesh].person : kNoPerson;
        if (person >= 0) ++hits[person];  // a seat belongs to no person
      }
      for (int p = 0; p < 2; ++p) {
        counted[p] += hits[p] / 16.0;
        summed[p] += exposure.coverage.at(x, y, p);
        if (hits[p] == 0) {
          EXPECT_LE(exposure.coverage.at(x, y, p), 0.5f) << x << ' ' << y;
        }
        if (hits[p] > 0 && hits[p] < 16) edge_pixels += 1;
      }
    }
  }
  for (int p = 0; p < 2; ++p) {
    EXPECT_GT(counted[p], 500);
    EXPECT_NEAR(summed[p], counted[p], 4 * std::sqrt(2 * edge_pixels) / 8) << "person " << p;
  }
}

TEST(PeopleRendering, TwoPeopleShareNoPixelBeyondItsArea) {
  const Pair pair = Pair::make(7);
  const RayTracer tracer(pair.scene);
  const Rendering exposure = render(tracer, pair.camera, 2, 5);
  int shared = 0;
  for (std::size_t i = 0; i < exposure.coverage.pixel_count(); ++i) {
    const float a = exposure.coverage.data[2 * i], b = exposure.coverage.data[2 * i + 1];
    EXPECT_LE(a + b, 1 + 1e-6f);
    if (a > 0 && b > 0) ++shared;
  }
  EXPECT_GT(shared, 10);  // they do overlap in this picture
}

TEST(PeopleRendering, VisibilityFindsOccludersAndBystanders) {
  Upright upright{Pose{}};
  const auto found = [&] { return visibility_of(RayTracer(upright.scene), upright.camera); };
  EXPECT_EQ(found().occluded, 0);
  EXPECT_FALSE(found().bystanders);
  const auto add = [&](float z, int person) {
    SceneObject& board = upright.scene.objects.emplace_back();
    board.material = upright.scene.add({});
    board.person = person;
    add_box(board, {0, 0.4f, z}, mat3(1), {0.5f, 0.4f, 0.01f});
  };
  add(-0.5f, kNoPerson);
  EXPECT_EQ(found().occluded, 0);  // behind
  add(-0.6f, kBystander);
  EXPECT_FALSE(found().bystanders);  // behind the wall
  add(0.5f, kNoPerson);
  // it hides legs and hips: the ray from 1 m over its edge, 0.8 m high, meets the person at 0.77 m
  EXPECT_GT(found().occluded, 0.2f);
  EXPECT_LT(found().occluded, 0.6f);
  add(0.7f, kBystander);
  EXPECT_TRUE(found().bystanders);
}

}  // namespace
}  // namespace dualpixel::scenes
