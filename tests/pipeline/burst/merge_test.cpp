#include "pipeline/burst/merge.h"
#include "pipeline/burst/align.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

#include "capture/error.h"
#include "tests/pipeline/burst/moving_burst.h"

namespace dualpixel::pipeline {
namespace {

/// One field for each frame, with the motion of its pose (no zoom) everywhere.
std::vector<MotionField> motions_of(const std::vector<Pose>& poses, int width, int height) {
  std::vector<MotionField> motions;
  for (const Pose& pose : poses) {
    MotionField& motion = motions.emplace_back((width + 7) / 8 + 1, (height + 7) / 8 + 1, 2);
    for (std::size_t i = 0; i < motion.data.size(); i += 2) {
      motion.data[i] = static_cast<float>(pose.x);
      motion.data[i + 1] = static_cast<float>(pose.y);
    }
  }
  return motions;
}

MergeOptions strength(double c) {
  MergeOptions options;
  options.strength = c;
  return options;
}

/// One frame's signals.
MergedBurst normalized(const Frame& frame, const Exposure& exposure) {
  const auto normalize = [&](const ImageU16& raw) {
    Image image(raw.width, raw.height);
    for (std::size_t i = 0; i < raw.data.size(); ++i) {
      image.data[i] = static_cast<float>((raw.data[i] - exposure.black_level_dn) /
                                         (exposure.white_level_dn - exposure.black_level_dn));
    }
    return image;
  };
  return {normalize(frame.mosaic), normalize(frame.left), normalize(frame.right)};
}

/// x0, y0, x1, y1 in Bayer px, of even y.
using Box = std::array<int, 4>;

double mean_square_error(const Image& image, const Image& truth, int x0, int y0, int x1, int y1) {
  double sum = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) sum += std::pow(image.at(x, y) - truth.at(x, y), 2);
  }
  return sum / ((x1 - x0) * (y1 - y0));
}

/// Errors inside a box of Bayer px: of mosaic, left and right.
std::array<double, 3> errors(const MergedBurst& burst, const Signals& truth, const Box& box) {
  const auto& [x0, y0, x1, y1] = box;
  return {mean_square_error(burst.mosaic, truth.mosaic, 2 * x0, 2 * y0, 2 * x1, 2 * y1),
          mean_square_error(burst.left, truth.left, x0, y0 / 2, x1, y1 / 2),
          mean_square_error(burst.right, truth.right, x0, y0 / 2, x1, y1 / 2)};
}

struct StaticNoise {
  int frames;
  double strength;
  double ratio;        ///< of the merged deviation to one frame's
  double views_ratio;  ///< of views that share their weights, without the test of energies
};
class StaticBurst : public testing::TestWithParam<StaticNoise> {};

// Figures for complex spectra with A as in merge.h, simulated apart. Deviations of 2^18 and of 2^15 samples are
// known to 0.14 and 0.4 %. Views lie between their own figure and that of a plane alone.
TEST_P(StaticBurst, HasTheNoiseOfTheShrinkage) {
  const Exposure exposure = exposure_at(100);
  const Signals flat{Image(512, 512, 1, 0.4f), Image(256, 128, 1, 0.2f), Image(256, 128, 1, 0.2f)};
  std::vector<Frame> frames;
  for (int z = 0; z < GetParam().frames; ++z) frames.push_back(expose(flat, exposure, z + 1));
  const std::vector<MotionField> still = motions_of(std::vector<Pose>(frames.size()), 256, 256);
  const MergedBurst merged = merge_burst(frames, 0, still, exposure, strength(GetParam().strength));
  const auto single = errors(normalized(frames[0], exposure), flat, {0, 0, 256, 256});
  const auto many = errors(merged, flat, {0, 0, 256, 256});
  const auto ratio = [&](int plane) { return std::sqrt(many[plane] / single[plane]); };
  EXPECT_NEAR(ratio(0), GetParam().ratio, 0.02 * GetParam().ratio);
  for (const int view : {1, 2}) {
    EXPECT_LT(ratio(view), 1.02 * GetParam().ratio);
    EXPECT_GT(ratio(view), 0.98 * GetParam().views_ratio);
  }
  RecordProperty("mosaic", std::to_string(ratio(0)));
  RecordProperty("left", std::to_string(ratio(1)));
  RecordProperty("right", std::to_string(ratio(2)));
}

