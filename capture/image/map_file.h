#pragma once
#include <optional>
#include <string>

#include "capture/image/image.h"

namespace dualpixel {

/// What the integers of a picture stand for: scale * integer + offset.
struct IntegerScale {
  double scale = 1, offset = 0;
};

/// Whether a map is a picture of integers (PNG, TIFF), which needs an IntegerScale.
bool is_integer_picture(const std::string& path);

/// A map of one value a pixel as other programs write it, recognized by its first bytes:
///   NPY    float32, float64 or integers, of shape (height, width), further axes of length 1 aside; as they are
///   PFM    one channel ("Pf"); rows from bottom to top, as the format has it
///   EXR    the channel `channel`, or the only one that there is
///   PNG, TIFF   of one channel and 8 or 16 bits: only with `integers`
/// Values may be infinite or NaN. Throws InputError where the file cannot be used.
Image read_map(const std::string& path, const std::string& channel, const std::optional<IntegerScale>& integers = {});

/// A confidence, 0 to 1, likewise; that of a picture of integers is a share of the largest that its type holds.
Image read_confidence(const std::string& path);

}  // namespace dualpixel
