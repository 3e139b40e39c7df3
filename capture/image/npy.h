#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace dualpixel {

/// A NumPy file, version 1.0, of values in C order: `type` as NumPy names it ("<f4", "|u1").
std::string npy_bytes(const std::string& type, const std::vector<std::size_t>& shape, std::string_view bytes);

}  // namespace dualpixel