INSTANTIATE_TEST_SUITE_P(Merge, StaticBurst,
                         testing::Values(StaticNoise{6, 8, 0.447, 0.432}, StaticNoise{9, 8, 0.382, 0.364},
                                         StaticNoise{6, 75, 0.409, 0.409}, StaticNoise{9, 75, 0.335, 0.333}));

TEST(Merge, FractionsOfAPixelCostNoDenoising) {
  // A window that did not lie right after the shift would differ from the base's by several sigma of a bright frame.
  const Exposure exposure = exposure_at(100);
  const Signals flat{Image(256, 256, 1, 0.4f), Image(128, 64, 1, 0.2f), Image(128, 64, 1, 0.2f)};
  std::vector<Frame> frames;
  for (unsigned z = 1; z <= 6; ++z) frames.push_back(expose(flat, exposure, z));
  const std::vector<Pose> poses = {{0, 0}, {0.4, 0.3}, {-0.3, 0.8}, {1.45, -0.2}, {0.2, 0.4}, {-2.4, 1.6}};
  const auto single = errors(normalized(frames[0], exposure), flat, {0, 0, 128, 128});
  const auto many = errors(merge_burst(frames, 0, motions_of(poses, 128, 128), exposure), flat, {0, 0, 128, 128});
  for (int plane = 0; plane < 3; ++plane) EXPECT_LT(std::sqrt(many[plane] / single[plane]), 1.02 * 0.447) << plane;
}

TEST(Merge, LeaksAsTheShrinkageSays) {
  // Flat frames differ at frequency 0 alone, once their tiles' other frequencies have canceled: D = W1 * step with W1
  // the sum of the window, 64, so that |D|^2 / V = 64^2 step^2 / (2 * 36 * sigma^2), 64 at a step of 3/sqrt(8) sigma.
  Exposure exposure;
  exposure.white_level_dn = 4000;
  for (const double c : {8.0, 75.0}) {
    const double step = 40;
    const double variance = step * step * 8 / 9;
    exposure.mosaic_noise = exposure.dp_noise = {0, variance};
    Frame base, other;
    base.mosaic = ImageU16(64, 64, 1, 1000);
    base.left = base.right = ImageU16(32, 16, 1, 1000);
    other.mosaic = ImageU16(64, 64, 1, 1040);
    other.left = other.right = ImageU16(32, 16, 1, 1040);
    const MergedBurst merged = merge_burst({base, other}, 0, motions_of({{}, {}}, 32, 32), exposure, strength(c));
    const double leak = 2 * (merged.mosaic.at(30, 30) * 4000 - 1000) / step;
    EXPECT_NEAR(leak, c / (64 + c), 1e-3) << c;  // 0.11 and 0.54
    EXPECT_NEAR(2 * (merged.left.at(15, 8) * 4000 - 1000) / step, leak, 1e-3);
  }
}

TEST(Merge, ShiftsByFractionsOfAPixel) {
  // With a strength beyond all differences the merge is the mean of the shifted frames: equal to the base, if they are
  // shifted right. The target stays below 0.25 cycles a pixel, also of the DP views' rows.
  Exposure exposure;
  exposure.white_level_dn = 60000;
  exposure.mosaic_noise = exposure.dp_noise = {0, 1e6};
  const Texture texture(7, 0.1);
  const std::vector<Pose> poses = {{0, 0}, {0.5, -0.5}, {3.3, 2.2}, {-1.8, 0.9}};
  std::vector<Frame> frames;
  for (const Pose& pose : poses) {
    const auto raw = [&](int width, int height, double step_x, double step_y) {
      const Image signal = texture.raster(width, height, step_x / 2 - pose.x, step_x, step_y / 2 - pose.y, step_y);
      ImageU16 dn(width, height);
      for (std::size_t i = 0; i < dn.data.size(); ++i) {
        dn.data[i] = static_cast<std::uint16_t>(std::lround(30000 + 5000 * signal.data[i]));
      }
      return dn;
    };
    frames.push_back({raw(256, 192, 0.5, 0.5), raw(128, 48, 1, 2), raw(128, 48, 1, 2)});
  }
  const MergedBurst merged = merge_burst(frames, 0, motions_of(poses, 128, 96), exposure, strength(1e6));
  const MergedBurst base = normalized(frames[0], exposure);
  const auto worst = [](const Image& a, const Image& b, int rim) {
    double most = 0;
    for (int y = rim; y < a.height - rim; ++y) {
      for (int x = rim; x < a.width - rim; ++x) most = std::max<double>(most, std::abs(a.at(x, y) - b.at(x, y)));
    }
    return most;
  };
  EXPECT_LT(worst(merged.mosaic, base.mosaic, 16), 0.002);
  EXPECT_LT(worst(merged.left, base.left, 8), 0.002);
  EXPECT_LT(worst(merged.right, merged.left, 0), 1e-6);  // equal views stay equal
}

