#include "datasets/pictures/google.h"

#include <algorithm>
#include <cmath>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/image/jpeg.h"
#include "capture/image/npy.h"
#include "datasets/pictures/developed.h"

namespace dualpixel::datasets {
namespace {

/// Rotated clockwise by a quarter turn.
template <typename T>
ImageOf<T> rotated(const ImageOf<T>& image) {
  ImageOf<T> result(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c) result.at(image.height - 1 - y, x, c) = image.at(x, y, c);
    }
  }
  return result;
}

/// Depth as the data set stores it: 0..255 for 0.2 .. 100 m, 100 * 0.2 / (100 - (100 - 0.2) d).
float stored_depth(float depth_m) {
  constexpr float kNear_m = 0.2f, kFar_m = 100;
  return std::clamp((kFar_m - kFar_m * kNear_m / depth_m) / (kFar_m - kNear_m), 0.0f, 1.0f);
}

/// 10 bits, times 16.
ImageU16 stored_view(ImageU16 raw, int bits) {
  const double to_10_bits = 1023.0 / ((1 << bits) - 1);
  for (std::uint16_t& value : raw.data) value = static_cast<std::uint16_t>(16 * std::lround(to_10_bits * value));
  return rotated(raw);
}

}  // namespace

void require_google(const Camera& camera, const std::string& where) {
  if (camera.dp_downsample_x * camera.dp_downsample_y > 1) return;
  throw InputError(where + ": Google's layout holds green views; these are dense, of all colors");
}

void write_google(const Capture& capture, const std::function<std::string(const GoogleFile&)>& path) {
  constexpr int kQuality = 95;
  const Frame& frame = capture.frames.front();
  const auto& [left, right, picture, depth, npy, exr] = kGoogleFiles;
  write_png16(path(left), stored_view(frame.left, capture.exposure.bits));
  write_png16(path(right), stored_view(frame.right, capture.exposure.bits));
  const Image rgb = developed(normalized(frame.mosaic, capture.exposure), capture);
  write_file(path(picture), jpeg(rotated(srgb(rgb)), kQuality));
  Image stored = capture.truth->depth_m;
  for (float& value : stored.data) value = stored_depth(value);
  write_png8(path(depth), rotated(stored));
  const Image confidence = rotated(capture.truth->valid);
  write_npy(path(npy), confidence);
  write_exr(path(exr), {{"Y", &confidence}}, false);
}

}  // namespace dualpixel::datasets
