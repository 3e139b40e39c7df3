#include "evaluation/metrics/merge_errors.h"

#include <cmath>
#include <vector>

namespace dualpixel::evaluation {
namespace {

constexpr int kBorder_px = 16;  // DP px

/// A view without noise, as the sensor bins it: the mean of the green photosites of each DP pixel.
Image clean_view(const Image& photosites, const Camera& camera) {
  Image view(camera.dp_width(), camera.dp_height());
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      float sum = 0;
      int count = 0;
      for (int j = 0; j < camera.dp_downsample_y; ++j) {
        for (int i = 0; i < camera.dp_downsample_x; ++i) {
          if ((i + j) % 2 == 0) continue;  // RGGB: red or blue
          sum += photosites.at(camera.dp_downsample_x * x + i, camera.dp_downsample_y * y + j, 1);
          ++count;
        }
      }
      view.at(x, y) = sum / static_cast<float>(count);
    }
  }
  return view;
}

/// The mosaic without noise: both views' light in each photosite's color, before white balance.
Image clean_mosaic(const Capture& capture) {
  const Truth& truth = *capture.truth;
  Image mosaic(truth.left.width, truth.left.height);
  for (int y = 0; y < mosaic.height; ++y) {
    for (int x = 0; x < mosaic.width; ++x) {
      const int color = x % 2 + y % 2;  // RGGB
      mosaic.at(x, y) = static_cast<float>((truth.left.at(x, y, color) + truth.right.at(x, y, color)) /
                                           capture.exposure.white_balance[color]);
    }
  }
  return mosaic;
}

Image difference(const Image& picture, Image clean) {
  for (std::size_t i = 0; i < clean.data.size(); ++i) clean.data[i] = picture.data[i] - clean.data[i];
  return clean;
}

double inner_rms(const std::vector<const Image*>& pictures, int border_px) {
  double squares = 0, count = 0;
  for (const Image* picture : pictures) {
    for (int y = border_px; y < picture->height - border_px; ++y) {
      for (int x = border_px; x < picture->width - border_px; ++x, ++count) {
        squares += static_cast<double>(picture->at(x, y)) * picture->at(x, y);
      }
    }
  }
  return std::sqrt(squares / count);
}

}  // namespace

double MergeErrors::views_rms() const { return inner_rms({&left, &right}, kBorder_px); }

double MergeErrors::mosaic_rms() const { return inner_rms({&mosaic}, 4 * kBorder_px); }

double MergeErrors::squares_beyond(double limit) const {
  constexpr int kSide = 4;
  double beyond = 0, count = 0;
  for (const Image* view : {&left, &right}) {
    for (int y = kBorder_px; y + kSide <= view->height - kBorder_px; y += kSide) {
      for (int x = kBorder_px; x + kSide <= view->width - kBorder_px; x += kSide, ++count) {
        double sum = 0;
        for (int i = 0; i < kSide * kSide; ++i) sum += view->at(x + i % kSide, y + i / kSide);
        beyond += std::abs(sum) / (kSide * kSide) > limit;
      }
    }
  }
  return beyond / count;
}

MergeErrors merge_errors(const pipeline::MergedBurst& merged, const Capture& capture) {
  return {difference(merged.left, clean_view(capture.truth->left, capture.camera)),
          difference(merged.right, clean_view(capture.truth->right, capture.camera)),
          difference(merged.mosaic, clean_mosaic(capture))};
}

pipeline::MergedBurst first_frame(const Capture& capture) {
  const Frame& frame = capture.frames.front();
  return {normalized(frame.mosaic, capture.exposure), normalized(frame.left, capture.exposure),
          normalized(frame.right, capture.exposure)};
}

}  // namespace dualpixel::evaluation