/// Shift along x of `image` against the noiseless `truth`, by linear regression on its gradient.
double shift_of(const Image& image, const Image& truth) {
  double numerator = 0, denominator = 0;
  for (int y = 8; y < image.height - 8; ++y) {
    for (int x = 16; x < image.width - 16; ++x) {
      const double gradient = 0.5 * (truth.at(x + 1, y) - truth.at(x - 1, y));
      numerator -= gradient * (image.at(x, y) - truth.at(x, y));
      denominator += gradient * gradient;
    }
  }
  return numerator / denominator;
}

TEST(SlowMerge, KeepsTheDisparity) {
  for (const double lux : {5.0, 100.0, 1000.0}) {
    const Exposure exposure = exposure_at(lux);
    const Target target(11);
    std::vector<Frame> frames;
    for (std::size_t z = 0; z < kHandShake.size(); ++z) {
      frames.push_back(expose(see(target, 256, 192, kHandShake[z], 0.4), exposure, static_cast<unsigned>(z)));
    }
    const Signals truth = see(target, 256, 192, kHandShake[0], 0.4);
    const MergedBurst merged = merge_burst(frames, 0, align_burst(frames, 0, exposure), exposure);
    // over ten bursts: 0.014, 0.003, 0.0013 DP px about a mean of 0 within its error (one frame: 0.030, 0.006, 0.0023)
    EXPECT_NEAR(shift_of(merged.right, truth.right), shift_of(merged.left, truth.left), lux < 100 ? 0.03 : 0.006)
        << lux;
  }
}

/// `onto` with the part of `from` inside the box.
void paste(Signals& onto, const Signals& from, const Box& box) {
  const auto& [x0, y0, x1, y1] = box;
  for (int y = 2 * y0; y < 2 * y1; ++y) {
    for (int x = 2 * x0; x < 2 * x1; ++x) onto.mosaic.at(x, y) = from.mosaic.at(x, y);
  }
  for (int y = y0 / 2; y < y1 / 2; ++y) {
    for (int x = x0; x < x1; ++x) {
      onto.left.at(x, y) = from.left.at(x, y);
      onto.right.at(x, y) = from.right.at(x, y);
    }
  }
}

class MovingObject : public testing::TestWithParam<std::pair<double, double>> {};  // lux, Bayer px per frame

