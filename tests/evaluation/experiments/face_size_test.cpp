#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pipeline/defocus/mask_blur.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/procedural_figure.h"
#include "scenes/people/truth.h"

/// What a face's box is worth: brow to chin, 0.15 m, by which mode seg knows the distance.
namespace dualpixel::evaluation {
namespace {

// The radius of a pupil of 12.3 mm focused on a face at d m, for infinity behind it: 12.3e-3 f / (2 d) pixels, where a
// camera has f pixels of focal length.
TEST(FaceSize, BlursADrawnFaceAsThePupilDoesAtItsDistance) {
  constexpr double kDistance_m = 1.2, kPupil_m = 12.3e-3;
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; ratios.size() < 16; ++seed) {
    scenes::SceneModel scene;
    scenes::FigureOptions options;
    options.meters_per_px = 0.02f;
    options.lowest_m = 1.2f;
    const scenes::Figure figure = scenes::add_figure(scene, scenes::RandomStream(seed, false), options);
    if (figure.body.child) continue;
    const scenes::Frame& head = figure.skeleton.head;
    const glm::vec3 face = head.to_world({0, -0.03f, 0.07f});  // between brow and chin
    scenes::CameraSetup plan;
    plan.target = face;
    plan.eye = face + static_cast<float>(kDistance_m) * head.axes[2];
    plan.height_m = 0.9f;
    plan.width_px = 2688;  // for which MaskBlurOptions has radii
    plan.height_px = 2016;
    const double focal_px = kDistance_m * plan.height_px / plan.height_m;
    const double side_px = scenes::face_box(figure, scenes::make_camera(plan)).z;
    const double radius_px = pipeline::blur_for_face(side_px, plan.width_px).radius_px;
    ratios.push_back(radius_px / (kPupil_m * focal_px / (2 * kDistance_m)));
  }
  double mean = 0, square = 0;
  for (const double ratio : ratios) mean += ratio / 16, square += ratio * ratio / 16;
  const double error = std::sqrt((square - mean * mean) / 15);
  RecordProperty("mean", std::to_string(mean));
  RecordProperty("standard_error", std::to_string(error));
  // men's and women's heads differ by 5 %, of whom chance draws more of either; 0.15 m is rounded to 2 %
  EXPECT_NEAR(mean, 1, 3 * error + 0.02) << error;
  EXPECT_LT(error, 0.015);
}

}  // namespace
}  // namespace dualpixel::evaluation
