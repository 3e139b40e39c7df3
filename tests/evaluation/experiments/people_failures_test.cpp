#include <gtest/gtest.h>

#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "scenes/people/environment/lighting.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/photo/process_photo.h"
#include "scenes/people/photo/render.h"
#include "scenes/people/procedural_figure.h"
#include "tests/pipeline/segmentation/toy_network.h"

/// What finding people does where it must fail: rows of docs/segmentation.md.
namespace dualpixel::evaluation {
namespace {

constexpr int kWidth = 480, kHeight = 640;

/// A drawn figure's head and shoulders, linear, from the front or from behind.
Image portrait_of(std::uint64_t seed, bool from_behind) {
  scenes::SceneModel scene;
  scenes::FigureOptions options;
  options.meters_per_px = 0.0015f;
  options.lowest_m = 0.8f;
  const scenes::Figure figure = scenes::add_figure(scene, scenes::RandomStream(seed, false), options);
  scenes::set_lighting(scene, scenes::RandomStream(seed, false).substream(7));
  scenes::CameraSetup plan;
  const glm::vec3 head = figure.skeleton.head.origin;
  plan.target = head - glm::vec3(0, 0.1f, 0);
  plan.eye = head + glm::vec3(0.1f, 0, from_behind ? -2 : 2);
  plan.height_m = 0.9f;
  plan.width_px = kWidth;
  plan.height_px = kHeight;
  const scenes::RayTracer tracer(scene);
  Image light = scenes::render(tracer, scenes::make_camera(plan), 1, seed).light;
  scenes::set_mean_luminance(light, {}, 0.2f);
  return light;
}

TEST(SlowPeopleFailures, TheBackOfAHeadIsNoFace) {
  if (!pipeline::has_face_detector()) GTEST_SKIP() << "built without oneDNN";
  constexpr int kFigures = 10;
  int from_front = 0, from_behind = 0;
  for (int seed = 1; seed <= kFigures; ++seed) {
    from_front += pipeline::find_faces(portrait_of(seed, false)).empty() ? 0 : 1;
    from_behind += pipeline::find_faces(portrait_of(seed, true)).empty() ? 0 : 1;
  }
  RecordProperty("found_from_the_front", from_front);
  EXPECT_EQ(from_behind, 0);
  EXPECT_GT(from_front, 0);
}

TEST(SlowPeopleFailures, APosterOfAFaceIsTakenForAPerson) {
  if (!pipeline::has_person_network() || !pipeline::has_face_detector()) GTEST_SKIP() << "built without";
  // A picture within the picture: nothing in one photograph tells it from somebody behind a window.
  Image portrait;
  for (int seed = 1; seed < 50 && portrait.data.empty(); ++seed) {
    const Image candidate = portrait_of(seed, false);
    if (!pipeline::find_faces(candidate).empty()) portrait = candidate;
  }
  ASSERT_FALSE(portrait.data.empty());
  Image wall(kWidth + 160, kHeight + 80, 3, 0.25f);  // its face is more than 1.3 % of it
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) wall.at(80 + x, 40 + y, c) = portrait.at(x, y, c);
    }
  }
  pipeline::PersonNetwork network(pipeline::face_follower());
  EXPECT_TRUE(anybody_seen(pipeline::find_people(wall, {}, network)));
}

}  // namespace
}  // namespace dualpixel::evaluation