TEST_P(MovingObject, IsNeverWorseThanTheBase) {
  const auto& [lux, speed] = GetParam();
  const Exposure exposure = exposure_at(lux);
  std::vector<Frame> frames;
  Signals truth;
  for (int z = 0; z < 6; ++z) {
    Signals signals = see(Target(1), 192, 128, {0.7 * z, 0.3 * z});
    const int x = static_cast<int>(std::lround(speed * z));
    paste(signals, see(Target(50), 192, 128, {speed * z, 0}), {24 + x, 32, std::min(88 + x, 192), 96});
    if (z == 0) truth = signals;
    frames.push_back(expose(signals, exposure, 100 + z));
  }
  const MergedBurst merged = merge_burst(frames, 0, align_burst(frames, 0, exposure), exposure);
  const MergedBurst single = normalized(frames[0], exposure);
  for (const Box& box : {Box{24, 32, 88, 96}, {16, 24, 32, 104}, {80, 24, 96, 104}}) {  // all of it, and its sides
    const auto before = errors(single, truth, box), after = errors(merged, truth, box);
    for (int plane = 0; plane < 3; ++plane) {
      EXPECT_LE(after[plane], before[plane] * (1 + 1e-5)) << box[0] << ' ' << plane;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Merge, MovingObject,
                         testing::Values(std::pair{5, 1.5}, std::pair{5, 12}, std::pair{100, 4}, std::pair{100, 20},
                                         std::pair{1000, 4}, std::pair{1000, 20}));

TEST(Merge, DifferencesOfAnyStrengthDoNoHarm) {
  // The worst case: all other frames agree on a scene that differs from the base's in every frequency alike, by a
  // fraction of the noise up to several times it.
  const Exposure exposure = exposure_at(100);
  const Signals flat{Image(128, 128, 1, 0.108f), Image(64, 32, 1, 0.054f), Image(64, 32, 1, 0.054f)};
  const auto sigma = [](double signal, const NoiseProfile& noise) {
    return std::sqrt(noise.shot_dn * signal * 959 + noise.read_dn2) / 959;
  };
  const double of_mosaic = sigma(0.108, exposure.mosaic_noise), of_view = sigma(0.054, exposure.dp_noise);
  for (const double deviations : {0.5, 1.0, 1.25, 1.5, 2.0, 3.0, 5.0}) {
    Signals changed = flat;
    add_white_noise(changed.mosaic, 1, deviations * of_mosaic);
    add_white_noise(changed.left, 2, deviations * of_view);
    add_white_noise(changed.right, 3, deviations * of_view);
    std::vector<Frame> frames = {expose(flat, exposure, 4)};
    for (unsigned z = 1; z < 6; ++z) frames.push_back(expose(changed, exposure, 4 + z));
    const auto before = errors(normalized(frames[0], exposure), flat, {0, 0, 64, 64});
    const auto after =
        errors(merge_burst(frames, 0, motions_of(std::vector<Pose>(6), 64, 64), exposure), flat, {0, 0, 64, 64});
    for (int plane = 0; plane < 3; ++plane) EXPECT_LE(after[plane], before[plane] * (1 + 1e-5)) << deviations;
  }
}

// Brightness that changes from frame to frame costs little denoising, and the picture keeps the base's. A still burst
// keeps .447 of one frame's noise; were tiles rejected for their mean, this mosaic would keep 1.00 and its views .74.
TEST(Merge, LightMayFlicker) {
  const Exposure exposure = exposure_at(100);
  const Signals lit = see(Target(7, 0.1), 192, 128, {});
  std::vector<Frame> frames;
  for (const float gain : {1.0f, 1.15f, 0.87f, 1.1f, 0.9f, 1.2f}) {
    Signals signals = lit;
    for (Image* image : {&signals.mosaic, &signals.left, &signals.right}) {
      for (float& value : image->data) value *= gain;
    }
    frames.push_back(expose(signals, exposure, 20 + frames.size()));
  }
  const auto single = errors(normalized(frames[0], exposure), lit, {0, 0, 192, 128});
  const MergedBurst merged = merge_burst(frames, 0, motions_of(std::vector<Pose>(6), 192, 128), exposure);
  const auto many = errors(merged, lit, {0, 0, 192, 128});
  for (int plane = 0; plane < 3; ++plane) EXPECT_LT(std::sqrt(many[plane] / single[plane]), 0.5) << plane;
}

// (1 - A) D is at most sqrt(c V) / 2 at each frequency. At 0 the window sums to 64: of six frames 5/6 * 12 / 64 = .16
// deviations of a pixel. What is left at the frequencies beside it cancels between tiles that overlap.
TEST(Merge, AMeanThatDiffersStaysTheBases) {
  const Exposure exposure = exposure_at(100);
  const Signals flat{Image(512, 512, 1, 0.4f), Image(256, 128, 1, 0.2f), Image(256, 128, 1, 0.2f)};
  const double sigma = std::sqrt(exposure.mosaic_noise.shot_dn * 0.4 * 959 + exposure.mosaic_noise.read_dn2) / 959;
  for (const double deviations : {0.1, 0.2, 0.4, 0.7, 1.0, 2.0, 4.0}) {
    Signals brighter = flat;
    for (float& value : brighter.mosaic.data) value += static_cast<float>(deviations * sigma);
    std::vector<Frame> frames = {expose(flat, exposure, 1)};
    for (unsigned z = 1; z < 6; ++z) frames.push_back(expose(brighter, exposure, 1 + z));
    const Image merged = merge_burst(frames, 0, motions_of(std::vector<Pose>(6), 256, 256), exposure).mosaic;
    const double mean = std::accumulate(merged.data.begin(), merged.data.end(), 0.0) / (512.0 * 512);
    EXPECT_NEAR(mean, 0.4, 0.17 * sigma) << deviations;
  }
}

TEST(Merge, ClippedHighlightDoesNotUndershoot) {
  for (const double lux : {5.0, 100.0, 1000.0}) {
    for (const double speed : {0.5, 3.0, 10.0}) {
      const Exposure exposure = exposure_at(lux);
      Exposure silent = exposure;
      silent.mosaic_noise = silent.dp_noise = {};
      std::vector<Frame> frames;
      Signals truth;
      for (int z = 0; z < 6; ++z) {
        Signals signals{Image(256, 256, 1, 0.05f), Image(128, 64, 1, 0.025f), Image(128, 64, 1, 0.025f)};
        for (int y = 0; y < 256; ++y) {
          for (int x = 0; x < 256; ++x) {
            if (std::hypot((x + 0.5) / 2 - 30 - speed * z, (y + 0.5) / 2 - 64) > 6) continue;
            signals.mosaic.at(x, y) = 3;
            signals.left.at(x / 2, y / 4) = signals.right.at(x / 2, y / 4) = 1.5f;
          }
        }
        if (z == 0) truth = signals;
        frames.push_back(expose(signals, silent, z));
      }
      const MergedBurst merged = merge_burst(frames, 0, align_burst(frames, 0, exposure), exposure);
      // how far the dark ground falls below its level, over its own noise in one frame
      const auto undershoot = [](const Image& image, const Image& scene, const NoiseProfile& noise) {
        double most = 0;
        for (std::size_t i = 0; i < image.data.size(); ++i) {
          const double dn = 959 * scene.data[i];
          most = std::max(most, (dn - 959 * image.data[i]) / std::sqrt(noise.shot_dn * dn + noise.read_dn2) *
                                    (scene.data[i] < 1 ? 1 : 0));
        }
        return most;
      };
      EXPECT_LT(undershoot(merged.mosaic, truth.mosaic, exposure.mosaic_noise), 3) << lux << ' ' << speed;
      EXPECT_LT(undershoot(merged.left, truth.left, exposure.dp_noise), 3) << lux << ' ' << speed;
    }
  }
}

TEST(Merge, IsTheSameForAnyNumberOfThreads) {
  const Exposure exposure = exposure_at(100);
  const std::vector<Frame> frames = hand_held(Target(3), 128, 96, exposure, 5);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return align_and_merge(frames, exposure);
  };
  const MergedBurst one = run(1), four = run(4);
  EXPECT_EQ(one.mosaic.data, four.mosaic.data);
  EXPECT_EQ(one.left.data, four.left.data);
  EXPECT_EQ(one.right.data, four.right.data);
}

double greatest_difference(const Image& a, const Image& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) most = std::max<double>(most, std::abs(a.data[i] - b.data[i]));
  return most;
}

