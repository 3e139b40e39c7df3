// A camera that stands in something, or shows nothing, is told so.
#include "scenes/drawn/free_view.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "scenes/drawn/meter.h"
#include "scenes/shapes/solids.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

/// A camera at the origin that looks along -z at what `add` puts there, under an even sky.
std::vector<std::string> faults_of(const std::function<void(SceneBuilder&)>& add, double stops = 0) {
  const TemporaryFolder folder;
  SceneBuilder build;
  build.scene["sensor"] = {{"width_px", 256}, {"height_px", 192}, {"pixel_pitch_um", 14.7}};
  build.scene["render"] = {{"max_bounces", 0}};
  build.ambient(vec3(1000));
  build.camera({0, 0, 0}, {0, 0, -1});
  build.shooting.clear_m = 0.5f;
  add(build);
  build.glb.write(folder / "scene.glb");
  return meter(build.scene, folder / "scene.json", build.shooting, 1, stops);
}

void add_box(SceneBuilder& build, vec3 middle, vec3 half, float gray = 0.5f) {
  Mesh box;
  add_solid_box(box, middle, half);
  build.add("box", box, Surface{.color = vec3(gray)});
}

/// Two walls, a dark and a bright one.
void add_walls(SceneBuilder& build) {
  add_box(build, {-2, 0, -3}, {2, 3, 0.1f}, 0.2f);
  add_box(build, {2, 0, -3}, {2, 3, 0.1f}, 0.6f);
}

void expect_fault(const std::vector<std::string>& faults, const std::string& words) {
  ASSERT_FALSE(faults.empty()) << words;
  EXPECT_NE(faults[0].find(words), std::string::npos) << faults[0];
}

TEST(FreeView, NothingIsWrongWithWallsSomeWayOff) { EXPECT_TRUE(faults_of(add_walls).empty()); }

TEST(FreeView, TheCameraStandsInFreeSpace) {
  expect_fault(faults_of([](SceneBuilder& build) {
                 add_walls(build);
                 add_box(build, {0, -0.07f, 0}, {0.3f, 0.05f, 0.3f});  // 2 cm below the lens, out of the picture
               }),
               "from the camera");
  expect_fault(faults_of([](SceneBuilder& build) { add_box(build, {0, 0, 0}, {0.3f, 0.3f, 0.3f}); }), "shut in");
}

TEST(FreeView, NothingNearFillsThePicture) {
  const auto near_box = [](float left) {
    return [left](SceneBuilder& build) {
      add_walls(build);
      add_box(build, {left + 1, 0, -0.3f}, {1, 1, 0.01f});
    };
  };
  expect_fault(faults_of(near_box(0)), "of the picture are nearer");  // its right half
  EXPECT_TRUE(faults_of(near_box(0.1f)).empty());                     // a tenth
}

TEST(FreeView, SomethingIsSeen) {
  expect_fault(faults_of([](SceneBuilder& build) { add_box(build, {0, 0, -30}, {1, 1, 1}); }), "show anything");
  expect_fault(faults_of([](SceneBuilder& build) { add_box(build, {0, 0, -3}, {4, 4, 0.1f}); }), "even surface");
}

TEST(FreeView, TheSubjectIsInThePictureAndNotHidden) {
  const auto with_subject = [](vec3 subject, bool hidden) {
    return [=](SceneBuilder& build) {
      add_walls(build);
      build.focus_on(subject);
      if (hidden) add_box(build, 0.55f * subject, vec3(0.05f));
    };
  };
  EXPECT_TRUE(faults_of(with_subject({0.2f, 0, -2}, false)).empty());
  expect_fault(faults_of(with_subject({0.2f, 0, -2}, true)), "hides the subject");
  expect_fault(faults_of(with_subject({2, 0, -2}, false)), "out of the picture");
  expect_fault(faults_of(with_subject({0, 0, 2}, false)), "out of the picture");
}

TEST(FreeView, LightMustSuitAnExposure) {
  EXPECT_TRUE(faults_of(add_walls, -3).empty());
  expect_fault(faults_of(add_walls, 20), "at ISO 100");  // 2^20 times what gives a picture
  // The walls' geometric mean is .35 of what is around them, so that 1 nit takes 2.9 s at ISO 100; 10.7 s are the most.
  const auto by_night = [](float nits) {
    return [nits](SceneBuilder& build) {
      add_walls(build);
      build.ambient(vec3(nits));
    };
  };
  EXPECT_TRUE(faults_of(by_night(0.18f)).empty());  // less than a stop too dark
  EXPECT_TRUE(faults_of(by_night(0.18f), -1).empty());
  expect_fault(faults_of(by_night(0.18f), 0.5), "the limit is 10.7 s");
  expect_fault(faults_of(by_night(0.1f)), "the limit is 10.7 s");
  EXPECT_TRUE(faults_of(by_night(0.1f), -1).empty());
}

}  // namespace
}  // namespace dualpixel::scenes
