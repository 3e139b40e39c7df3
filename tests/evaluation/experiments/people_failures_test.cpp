#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "scenes/people/environment/lighting.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/photo/process_photo.h"
#include "scenes/people/photo/render.h"
#include "scenes/people/procedural_figure.h"
#include "scenes/people/truth.h"
#include "tests/pipeline/segmentation/toy_network.h"

/// What finding people does where it must fail: rows of docs/segmentation.md.
namespace dualpixel::evaluation {
namespace {

constexpr int kWidth = 480, kHeight = 640;

/// A drawn figure's head and shoulders, linear, from the front or from behind.
struct Drawn {
  Image light;
  glm::vec4 face;
};
Drawn portrait_of(std::uint64_t seed, bool from_behind) {
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
  const auto camera = scenes::make_camera(plan);
  Drawn drawn{scenes::render(tracer, camera, 1, seed).light, scenes::face_box(figure, camera)};
  scenes::set_mean_luminance(drawn.light, {}, 0.2f);
  return drawn;
}

TEST(SweepPeopleFailures, TheBackOfAHeadIsNoFace) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  constexpr int kFigures = 10;
  int from_front = 0, from_behind = 0;
  double width = 0;  // of what is found, over the truth's
  for (int seed = 1; seed <= kFigures; ++seed) {
    const Drawn front = portrait_of(seed, false);
    const std::vector<pipeline::Face> faces = pipeline::find_faces(front.light);
    from_front += faces.empty() ? 0 : 1;
    if (!faces.empty()) width += faces[0].width / front.face.z;
    from_behind += pipeline::find_faces(portrait_of(seed, true).light).empty() ? 0 : 1;
  }
  RecordProperty("found_from_the_front", from_front);
  RecordProperty("width_found", std::to_string(width / from_front));
  EXPECT_EQ(from_behind, 0);
  ASSERT_GT(from_front, kFigures / 2);
  // 1.046 of 14 frontal faces of 24 px and more, deviating by .06 (docs/segmentation.md): of ten, 3 standard errors
  EXPECT_NEAR(width / from_front, 1.046, 3 * 0.06 * std::sqrt(1.0 / 10 + 1.0 / 14));
}

TEST(SlowPeopleFailures, APosterOfAFaceIsTakenForAPerson) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without";
  // A picture within the picture: nothing in one photograph tells it from somebody behind a window.
  Image portrait;
  for (int seed = 1; seed < 50 && portrait.data.empty(); ++seed) {
    const Image candidate = portrait_of(seed, false).light;
    if (!pipeline::find_faces(candidate).empty()) portrait = candidate;
  }
  ASSERT_FALSE(portrait.data.empty());
  Image wall(960, 960, 3, 0.25f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) wall.at(240 + x, 160 + y, c) = portrait.at(x, y, c);
    }
  }
  pipeline::PersonNetwork network(pipeline::face_follower());
  EXPECT_TRUE(anybody_seen(pipeline::find_people(wall, {}, network)));
}

}  // namespace
}  // namespace dualpixel::evaluation