TEST(Merge, OneFrameAndEqualFramesWithoutNoiseStayAsTheyAre) {
  Exposure exposure = exposure_at(100);
  const Frame frame = expose(see(Target(3), 50, 30, {}), exposure, 1);
  const MergedBurst plain = normalized(frame, exposure);
  exposure.mosaic_noise = exposure.dp_noise = {};
  const std::vector<Frame> equal = {frame, frame, frame};
  for (const MergedBurst& merged :
       {align_and_merge({frame}, exposure), merge_burst(equal, 1, motions_of({{}, {}, {}}, 50, 30), exposure)}) {
    EXPECT_LT(greatest_difference(merged.mosaic, plain.mosaic), 1e-6);
    EXPECT_LT(greatest_difference(merged.left, plain.left), 1e-6);
    EXPECT_LT(greatest_difference(merged.right, plain.right), 1e-6);
  }
}

TEST(Merge, LostFramesLeaveTheBase) {
  const Exposure exposure = exposure_at(1000);
  const Target target(9);
  const std::vector<Frame> frames = {expose(see(target, 128, 96, {}), exposure, 1),
                                     expose(see(Target(60), 128, 96, {}), exposure, 2)};
  const MergedBurst base = normalized(frames[0], exposure);
  const std::vector<MotionField> aligned = align_burst(frames, 0, exposure);
  std::vector<MotionField> beyond = aligned;
  for (float& m : beyond[1].data) m = 1e30f;
  for (const std::vector<MotionField>& motions : {aligned, beyond}) {
    EXPECT_LT(greatest_difference(merge_burst(frames, 0, motions, exposure).mosaic, base.mosaic), 1e-6);
  }
}

