#pragma once
#include <fmt/format.h>

#include <string>

#include "capture/capture.h"

namespace dualpixel {

inline constexpr int kMostFrames = 1000;

/// Throws InputError "where: /field: why"; `where` names the file or folder.
class CaptureCheck {
 public:
  explicit CaptureCheck(std::string where);

  void require(bool holds, const std::string& field, const std::string& why) const;

  template <typename T>
  void require_size(const ImageOf<T>& image, int width, int height, int channels, const std::string& field) const {
    require(image.width == width && image.height == height && image.channels == channels &&
                image.data.size() == image.pixel_count() * channels,
            field,
            fmt::format("{} x {} pixels of {} channels; the camera calls for {} x {} of {}", image.width, image.height,
                        image.channels, width, height, channels));
  }

 private:
  std::string where_;
};

/// What docs/capture.md requires beyond the range of each single field: sizes that agree, levels in order, pixel values
/// in range. Applied before a capture is written and after it is read.
void check_capture(const Capture& capture, const CaptureCheck& check);

}  // namespace dualpixel
