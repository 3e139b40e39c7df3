// Where one way of blurring ends and another begins, nothing must show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/error.h"
#include "capture/image/display.h"
#include "capture/image/resample.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/render.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kPhotoWidth = 700, kPhotoHeight = 360;
constexpr int kMargin = 40;  // discs of 30 px are cut by the border, and rows near it left out

/// As much contrast in each of six octaves, the finest of them near what a pixel can hold.
Image octaves() {
  Image picture(kPhotoWidth, kPhotoHeight, 3, 0.3f);
  for (int octave = 0; octave < 6; ++octave) {
    const Image texture =
        textured(Texture(10 + octave, 0.4 / (1 << octave), 30), kPhotoWidth, kPhotoHeight, 0, 0, 0.05);
    for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] += texture.data[i / 3];
  }
  return picture;
}

/// A plane whose disparity runs from `left` to `right` along x.
struct Plane {
  Image rgb, disparity{kPhotoWidth, kPhotoHeight}, radius;
  BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  double left, right;
  std::vector<Band> bands;

  Plane(const Image& picture, double left_, double right_) : rgb(picture), left(left_), right(right_) {
    for (int i = 0; i < kPhotoWidth * kPhotoHeight; ++i) {
      disparity.data[i] = static_cast<float>(left + (right - left) * (i % kPhotoWidth + 0.5) / kPhotoWidth);
    }
    radius = blur_radii(disparity, mapping);
    const auto [low, high] = std::minmax_element(disparity.data.begin(), disparity.data.end());
    bands = make_bands(*low, *high, mapping);
  }
  /// The column where a disparity lies.
  int column(double d) const { return static_cast<int>(std::floor((d - left) / (right - left) * kPhotoWidth)); }
};

/// Discs of the whole picture, none in layers, laid down from the farthest column to the nearest: each over what is
/// there already ("ordered"), or added. At the working resolution, enlarged, of colors for display in 1/255.
Image exact(const Plane& plane, bool ordered) {
  Layer layer;
  const Band all{-100, 100, 1, false};
  cut_band(plane.rgb, plane.disparity, plane.radius, sums_of_tents(plane.disparity, {all}), all, layer);
  const int width = layer.rgba.width, height = layer.rgba.height;
  Image sums(width, height, 4);
  for (int i = 0; i < width; ++i) {
    const int x = plane.left < plane.right ? width - 1 - i : i;
    const double radius = std::max(layer.radius_px.at(x, 0), 0.5f);
    const int reach = static_cast<int>(radius + 1), side = 2 * reach + 1;
    std::vector<float> weights(side * side);
    float total = 0;
    for (int k = 0; k < side * side; ++k) {
      weights[k] =
          static_cast<float>(std::clamp(radius + 0.5 - std::hypot(k % side - reach, k / side - reach), 0., 1.));
      total += weights[k];
    }
    for (int y = 0; y < height; ++y) {
      for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height - 1); ++v) {
        for (int u = std::max(x - reach, 0); u <= std::min(x + reach, width - 1); ++u) {
          const float weight = weights[(v - y + reach) * side + u - x + reach] / total;
          const float kept = ordered ? 1 - weight : 1;
          for (int c = 1; c < 4; c += 2) sums.at(u, v, c) = weight * layer.rgba.at(x, y, c) + kept * sums.at(u, v, c);
        }
      }
    }
  }
  const Image enlarged = resize_bilinear(sums, kPhotoWidth, kPhotoHeight);
  Image green(kPhotoWidth, kPhotoHeight);
  for (std::size_t i = 0; i < green.data.size(); ++i)
    green.data[i] = enlarged.data[4 * i + 1] / enlarged.data[4 * i + 3];
  return green;
}

Image display_error(const Plane& plane, const Image& exact_green) {
  const Image rendered = render_defocus(plane.rgb, plane.disparity, plane.radius, plane.mapping).rgb;
  Image green(kPhotoWidth, kPhotoHeight);
  for (std::size_t i = 0; i < green.data.size(); ++i) green.data[i] = rendered.data[3 * i + 1];
  Image error = encode_for_display(green);
  const Image truth = encode_for_display(exact_green);
  for (std::size_t i = 0; i < error.data.size(); ++i) error.data[i] -= truth.data[i];
  return error;
}

/// One behind the focus and one in front of it; both capped at the far end.
const std::vector<Plane>& planes() {
  static const std::vector<Plane> both = {{octaves(), 0, 1.3}, {octaves(), -2.2, 0}};
  return both;
}

// Brute force on one side, gradients on the other, a new layer between them: against added discs, which know neither,
// the error of no pixel jumps by 1/255 over two columns.
TEST(DefocusBands, NoSeamWhereBruteForceEnds) {
  for (const Plane& plane : planes()) {
    const Image error = display_error(plane, exact(plane, false));
    for (const Band& band : plane.bands) {
      if (!band.in_focus) continue;
      const int seam = plane.column(plane.right > 0 ? band.high_dp_px : band.low_dp_px);
      ASSERT_NEAR(plane.radius.at(seam, 0), 5.5, 0.1);
      float jump = 0;
      for (int y = kMargin; y < kPhotoHeight - kMargin; ++y) {
        for (int x = seam - 8; x <= seam + 8; ++x) {
          jump = std::max(jump, std::abs(error.at(x + 1, y) - error.at(x - 1, y)));
        }
      }
      EXPECT_LT(jump, 1 / 255.0f);
      EXPECT_GT(jump, 0.01f / 255);  // something was compared
    }
  }
}

// What the eye would join to a line: the step between the error's means over four columns on either side, wherever a
// band begins, ends, or has faded. The exact picture is that of the paper's ideal renderer. Its kernels are heavier on
// their near side and keep more texture than ours: 280 rows leave 0.5/255 of that in a mean.
TEST(DefocusBands, NoStepBetweenBandsAgainstOrderedCompositing) {
  for (const Plane& plane : planes()) {
    const Image error = display_error(plane, exact(plane, true));
    std::vector<double> profile(kPhotoWidth);
    for (int y = kMargin; y < kPhotoHeight - kMargin; ++y) {
      for (int x = 0; x < kPhotoWidth; ++x) profile[x] += error.at(x, y) / (kPhotoHeight - 2 * kMargin);
    }
    int ends = 0;
    for (const Band& band : plane.bands) {
      for (const double d :
           {band.low_dp_px - band.taper_dp_px, band.low_dp_px, band.high_dp_px, band.high_dp_px + band.taper_dp_px}) {
        const int end = plane.column(d);
        if (end < kMargin || end >= kPhotoWidth - kMargin) continue;
        ++ends;
        for (int x = end - 8; x <= end + 8; ++x) {
          double step = 0;
          for (int k = 0; k < 4; ++k) step += (profile[x + k] - profile[x - 1 - k]) / 4;
          EXPECT_LT(std::abs(step), 1.5 / 255) << "at " << x;
        }
      }
    }
    EXPECT_GE(ends, 8);
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