TEST(Merge, BlownOutTilesStayWhite) {
  // of whole tiles that are clipped neither difference nor noise is left: 0 over 0; 3839 and 65471 have reciprocals
  // that don't lead back to them
  for (const auto& [black, white] : {std::pair{64, 1023}, {256, 4095}, {64, 65535}}) {
    Exposure exposure = exposure_at(100);
    exposure.black_level_dn = black;
    exposure.white_level_dn = white;
    std::vector<Frame> frames(6);
    for (Frame& frame : frames) {
      frame.mosaic = ImageU16(128, 128, 1, static_cast<std::uint16_t>(white));
      frame.left = frame.right = ImageU16(64, 32, 1, static_cast<std::uint16_t>(white));
    }
    const MergedBurst merged = align_and_merge(frames, exposure);
    for (const Image* image : {&merged.mosaic, &merged.left, &merged.right}) {
      for (const float value : image->data) ASSERT_NEAR(value, 1, 1e-5) << black << ' ' << white;
    }
  }

  // the upper half of a hand-held picture
  const Exposure exposure = exposure_at(100);
  std::vector<Frame> frames = hand_held(Target(5), 128, 128, exposure, 1);
  for (Frame& frame : frames) {
    for (ImageU16* image : {&frame.mosaic, &frame.left, &frame.right}) {
      std::fill(image->data.begin(), image->data.begin() + static_cast<std::ptrdiff_t>(image->data.size() / 2), 1023);
    }
  }
  const MergedBurst merged = align_and_merge(frames, exposure);
  for (const Image* image : {&merged.mosaic, &merged.left, &merged.right}) {
    for (const float value : image->data) ASSERT_TRUE(std::isfinite(value));
    for (int x = 0; x < image->width; ++x) EXPECT_NEAR(image->at(x, image->height / 4), 1, 1e-5);
  }
}

// Views that clip at their own white, read out with noise around it: a hand-held sky stays flat, as the mosaic's does.
TEST(Merge, ViewsClipAtTheirOwnWhite) {
  Exposure exposure = exposure_at(100);
  exposure.dp_white_level_dn = 544;
  std::vector<Frame> frames = hand_held(Target(5), 128, 128, exposure, 1);
  for (std::size_t z = 0; z < frames.size(); ++z) {
    for (ImageU16* image : {&frames[z].left, &frames[z].right}) {
      for (std::size_t i = 0; i < image->data.size() / 2; ++i) {
        image->data[i] = static_cast<std::uint16_t>(543 + (i + z) % 3);
      }
    }
  }
  const MergedBurst merged = align_and_merge(frames, exposure);
  const double white = view_white(exposure);
  EXPECT_DOUBLE_EQ(white, 480.0 / 959);
  for (const Image* image : {&merged.left, &merged.right}) {
    for (int x = 0; x < image->width; ++x) EXPECT_NEAR(image->at(x, image->height / 4), white, 1.1 / 959);
  }
}

