#pragma once
#include <array>

/// Band-limited interpolation along a row, and what white noise becomes under it.
namespace dualpixel::pipeline {

/// Weights of eight neighboring pixels: the value at position i + fraction is the sum over k of
/// row[i - 3 + k] * weight[k]. So are its first and third derivative by the position, per pixel and per pixel^3.
struct SincTaps {
  std::array<float, 8> value{};
  std::array<float, 8> slope{};
  std::array<float, 8> third{};
  // Covariances at this position when every pixel holds independent noise of variance 1. "smooth" is the slope of the
  // view after smoothing by 1/4 1/2 1/4 along x and y.
  float value_value = 0;
  float slope_slope = 0;
  float slope_smooth = 0;
  float smooth_smooth = 0;
};

/// Low-pass sinc under a Kaiser window, for 0 <= fraction < 1. Up to 0.26 cycles a pixel the value keeps its size
/// within 2 %, up to 0.38 its position within 0.004 px; its size is halved at 0.42.
SincTaps sinc_taps(float fraction);

}  // namespace dualpixel::pipeline
