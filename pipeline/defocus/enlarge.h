#pragma once
#include <vector>

#include "capture/image/image.h"
#include "capture/image/resample.h"

/// Pictures at the blur's working resolution seen at full size, row by row.
namespace dualpixel::pipeline {

/// Rows of an RGBA picture as resize_bilinear would enlarge it. Holds a reference to the picture.
class RowEnlarger {
 public:
  RowEnlarger(const Image& rgba, int width, int height);

  /// Writes row y, 4 * width floats, to `out`; `mixed` is scratch.
  void operator()(int y, std::vector<float>& mixed, std::vector<float>& out) const;

 private:
  const Image& rgba_;
  int height_;
  std::vector<LinearTap> columns_;
};

}  // namespace dualpixel::pipeline
