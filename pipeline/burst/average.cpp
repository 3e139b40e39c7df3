#include "pipeline/burst/average.h"

#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

Image average(const std::vector<Frame>& frames, ImageU16 Frame::*plane, const Exposure& exposure) {
  const ImageU16& first = frames.front().*plane;
  const float count = static_cast<float>(frames.size());
  const float scale = static_cast<float>(1 / (exposure.white_level_dn - exposure.black_level_dn)) / count;
  const float offset = static_cast<float>(exposure.black_level_dn) * count;
  Image mean(first.width, first.height, first.channels);
  for_rows(first.height, [&](int y) {
    float* to = mean.row(y);
    const std::size_t length = static_cast<std::size_t>(first.width) * first.channels;
    for (const Frame& frame : frames) {
      const std::uint16_t* from = (frame.*plane).row(y);
      for (std::size_t i = 0; i < length; ++i) to[i] += from[i];
    }
    for (std::size_t i = 0; i < length; ++i) to[i] = (to[i] - offset) * scale;
  });
  return mean;
}

}  // namespace

MergedBurst average_burst(const std::vector<Frame>& frames, const Exposure& exposure) {
  MergedBurst merged;
  if (!frames.front().mosaic.empty()) merged.mosaic = average(frames, &Frame::mosaic, exposure);
  merged.left = average(frames, &Frame::left, exposure);
  merged.right = average(frames, &Frame::right, exposure);
  return merged;
}

}  // namespace dualpixel::pipeline
