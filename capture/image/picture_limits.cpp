#include "capture/image/picture_limits.h"

#include <fmt/format.h>

#include "capture/error.h"

namespace dualpixel {

void require_allowed_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t channels) {
  if (width >= 1 && height >= 1 && width <= kLongestPictureSide && height <= kLongestPictureSide && channels >= 1 &&
      channels <= kMostPictureChannels && width * height <= kMostPictureValues / channels) {
    return;
  }
  const auto stated = [](std::int64_t side) { return static_cast<std::uint32_t>(side); };  // OpenImageIO has it signed
  throw InputError(fmt::format("{}: {} x {} pixels of {} channels: at most {} a side and {} values in all are allowed",
                               printable(path), stated(width), stated(height), channels, kLongestPictureSide,
                               kMostPictureValues));
}

}  // namespace dualpixel
