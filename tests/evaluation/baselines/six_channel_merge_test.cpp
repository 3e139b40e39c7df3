#include "evaluation/baselines/six_channel_merge.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <random>
#include <vector>

#include "capture/error.h"
#include "tests/pipeline/burst/moving_burst.h"

namespace dualpixel::evaluation {
namespace {

using namespace pipeline;

constexpr int kWidth = 256, kHeight = 256;  // of a Bayer plane

std::vector<MotionField> constant_motions(const std::vector<Pose>& poses) {
  std::vector<MotionField> motions;
  for (const Pose& pose : poses) {
    MotionField& motion = motions.emplace_back(motion_tiles(kWidth), motion_tiles(kHeight), 2);
    for (std::size_t i = 0; i < motion.data.size(); i += 2) {
      motion.data[i] = static_cast<float>(pose.x);
      motion.data[i + 1] = static_cast<float>(pose.y);
    }
  }
  return motions;
}

double mean_square_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::pow(a.data[i] - b.data[i], 2);
  return sum / static_cast<double>(a.data.size());
}

TEST(SixChannelMerge, ASingleFrameReturnsAsItIs) {
  const Exposure exposure = exposure_at(100);
  const Frame frame = expose(see(Target(3), kWidth, kHeight, {}), exposure, 1);
  const MergedBurst merged = merge_six_channels({frame}, 0, constant_motions({{}}), exposure);
  EXPECT_LT(mean_square_difference(merged.mosaic, normalized(frame.mosaic, exposure)), 1e-12);
  EXPECT_LT(mean_square_difference(merged.left, normalized(frame.left, exposure)), 1e-12);
  EXPECT_LT(mean_square_difference(merged.right, normalized(frame.right, exposure)), 1e-12);
}

// Were P what it is on average, P = V, then A = 1 / (1 + 8) for every frame, and the merge of N frames would have
// 1/N + A^2 (1 - 1/N) of one frame's variance. P varies, so there is more; less than where a pair of planes shares its
// weight, as merge.h states it. Variances of 2^15 samples (views) are known to .8 %.
TEST(SixChannelMerge, AtRestItHasTheNoiseOfTheShrinkage) {
  const Exposure exposure = exposure_at(100);
  const Signals flat{Image(2 * kWidth, 2 * kHeight, 1, 0.4f), Image(kWidth, kHeight / 2, 1, 0.2f),
                     Image(kWidth, kHeight / 2, 1, 0.2f)};
  for (const int count : {3, 6, 9}) {
    std::vector<Frame> frames;
    for (int z = 0; z < count; ++z) frames.push_back(expose(flat, exposure, z + 1));
    const MergedBurst merged =
        merge_six_channels(frames, 0, constant_motions(std::vector<Pose>(frames.size())), exposure);
    const auto kept = [&](const Image& of_merged, const ImageU16& of_one, const Image& clean) {
      return mean_square_difference(of_merged, clean) / mean_square_difference(normalized(of_one, exposure), clean);
    };
    for (const double variance :
         {kept(merged.mosaic, frames[0].mosaic, flat.mosaic), kept(merged.left, frames[0].left, flat.left),
          kept(merged.right, frames[0].right, flat.right)}) {
      EXPECT_GT(variance, 0.97 * (1.0 / count + (1 - 1.0 / count) / 81)) << count;
      EXPECT_LT(variance, 1.03 * merged_view_variance(count)) << count;
    }
  }
}

// What differs in the mosaic alone is kept out of the views as well.
TEST(SixChannelMerge, AllChannelsShareOneWeight) {
  const Exposure exposure = exposure_at(100);
  const Signals flat{Image(2 * kWidth, 2 * kHeight, 1, 0.4f), Image(kWidth, kHeight / 2, 1, 0.2f),
                     Image(kWidth, kHeight / 2, 1, 0.2f)};
  std::vector<Frame> frames = {expose(flat, exposure, 1), expose(flat, exposure, 2)};
  std::mt19937 random(3);
  for (std::uint16_t& value : frames[1].mosaic.data) value = random() % 2 == 0 ? 64 : 1023;
  const MergedBurst merged = merge_six_channels(frames, 0, constant_motions({{}, {}}), exposure);
  const Image base = normalized(frames[0].left, exposure);
  EXPECT_LT(mean_square_difference(merged.left, base), 0.01 * mean_square_difference(base, flat.left));
}

// Frames of a moving camera, merged along their known motion, are the base frame again, but for the noise of six
// frames. (Views are merged at twice their height: that a fraction of their rows is moved by interpolated rows costs
// more.)
TEST(SixChannelMerge, FollowsTheMotion) {
  const Exposure exposure = exposure_at(1000);
  const std::vector<Pose> poses = {{0, 0}, {1.31, -2}, {2.87, -4.4}, {-3.44, 2.7}, {6.18, -6}, {9.5, 4.3}};
  std::vector<Frame> frames;
  for (const Pose& pose : poses) {
    frames.push_back(expose(see(Target(7, 0.1), kWidth, kHeight, pose), exposure, frames.size() + 1));
  }
  const Signals truth = see(Target(7, 0.1), kWidth, kHeight, {});
  const MergedBurst moved = merge_six_channels(frames, 0, constant_motions(poses), exposure);
  const MergedBurst unmoved =
      merge_six_channels(frames, 0, constant_motions(std::vector<Pose>(poses.size())), exposure);
  const auto kept = [](const Image& merged, const Image& one, const Image& clean) {
    return mean_square_difference(merged, clean) / mean_square_difference(one, clean);
  };
  const Image mosaic = normalized(frames[0].mosaic, exposure), left = normalized(frames[0].left, exposure);
  EXPECT_LT(kept(moved.mosaic, mosaic, truth.mosaic), 1.15 * merged_view_variance(6));
  EXPECT_GT(kept(unmoved.mosaic, mosaic, truth.mosaic), 2 * kept(moved.mosaic, mosaic, truth.mosaic));
  EXPECT_GT(kept(unmoved.left, left, truth.left), 1.5 * kept(moved.left, left, truth.left));
}

TEST(SixChannelMerge, IsTheSameForAnyNumberOfThreads) {
  const Exposure exposure = exposure_at(100);
  const std::vector<Frame> frames = hand_held(Target(3), kWidth, kHeight, exposure, 5);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return merge_six_channels(frames, 0, align_burst(frames, 0, exposure), exposure);
  };
  EXPECT_EQ(run(1).mosaic.data, run(4).mosaic.data);
}

TEST(SixChannelMerge, RefusesViewsOfAnotherSize) {
  const Exposure exposure = exposure_at(100);
  Frame frame = expose(see(Target(3), kWidth, kHeight, {}), exposure, 1);
  frame.left = frame.right = ImageU16(kWidth, kHeight, 1, 100);
  EXPECT_THROW(merge_six_channels({frame}, 0, constant_motions({{}}), exposure), InputError);
  frame.mosaic = {};
  EXPECT_THROW(merge_six_channels({frame}, 0, constant_motions({{}}), exposure), InputError);
}

}  // namespace
}  // namespace dualpixel::evaluation
