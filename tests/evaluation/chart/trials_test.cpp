#include "evaluation/chart/trials.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/methods.h"
#include "tests/pipeline/portrait/synthetic.h"

namespace dualpixel::evaluation {
namespace {

/// Its photograph is what the default way of defocus makes of its truth through a pupil `factor` times that of truth.
Capture capture_with_photograph(double factor) {
  Capture capture = pipeline::synthetic_capture(128, 96);
  Truth& truth = *capture.truth;
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      for (int c = 0; c < 3; ++c) truth.all_in_focus.at(x, y, c) = 0.2f + (x / 8 + y / 8) % 2 * 0.6f;
    }
  }
  const double pupil_mm =
      factor * truth.photograph_aperture_scale * capture.camera.focal_length_mm / capture.camera.f_number;
  truth.photograph = pipeline::defocus_method_named("layers")
                         .render({truth.all_in_focus, truth.disparity_dp_px, truth.person_mask,
                                  pipeline::match_lens(capture.camera, pupil_mm, 0, true)},
                                 {})
                         .rgb;
  return capture;
}

TEST(Trials, DefocusIsJudgedAtThePhotographsPupil) {
  const std::vector<Trial> trials = try_defocus(capture_with_photograph(1));
  ASSERT_GE(trials.size(), 4u);
  std::size_t defaults = 0;
  for (const Trial& trial : trials) {
    EXPECT_GT(trial.time, 0) << trial.name;
    if (!trial.is_default) {
      // On one smooth surface other bands change next to nothing: 9e-4 and 5e-3 %; rounding of floats is 1e-5 %.
      EXPECT_GT(trial.error, trial.name.starts_with("layers") ? 1e-4 : 0.1) << trial.name;
      continue;
    }
    ++defaults;
    EXPECT_EQ(trial.name.find("layers"), 0u);
    EXPECT_LT(trial.error, 1e-5);  // percent of white: the same picture
  }
  EXPECT_EQ(defaults, 1u);
  for (const Trial& trial : try_defocus(capture_with_photograph(1.3))) EXPECT_GT(trial.error, 0.1) << trial.name;
}

TEST(Trials, PointsAreMeansOverCaptures) {
  const std::vector<ChartPoint> points =
      points_of({{{"a", 1, 10, 30, true}, {"b", 5, 2, 0}}, {{"a", 3, 14, 31, true}, {"b", 5, 4, 0}}});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].name, "a");
  EXPECT_TRUE(points[0].is_default && !points[1].is_default);
  EXPECT_EQ(points[0].error.value, 2);
  EXPECT_EQ(*points[0].error.standard_error, 1);  // deviation sqrt(2) of one value, over sqrt(2)
  EXPECT_EQ(points[0].time.value, 12);
  EXPECT_EQ(points[0].memory_mb, 30);
  EXPECT_EQ(points[1].error.value, 5);
  EXPECT_TRUE(points_of({}).empty());
}

}  // namespace
}  // namespace dualpixel::evaluation
