#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "capture/image/image.h"

namespace dualpixel {

/// A NumPy file, version 1.0, of values in C order: `type` as NumPy names it ("<f4", "|u1").
std::string npy_bytes(const std::string& type, const std::vector<std::size_t>& shape, std::string_view bytes);

/// Writes an image as float32, of shape (height, width), or (height, width, channels).
void write_npy(const std::string& path, const Image& image);

/// An array of float32, float64, or integers of 8 to 32 bits, in C order and little endian, of shape (height, width) or
/// (height, width, channels) with at most four channels; further leading axes of length 1 are dropped. Throws
/// InputError.
Image read_npy(const std::string& path);

}  // namespace dualpixel
