#include "pipeline/edge_aware/median.h"

#include <algorithm>

#include "pipeline/rows.h"

namespace dualpixel::pipeline {

Image median_3x3(const Image& image) {
  Image out(image.width, image.height);
  for_rows(image.height, [&](int y) {
    const float* rows[3] = {image.row(std::max(y - 1, 0)), image.row(y), image.row(std::min(y + 1, image.height - 1))};
    for (int x = 0; x < image.width; ++x) {
      const int columns[3] = {std::max(x - 1, 0), x, std::min(x + 1, image.width - 1)};
      float window[9];
      for (int k = 0; k < 9; ++k) window[k] = rows[k / 3][columns[k % 3]];
      std::nth_element(window, window + 4, window + 9);
      out.row(y)[x] = window[4];
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
