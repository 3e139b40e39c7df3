#include "pipeline/burst/align.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "capture/error.h"
#include "tests/pipeline/burst/moving_burst.h"

namespace dualpixel::pipeline {
namespace {

/// Median distance, Bayer px, between a field and the motion of `pose`, over tiles whose content both frames show.
double median_error(const MotionField& motion, int width, int height, const Pose& pose) {
  std::vector<double> errors;
  for (int j = 2; j < motion.height - 2; ++j) {
    for (int i = 2; i < motion.width - 2; ++i) {
      const double x = i * kMotionStep - width / 2.0, y = j * kMotionStep - height / 2.0;
      errors.push_back(std::hypot(motion.at(i, j, 0) - (pose.x + x / pose.zoom - x),
                                  motion.at(i, j, 1) - (pose.y + y / pose.zoom - y)));
    }
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  return errors[errors.size() / 2];
}

constexpr int kFrameWidth = 256, kFrameHeight = 192;

/// The largest median error of the frames of a hand-held burst.
double hand_held_error(double lux, bool with_mosaic) {
  const Exposure exposure = exposure_at(lux);
  std::vector<Frame> frames = hand_held(Target(1), kFrameWidth, kFrameHeight, exposure, 10);
  if (!with_mosaic) {
    for (Frame& frame : frames) frame.mosaic = {};
  }
  const std::vector<MotionField> motions = align_burst(frames, 0, exposure);
  double worst = 0;
  for (std::size_t z = 1; z < motions.size(); ++z) {
    worst = std::max(worst, median_error(motions[z], kFrameWidth, kFrameHeight, kHandShake[z]));
  }
  return worst;
}

// measured: 0.04 at 100 lux, where the quadratic's own bias prevails, and 0.09 at 5 lux
TEST(Align, FollowsHandShakeAtHundredLux) { EXPECT_LT(hand_held_error(100, true), 0.15); }
TEST(Align, FollowsHandShakeAtFiveLux) { EXPECT_LT(hand_held_error(5, true), 0.5); }
TEST(SlowAlign, FollowsHandShakeOnViewsAlone) { EXPECT_LT(hand_held_error(100, false), 0.15); }

TEST(Align, BaseAndFlatFramesStandStill) {
  const Frame frame = expose(see(Target(2), 64, 48, {}), exposure_at(100), 1);
  const std::vector<MotionField> same = align_burst({frame, frame}, 1, exposure_at(100));
  for (const float m : same[1].data) EXPECT_EQ(m, 0);
  for (const float m : same[0].data) EXPECT_NEAR(m, 0, 0.5);  // the quadratic of a cost of 0 may lean
  Frame flat = frame;
  flat.mosaic = ImageU16(128, 96, 1, 100);
  Frame brighter = flat;
  brighter.mosaic = ImageU16(128, 96, 1, 120);
  const std::vector<MotionField> nothing = align_burst({flat, brighter}, 0, exposure_at(100));
  for (const float m : nothing[1].data) EXPECT_EQ(m, 0);
}

TEST(Align, IsTheSameForAnotherBase) {
  const Exposure exposure = exposure_at(100);
  std::vector<Frame> frames = hand_held(Target(3), kFrameWidth, kFrameHeight, exposure, 20);
  const std::vector<MotionField> motions = align_burst(frames, 1, exposure);
  const Pose back = {kHandShake[0].x - kHandShake[1].x, kHandShake[0].y - kHandShake[1].y, 1};
  EXPECT_LT(median_error(motions[0], kFrameWidth, kFrameHeight, back), 0.15);
}

TEST(SlowAlign, FindsMotionUpToTheReachAndStaysFiniteBeyond) {
  const Exposure exposure = exposure_at(100);
  const Target target(4);
  const Frame base = expose(see(target, 512, 384, {}), exposure, 1);
  const Pose far = {-120.4, 60.7};
  const std::vector<MotionField> found =
      align_burst({base, expose(see(target, 512, 384, far), exposure, 2)}, 0, exposure);
  std::vector<double> errors;
  for (int j = 2; j < found[1].height - 10; ++j) {
    for (int i = 18; i < found[1].width - 2; ++i) {
      errors.push_back(std::hypot(found[1].at(i, j, 0) - far.x, found[1].at(i, j, 1) - far.y));
    }
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.15);

  const std::vector<MotionField> lost =
      align_burst({base, expose(see(target, 512, 384, {400, 300}), exposure, 2)}, 0, exposure);
  const float reach = 169 + 32 + 8 + 2 + 1;  // and the fractions of four levels
  for (const float m : lost[1].data) EXPECT_LE(std::abs(m), reach);
}

TEST(Align, SmallestFramesAreFinite) {
  for (const auto& [width, height] : kSmallestMosaics) {
    for (const MotionField& motion : align_burst(flat_frames(width, height), 0, exposure_at(5))) {
      EXPECT_EQ(motion.width, (width / 2 + 7) / 8 + 1);
      EXPECT_EQ(motion.height, (height / 2 + 7) / 8 + 1);
      for (const float m : motion.data) EXPECT_TRUE(std::isfinite(m));
    }
  }
}

TEST(Align, SharpestOfTheFirstThree) {
  const Exposure exposure = exposure_at(100);
  const Signals sharp = see(Target(5), 128, 96, {});
  const Signals dull = see(Target(5, 0.2), 128, 96, {});
  const auto sharpest = [&](std::vector<const Signals*> burst) {
    std::vector<Frame> frames;
    for (const Signals* signals : burst) frames.push_back(expose(*signals, exposure, 7));
    return sharpest_frame(frames, exposure);
  };
  EXPECT_EQ(sharpest({&sharp, &sharp, &sharp}), 0);
  EXPECT_EQ(sharpest({&dull, &sharp, &dull}), 1);
  EXPECT_EQ(sharpest({&dull, &dull, &sharp, &sharp}), 2);
  EXPECT_EQ(sharpest({&dull, &dull, &dull, &sharp}), 0);
  std::vector<Frame> views = {expose(dull, exposure, 7), expose(sharp, exposure, 7)};
  for (Frame& frame : views) frame.mosaic = {};
  EXPECT_EQ(sharpest_frame(views, exposure), 1);
}

TEST(Align, RefusesWhatIsNoBurst) {
  const Exposure good = exposure_at(100);
  std::vector<Frame> frames(2);
  for (Frame& frame : frames) {
    frame.mosaic = ImageU16(16, 16, 1, 100);
    frame.left = frame.right = ImageU16(8, 4, 1, 80);
  }
  const auto refusal = [](const std::vector<Frame>& burst, const Exposure& exposure, int base) -> std::string {
    try {
      align_burst(burst, base, exposure);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(frames, good, 0), "");
  EXPECT_EQ(refusal({}, good, 0), "burst: no frames");
  EXPECT_EQ(refusal(frames, good, 2), "burst: base: 2: must be in [0, 1]");
  EXPECT_EQ(refusal(frames, good, -1), "burst: base: -1: must be in [0, 1]");

  const auto with_frame = [&](const std::function<void(Frame&)>& change) {
    std::vector<Frame> changed = frames;
    change(changed[1]);
    return refusal(changed, good, 0);
  };
  EXPECT_EQ(with_frame([](Frame& f) { f.mosaic = {}; }), "burst: frame 1: either every frame has a mosaic or none");
  EXPECT_EQ(with_frame([](Frame& f) { f.mosaic = ImageU16(16, 8); }),
            "burst: frame 1: mosaic must have the size of the first frame's");
  const std::string even = "burst: frame 1: mosaic must be a whole image of one channel with even sides";
  EXPECT_EQ(with_frame([](Frame& f) { f.mosaic = ImageU16(15, 16); }), even);
  EXPECT_EQ(with_frame([](Frame& f) { f.mosaic.data.pop_back(); }), even);
  EXPECT_EQ(with_frame([](Frame& f) { f.right = ImageU16(8, 8); }),
            "burst: frame 1: left and right must have the size of the first frame's left");
  EXPECT_EQ(with_frame([](Frame& f) { f.left = {}; }),
            "burst: frame 1: left and right must be whole images of one channel");

  const auto with_exposure = [&](const std::function<void(Exposure&)>& change) {
    Exposure changed = good;
    change(changed);
    return refusal(frames, changed, 0);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(with_exposure([](Exposure& e) { e.white_level_dn = 64; }),
            "burst: white_level_dn: 64: must be finite and above black_level_dn, 64");
  EXPECT_EQ(with_exposure([&](Exposure& e) { e.black_level_dn = nan; }),
            "burst: white_level_dn: 1023: must be finite and above black_level_dn, nan");
  EXPECT_EQ(with_exposure([&](Exposure& e) { e.mosaic_noise.shot_dn = nan; }),
            "burst: mosaic_noise.shot_dn: nan: must be finite and not negative");
  EXPECT_EQ(with_exposure([](Exposure& e) { e.dp_noise.read_dn2 = -1; }),
            "burst: dp_noise.read_dn2: -1: must be finite and not negative");
}

}  // namespace
}  // namespace dualpixel::pipeline
