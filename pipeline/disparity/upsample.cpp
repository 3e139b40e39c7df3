#include "pipeline/disparity/upsample.h"

#include <algorithm>
#include <cmath>

#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {

PixelDisparity upsample_tiles(const TileDisparity& tiles, int tile_px, int width, int height,
                              const UpsampleOptions& options) {
  const Image& disparity = tiles.disparity_dp_px;
  // The grid of whole tiles, whose last row and column may reach over the picture's border.
  const int grid_width = disparity.width * tile_px;
  const int grid_height = disparity.height * tile_px;
  PixelDisparity out{Image(width, height), Image(width, height)};
  for_rows(height, [&](int y) {
    const LinearTap line = linear_tap(y, grid_height, disparity.height);
    for (int x = 0; x < width; ++x) {
      const LinearTap column = linear_tap(x, grid_width, disparity.width);
      const float wx = column.weight_of_high, wy = line.weight_of_high;
      const float bilinear[4] = {(1 - wx) * (1 - wy), wx * (1 - wy), (1 - wx) * wy, wx * wy};
      const int u[4] = {column.low, column.high, column.low, column.high};
      const int v[4] = {line.low, line.low, line.high, line.high};
      float plain = 0, total = 0, sum = 0, sum_of_squares = 0;
      for (int k = 0; k < 4; ++k) {
        const float d = disparity.at(u[k], v[k]);
        const float weight = bilinear[k] * tiles.confidence.at(u[k], v[k]);
        plain += bilinear[k] * d;
        total += weight;
        sum += weight * d;
        sum_of_squares += weight * d * d;
      }
      if (total < 1e-6f) {
        out.disparity_dp_px.at(x, y) = plain;
        continue;
      }
      const float mean = sum / total;
      const float variance = std::max(sum_of_squares / total - mean * mean, 0.0f);
      out.disparity_dp_px.at(x, y) = mean;
      out.confidence.at(x, y) = total * std::exp(-variance / (2 * options.spread_dp_px * options.spread_dp_px));
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