// A full well that is read out with noise: the mean of six frames has a sixth of its variance (plus what the shrinkage
// keeps), as elsewhere. With no variance at the well nothing would be merged. 2 x 64 x 16 samples: to 3 % each; of a
// mosaic that clips at its own white there are more.
TEST(Merge, ReadOutsOfFullWellsAreMerged) {
  Exposure exposure = exposure_at(100);
  exposure.dp_white_level_dn = 544;
  exposure.mosaic_white_level_dn = 800;
  exposure.dp_noise.read_dn2 = exposure.mosaic_noise.read_dn2 = 16;
  std::vector<Frame> frames = hand_held(Target(5), 128, 128, exposure, 1);
  frames.resize(1);
  std::mt19937 random(3);
  const auto fill = [&](ImageU16& image, double white) {
    std::normal_distribution<double> noise(white, 4);
    for (std::uint16_t& value : image.data) value = static_cast<std::uint16_t>(std::lround(noise(random)));
  };
  frames.resize(6, frames[0]);
  for (Frame& frame : frames) fill(frame.left, 544), fill(frame.right, 544), fill(frame.mosaic, 800);
  const MergedBurst merged = align_and_merge(frames, exposure);
  const auto variance = [](const Image& image, double white) {  // over that of one frame
    double sum = 0, count = 0;
    for (int y = 8; y < image.height - 8; ++y) {
      for (int x = 8; x < image.width - 8; ++x) sum += std::pow(959 * image.at(x, y) - (white - 64), 2), ++count;
    }
    return sum / count / 16;
  };
  EXPECT_LT((variance(merged.left, 544) + variance(merged.right, 544)) / 2, 1.2 * merged_view_variance(6));
  EXPECT_LT(variance(merged.mosaic, 800), 1.2 * 0.447 * 0.447);  // StaticBurst's

  // Ten DN less in the others is more than the read noise of full wells explains, 1 + 100 / 32 times that: the base
  // frame remains. Shot noise, which full wells have none of, would explain it. The mean of 128 x 128 is known to 4 /
  // 128 DN.
  for (std::size_t z = 1; z < frames.size(); ++z) fill(frames[z].mosaic, 790);
  const Image kept = merge_burst(frames, 0, motions_of(std::vector<Pose>(6), 128, 128), exposure).mosaic;
  const double mean = std::accumulate(kept.data.begin(), kept.data.end(), 0.0) / static_cast<double>(kept.data.size());
  EXPECT_NEAR(64 + 959 * mean, 800, 4 * 4.0 / 256);
}

TEST(Merge, SmallestFramesAreFinite) {
  for (const auto& [width, height] : kSmallestMosaics) {
    std::vector<Frame> frames = flat_frames(width, height);
    const MergedBurst merged = align_and_merge(frames, exposure_at(5));
    for (const Image* image : {&merged.mosaic, &merged.left, &merged.right}) {
      for (const float value : image->data) EXPECT_TRUE(std::isfinite(value));
    }
    for (Frame& frame : frames) frame.mosaic = {};
    const MergedBurst views = align_and_merge(frames, exposure_at(5));
    EXPECT_TRUE(views.mosaic.empty());
    for (const float value : views.left.data) EXPECT_NEAR(value, 16.0 / 959, 1e-6);
  }
}

TEST(Merge, RefusesWhatItCannotUse) {
  const Exposure exposure = exposure_at(100);
  const Frame frame = expose(see(Target(3), 32, 32, {}), exposure, 1);
  const std::vector<Frame> frames = {frame, frame};
  const std::vector<MotionField> still = motions_of({{}, {}}, 32, 32);
  const auto refusal = [&](int base, const std::vector<MotionField>& motions, double c) -> std::string {
    try {
      merge_burst(frames, base, motions, exposure, strength(c));
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(0, still, 8), "");
  EXPECT_EQ(refusal(2, still, 8), "burst: base: 2: must be in [0, 1]");
  EXPECT_EQ(refusal(0, still, 0), "merge.strength: 0: must be a number in [0.001, 1e+06]");
  EXPECT_EQ(refusal(0, still, std::numeric_limits<double>::infinity()),
            "merge.strength: inf: must be a number in [0.001, 1e+06]");
  EXPECT_EQ(refusal(0, {still[0]}, 8), "burst: one motion field is needed for each frame");
  EXPECT_EQ(refusal(0, motions_of({{}, {}}, 32, 40), 8),
            "burst: a motion field must have two channels and one pixel for each tile");
  EXPECT_EQ(refusal(0, motions_of({{}, {std::nan(""), 0}}, 32, 32), 8), "burst: motions must be finite");
}

}  // namespace
}  // namespace dualpixel::pipeline
