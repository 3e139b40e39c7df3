// The disparity that belongs to the photograph's blur, against the simulator's own and against a plane, which has one.
#include "evaluation/metrics/photograph_disparity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "evaluation/simulated_scene.h"

namespace dualpixel::evaluation {
namespace {

Capture small_capture(const std::string& scene, std::vector<std::string> more) {
  more.insert(more.end(), {"sensor.width_px=96", "sensor.height_px=72", "sensor.pixel_pitch_um=39.2", "burst.frames=1",
                           "render.samples_per_pixel=1", "render.photograph_samples_per_pixel=1",
                           "render.all_in_focus_samples_per_pixel=1"});
  return simulate_scene(DUALPIXEL_SCENES_DIR "/" + scene + ".json", more);
}

double spread(const Image& map) {
  const auto [low, high] = std::minmax_element(map.data.begin(), map.data.end());
  return *high - *low;
}

TEST(PhotographDisparity, OfAThinLensIsTheCapturesOwn) {
  const Capture capture = small_capture("slanted_planes", {"lens.file=../lens_models/phone_thin_4.4mm_f1.8.json"});
  const Image found = photograph_disparity(capture);
  double most = 0;
  for (std::size_t i = 0; i < found.data.size(); ++i) {
    most = std::max<double>(most, std::abs(found.data[i] - capture.truth->disparity_dp_px.data[i]));
  }
  EXPECT_GT(spread(found), 0.02);
  EXPECT_LT(most, 1e-5);  // floats of some .1, through which depth and disparity went
}

// A plane that faces the camera has one depth, so one blur through an ideal lens, however the capture's lens curves it.
TEST(PhotographDisparity, OfAPlaneIsFlatWhereTheLensIsNot) {
  Capture capture = small_capture("calibration_target",
                                  {"lens.file=../lens_models/phone_6p_4.2mm_f1.8.json", "camera.focus_distance_m=0.5"});
  EXPECT_GT(spread(capture.truth->disparity_dp_px), 5e-3);
  EXPECT_LT(spread(photograph_disparity(capture)), 1e-5);
  capture.truth->photograph_lens = "another";
  EXPECT_EQ(photograph_disparity(capture).data, capture.truth->disparity_dp_px.data);
}

}  // namespace
}  // namespace dualpixel::evaluation
