#include "evaluation/experiments/burst_experiment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/failures/atlas_scene.h"
#include "pipeline/burst/merge.h"

namespace dualpixel::evaluation {
namespace {

Capture wall_at_rest(int frames) {
  AtlasScene scene{focused_for(atlas_camera("thin"), 24), 0};
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), 3);
  scene.document["burst"] = {{"frames", frames}};
  return take_burst(scene);
}

// The noise of 30720 pixels is known to .4 %, that of a merge to 2.5 %.
TEST(SlowBurstExperiment, AtRestTheMergeKeepsTheNoiseThatItStates) {
  const Capture burst = wall_at_rest(6);
  const std::vector<BurstPoint> points = measure_burst(burst, burst, {1, 3, 6});
  EXPECT_NEAR(points[0].merge.views_kept, 1, 1e-5);  // transforms in float
  EXPECT_NEAR(points[1].merge.views_kept / std::sqrt(pipeline::merged_view_variance(3)), 1, 0.03);
  EXPECT_NEAR(points[2].merge.views_kept / std::sqrt(pipeline::merged_view_variance(6)), 1, 0.03);
  for (const BurstPoint& point : points) EXPECT_LT(point.merge.ghost_share, 0.002);  // 6e-5, of 1920 squares
  EXPECT_FALSE(points[2].portrait_db.has_value());                                   // the same picture
  EXPECT_GT(points[1].portrait_db.value(), points[0].portrait_db.value());
}

// The likeness of moved tiles is doubted: half of the frames may be lost so, but no more.
TEST(SlowBurstExperiment, AShakenBurstGainsByMoreFrames) {
  const Capture burst = take_shaken_burst(5, 1);
  const std::vector<BurstPoint> points = measure_merge(burst, {1, 2, 4, 15});
  for (std::size_t i = 1; i < points.size(); ++i) {
    const int frames = points[i].frames;
    EXPECT_LT(points[i].merge.views_kept, points[i - 1].merge.views_kept);
    EXPECT_LT(points[i].merge.views_kept, std::sqrt(2.0 / frames)) << frames;
  }
  EXPECT_NE(take_shaken_burst(5, 2).frames[0].left.data, burst.frames[0].left.data);
}

// 64 of 1920 squares of the first frame are off by some twelve times their noise.
TEST(SlowBurstExperiment, CountsGhosts) {
  Capture burst = wall_at_rest(1);
  const Exposure& exposure = burst.exposure;
  const double mean_dn = 0.5 * kAtlasLevel * (exposure.white_level_dn - exposure.black_level_dn);
  const double sigma_dn = std::sqrt(exposure.dp_noise.shot_dn * mean_dn + exposure.dp_noise.read_dn2);
  for (int y = 48; y < 80; ++y) {
    for (int x = 64; x < 96; ++x) {
      burst.frames[0].left.at(x, y) += static_cast<std::uint16_t>(std::lround(3 * sigma_dn));
    }
  }
  const BurstPoint point = measure_burst(burst, burst, {1}).front();
  EXPECT_NEAR(point.merge.ghost_share, 64 / 1920.0, 0.002);
}

}  // namespace
}  // namespace dualpixel::evaluation
