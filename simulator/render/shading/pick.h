#pragma once
#include <algorithm>
#include <cstddef>

/// Choosing one of many in proportion to their shares, which are given as running sums that end at 1.
namespace dualpixel::simulator {

/// First of `size` entries of an increasing sum that exceeds u; u becomes the position inside that entry, probability
/// its share. Without branches: where light comes from cannot be predicted.
inline std::size_t pick_from(const float* cumulative, std::size_t size, float& u, float& probability) {
  std::size_t entry = 0;
  for (std::size_t left = size; left > 1;) {
    const std::size_t half = left / 2;
    entry += cumulative[entry + half - 1] <= u ? half : 0;
    left -= half;
  }
  const float below = entry == 0 ? 0 : cumulative[entry - 1];
  probability = cumulative[entry] - below;
  u = std::clamp((u - below) / probability, 0.0f, 0x1.fffffep-1f);
  return entry;
}

/// Scales running sums so that they end at exactly 1.
template <typename Iterator>
void normalize_sums(Iterator begin, Iterator end) {
  const float total = *(end - 1);
  for (auto it = begin; it != end; ++it) *it = total > 0 ? *it / total : float(it - begin + 1) / float(end - begin);
  *(end - 1) = 1;
}

}  // namespace dualpixel::simulator
