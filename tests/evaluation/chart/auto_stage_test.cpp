#include "evaluation/chart/auto_stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

// What `portrait --auto` promises, on the scenes that it was charted on. Promises are 1 to 3 % above what was measured.
TEST(SlowAuto, ErrsNoMoreThanPromised) {
  const std::span<const pipeline::DisparitySetting> settings = pipeline::disparity_settings();
  std::vector<double> squares(settings.size());
  const TemporaryFolder folder;
  for (int i = 0; i < auto_scene_count(); ++i) {
    const Capture capture = simulate_auto_scene(i, folder.path.string());
    for (std::size_t k = 0; k < settings.size(); ++k) {
      squares[k] += std::pow(disparity_error(capture, settings[k]), 2) / auto_scene_count();
    }
  }
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < settings.size(); ++k) {
    const double error = std::sqrt(squares[k]);
    EXPECT_LT(error, settings[k].error_dp_px) << settings[k].name;
    EXPECT_LT(error, 1.005 * least) << settings[k].name;  // slower ones are worth their time, whatever rounds
    least = error;
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
