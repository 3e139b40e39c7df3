#pragma once
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dualpixel {

/// A raster in memory. Rows run from top to bottom, pixels from left to right, channels are interleaved.
/// Continuous coordinates put (0, 0) at the top-left corner of the image, so the center of pixel (x, y) lies at
/// (x + 0.5, y + 0.5), and resampling by a factor keeps the corners aligned.
/// Values are linear light unless a name says `srgb`.
template <typename T>
struct ImageOf {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<T> data;

  ImageOf() = default;
  ImageOf(int width_, int height_, int channels_ = 1, T fill = T())
      : width(width_),
        height(height_),
        channels(channels_),
        data(static_cast<std::size_t>(width_) * height_ * channels_, fill) {}

  bool empty() const { return data.empty(); }
  std::size_t pixel_count() const { return static_cast<std::size_t>(width) * height; }

  T* row(int y) { return data.data() + static_cast<std::size_t>(y) * width * channels; }
  const T* row(int y) const { return data.data() + static_cast<std::size_t>(y) * width * channels; }

  T& at(int x, int y, int c = 0) {
    assert(x >= 0 && x < width && y >= 0 && y < height && c >= 0 && c < channels);
    return row(y)[static_cast<std::size_t>(x) * channels + c];
  }
  const T& at(int x, int y, int c = 0) const { return const_cast<ImageOf*>(this)->at(x, y, c); }

  template <typename U>
  bool same_size(const ImageOf<U>& other) const {
    return width == other.width && height == other.height;
  }
};

using Image = ImageOf<float>;
using ImageU16 = ImageOf<std::uint16_t>;  ///< raw digital numbers
using ImageU32 = ImageOf<std::uint32_t>;  ///< object ids

}  // namespace dualpixel
