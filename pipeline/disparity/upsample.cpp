#include "pipeline/disparity/upsample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {

PixelDisparity upsample_tiles(const TileDisparity& tiles, int tile_px, int width, int height,
                              const UpsampleOptions& options) {
  const Image& disparity = tiles.disparity_dp_px;
  const int columns = disparity.width;
  // The grid of whole tiles, whose last row and column may reach over the picture's border.
  const int grid_width = columns * tile_px;
  const int grid_height = disparity.height * tile_px;
  std::vector<LinearTap> taps(width);
  for (int x = 0; x < width; ++x) taps[x] = linear_tap(x, grid_width, columns);
  PixelDisparity out{Image(width, height), Image(width, height)};
  for_rows(height, [&](int y) {
    const LinearTap line = linear_tap(y, grid_height, disparity.height);
    // Disparity, confidence, and disparity and its square times confidence; blended between the two rows of tiles.
    struct Tile {
      float plain, total, sum, sum_of_squares;
    };
    std::vector<Tile> blend(columns);
    for (int u = 0; u < columns; ++u) {
      const auto mix = [&](const auto& of) {
        const float low = of(disparity.at(u, line.low), tiles.confidence.at(u, line.low));
        return low + line.weight_of_high * (of(disparity.at(u, line.high), tiles.confidence.at(u, line.high)) - low);
      };
      blend[u] = {mix([](float d, float) { return d; }), mix([](float, float c) { return c; }),
                  mix([](float d, float c) { return c * d; }), mix([](float d, float c) { return c * d * d; })};
    }
    float* disparities = out.disparity_dp_px.row(y);
    float* confidences = out.confidence.row(y);
    for (int x = 0; x < width; ++x) {
      const Tile& low = blend[taps[x].low];
      const Tile& high = blend[taps[x].high];
      const float t = taps[x].weight_of_high;
      const float total = low.total + t * (high.total - low.total);
      if (total < 1e-6f) {
        disparities[x] = low.plain + t * (high.plain - low.plain);
        continue;
      }
      const float mean = (low.sum + t * (high.sum - low.sum)) / total;
      const float square = (low.sum_of_squares + t * (high.sum_of_squares - low.sum_of_squares)) / total;
      const float variance = std::max(square - mean * mean, 0.0f);
      disparities[x] = mean;
      confidences[x] = total * std::exp(-variance / (2 * options.spread_dp_px * options.spread_dp_px));
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
