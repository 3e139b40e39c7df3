#include "pipeline/disparity/matchers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/disparity/match_pixels.h"
#include "pipeline/disparity/split/split_match.h"
#include "pipeline/disparity/tile_disparity.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

// The split's factor is what the options say, else what the camera says, else a phone's; nonsense counts as unknown.
TEST(Matchers, SplitTakesTheCamerasAlpha) {
  const Image left = textured(Texture(3, 0.1), 128, 64, 0), right = textured(Texture(3, 0.1), 128, 64, 3);
  const auto found = [&](float stated, float option) {
    ViewSensor sensor;
    sensor.alpha = stated;
    MatcherOptions options;
    options.split_match.alpha = option;
    return matcher_named("split").match(left, right, sensor, options).disparity_dp_px.data;
  };
  const auto with = [&](float alpha) {
    SplitMatchOptions options;
    options.alpha = alpha;
    return match_by_split(left, right, options).disparity_dp_px.data;
  };
  EXPECT_EQ(found(0.4f, 0), with(0.4f));
  EXPECT_EQ(found(0.4f, 0.15f), with(0.15f));
  EXPECT_NE(with(0.4f), with(0.15f));
  EXPECT_EQ(found(0.44f, 0), found(0.43f, 0));  // beside the middle of the pixel: as a hard split
  EXPECT_NE(found(0.44f, 0), with(0));
  for (const float unknown : {0.0f, -1.0f, 0.001f, 7.0f, NAN}) EXPECT_EQ(found(unknown, 0), with(0)) << unknown;
  EXPECT_EQ(of_camera({}, Camera{.dp_downsample_x = 2, .dp_downsample_y = 4, .alpha = 0.3}).alpha, 0.3f);
  Camera hard{.dp_downsample_x = 2, .dp_downsample_y = 4};
  hard.split = "hard";
  EXPECT_NEAR(of_camera({}, hard).alpha, 0.42441, 1e-5);
  hard.alpha = 0.3;
  EXPECT_EQ(of_camera({}, hard).alpha, 0.3f);
}

TEST(Matchers, PixelsAreMatchedWithTheCapturesAlpha) {
  Capture capture;
  capture.camera.dp_downsample_x = capture.camera.dp_downsample_y = 2;
  capture.camera.alpha = 0.4;
  capture.frames.resize(1);
  const Image left = textured(Texture(3, 0.1), 128, 64, 0), right = textured(Texture(3, 0.1), 128, 64, 3);
  const auto matched = [&](float option) {
    MatcherOptions options;
    options.split_match.alpha = option;
    return match_pixels(capture, left, right, {}, matcher_named("split"), options).disparity_dp_px.data;
  };
  EXPECT_EQ(matched(0), matched(0.4f));
  EXPECT_NE(matched(0), matched(0.2f));
  capture.camera.dp_downsample_x = capture.camera.dp_downsample_y = 1;  // dense: matched at half the size
  capture.frames[0].mosaic = ImageU16(128, 64);
  EXPECT_EQ(matched(0), matched(0.4f));
  EXPECT_NE(matched(0), matched(0.2f));
}

}  // namespace
}  // namespace dualpixel::pipeline
