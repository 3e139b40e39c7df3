#pragma once
#include <numbers>
#include <optional>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "pipeline/disparity/kernel_skew.h"

/// Noise of DP views.
namespace dualpixel::pipeline {

/// Variance of a pixel of one view whose mean is x, in the normalized signal (0 black): shot * x + read.
struct ViewNoise {
  float shot = 0;
  float read = 0;
};

/// What a matcher may know of the views' sensor.
struct ViewSensor {
  std::optional<ViewNoise> noise;  ///< of one view's pixel; empty: unknown
  float white = 1;                 ///< normalized signal at which a view clips
  float pixel_height = 1;          ///< of a view's pixel, over its width
  float alpha = 0;                 ///< centroid disparity over signed blur diameter; 0: unknown
  SkewField skew;                  ///< of the views' kernels, as calibrated; no nodes: that of an ideal split of alpha
};

/// The same with what the camera says of its views' pixels. A hard split's alpha needs no saying: the centroids of half
/// discs of radius R lie 4 R / (3 pi) from the middle.
inline ViewSensor of_camera(ViewSensor sensor, const Camera& camera) {
  sensor.pixel_height = static_cast<float>(camera.dp_downsample_y) / static_cast<float>(camera.dp_downsample_x);
  const bool known = camera.alpha > 0 || camera.split != "hard";
  sensor.alpha = static_cast<float>(known ? camera.alpha : 4 / (3 * std::numbers::pi));
  return sensor;
}

/// What the capture states; {0, 0} where it is unknown.
inline ViewNoise view_noise(const Exposure& exposure) {
  const double range = exposure.white_level_dn - exposure.black_level_dn;
  return {static_cast<float>(exposure.dp_noise.shot_dn / range),
          static_cast<float>(exposure.dp_noise.read_dn2 / (range * range))};
}

/// Of views that are the mean of frames and keep `noise_left` of one frame's variance. Of their pixels nothing is known
/// here: square, and their split unknown.
inline ViewSensor view_sensor(const Exposure& exposure, double noise_left = 1) {
  ViewSensor sensor;
  sensor.white = static_cast<float>(view_white(exposure));
  const ViewNoise one = view_noise(exposure);
  const auto left = static_cast<float>(noise_left);
  if (one.shot > 0 || one.read > 0) sensor.noise = {left * one.shot, left * one.read};
  return sensor;
}

/// The profile read off the views themselves, as shot noise alone: the lower quartile, over 8 x 8 tiles, of the
/// variance of second differences along both axes over the mean. Texture finer than 3 px counts as noise. Rows that a
/// phone interpolated from half as many share their noise, and differ by little of it. Where even and odd rows show
/// that (in views of some 258 x 258 pixels and more), the estimate is multiplied by the ratio of the same variance at a
/// distance of three rows to that at three columns. Never 0.
ViewNoise estimate_noise(const Image& left, const Image& right);

}  // namespace dualpixel::pipeline
