#pragma once
#include <vector>

#include "capture/image/image.h"
#include "capture/image/resample.h"

/// Pictures at the blur's working resolution seen at full size, row by row.
namespace dualpixel::pipeline {

/// Rows of an RGBA picture of half the size, rounded up, as resize_bilinear would enlarge it to twice its size, of
/// which a picture of odd sides is the beginning. Holds a reference to the picture.
class RowEnlarger {
 public:
  RowEnlarger(const Image& rgba, int width);

  /// Writes row y, 4 * width floats, to `out`; `mixed` is scratch.
  void operator()(int y, std::vector<float>& mixed, std::vector<float>& out) const;

 private:
  const Image& rgba_;
  std::vector<LinearTap> columns_;
};

}  // namespace dualpixel::pipeline
