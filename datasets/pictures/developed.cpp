#include "datasets/pictures/developed.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "capture/image/demosaic.h"
#include "capture/image/image_io.h"
#include "capture/image/resample.h"

namespace dualpixel::datasets {

Image developed(const Image& mosaic, const Capture& capture) {
  const Exposure& exposure = capture.exposure;
  const std::string& cfa = capture.camera.cfa;
  return in_srgb(demosaic(white_balanced(mosaic, cfa, exposure.white_balance), cfa), exposure.color_matrix);
}

Image camera_colors(const Image& rgb, const Exposure& exposure) {
  if (!exposure.color_matrix) return rgb;
  return in_srgb(rgb, inverse(*exposure.color_matrix));  // the same product, the other way
}

ImageU16 levels(const Image& image) {
  ImageU16 result(image.width, image.height, image.channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    result.data[i] = static_cast<std::uint16_t>(std::lround(65535 * std::clamp(image.data[i], 0.0f, 1.0f)));
  }
  return result;
}

Image srgb(Image image) {
  for (float& value : image.data) value = srgb_from_linear(value);
  return image;
}

Image gray(const Image& image, int c) {
  Image result(image.width, image.height, 3);
  for (std::size_t i = 0; i < result.data.size(); ++i) result.data[i] = image.data[i / 3 * image.channels + c];
  return result;
}

Image scaled(Image image, float factor) {
  for (float& value : image.data) value *= factor;
  return image;
}

namespace {

/// Truth's picture in balanced camera colors, each clipped where the wells of the views are full, or their numbers end.
Image clipped_as_views(const Image& rgb, const Exposure& exposure) {
  Image balanced = camera_colors(rgb, exposure);
  const double full = std::min(1.0, 2 * view_white(exposure));
  for (std::size_t i = 0; i < balanced.data.size(); ++i) {
    balanced.data[i] = std::min(balanced.data[i], static_cast<float>(full * exposure.white_balance[i % 3]));
  }
  return balanced;
}

/// The same as white as developed() makes a mosaic's.
Image clipped_as_developed(const Image& rgb, const Exposure& exposure) {
  Image balanced = clipped_as_views(rgb, exposure);
  const auto white = static_cast<float>(balanced_white(exposure.white_balance));
  for (float& value : balanced.data) value = std::min(value, white);
  return in_srgb(std::move(balanced), exposure.color_matrix);
}

}  // namespace

DpddPictures dpdd_pictures(const Capture& capture) {
  const bool dense = capture.camera.dp_downsample_x * capture.camera.dp_downsample_y == 1;
  const int width = capture.camera.bayer_plane_width(), height = capture.camera.bayer_plane_height();
  const auto picture = [&](const Image& signal) {
    return dense ? developed(signal, capture) : gray(resize_bilinear(signal, width, height));
  };
  const Image left = normalized(capture.frames.front().left, capture.exposure);
  const Image right = normalized(capture.frames.front().right, capture.exposure);
  Image sum = left;
  for (std::size_t i = 0; i < sum.data.size(); ++i) sum.data[i] += right.data[i];
  const Image& sharp = capture.truth->all_in_focus;
  return {picture(scaled(left, 2)), picture(scaled(right, 2)), picture(sum),
          dense ? clipped_as_developed(sharp, capture.exposure)
                : gray(resize_area(clipped_as_views(sharp, capture.exposure), width, height), 1)};
}

}  // namespace dualpixel::datasets
