#include "pipeline/disparity/upsample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/resample.h"
#include "capture/image/rows.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::pipeline {

OptionFields fields(UpsampleOptions& options) {
  return {{"spread_dp_px", &options.spread_dp_px, 1e-6, 1e6, "DP px", "ours"}};
}

PixelDisparity upsample_tiles(const TileDisparity& tiles, int width, int height, const UpsampleOptions& options) {
  const Image& disparity = tiles.disparity_dp_px;
  const int columns = disparity.width;
  // The grid of whole tiles, whose last row and column may reach over the picture's border.
  const int grid_width = columns * tiles.tile_px;
  const int grid_height = disparity.height * tiles.tile_px;
  std::vector<LinearTap> taps(width);
  for (int x = 0; x < width; ++x) taps[x] = linear_tap(x, grid_width, columns);
  PixelDisparity out{Image(width, height), Image(width, height)};
  const bool has_sigma = !tiles.sigma_dp_px.empty();
  if (has_sigma) out.sigma_dp_px = Image(width, height);
  for_rows(height, [&](int y) {
    const LinearTap line = linear_tap(y, grid_height, disparity.height);
    // Disparity, confidence, and products with confidence; blended between the two rows of tiles. `independent` is
    // what the tiles err by on their own, and has the squares of all weights.
    struct Tile {
      float plain, total, sum, sum_of_squares, plain_variance, variance, shared, independent;
    };
    std::vector<Tile> blend(columns);
    for (int u = 0; u < columns; ++u) {
      const float t = line.weight_of_high;
      const auto tile = [&](int v) {
        const float d = disparity.at(u, v), c = tiles.confidence.at(u, v);
        const float s = has_sigma ? tiles.sigma_dp_px.at(u, v) : 0, shared = has_sigma ? tiles.shared.at(u, v) : 0;
        return Tile{d, c, c * d, c * d * d, s * s, c * s * s, shared * c * s * s, (1 - shared) * c * c * s * s};
      };
      const Tile low = tile(line.low), high = tile(line.high);
      const auto mix = [&](float Tile::*of) { return low.*of + t * (high.*of - low.*of); };
      blend[u] = {mix(&Tile::plain),
                  mix(&Tile::total),
                  mix(&Tile::sum),
                  mix(&Tile::sum_of_squares),
                  mix(&Tile::plain_variance),
                  mix(&Tile::variance),
                  mix(&Tile::shared),
                  (1 - t) * (1 - t) * low.independent + t * t * high.independent};
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
        if (has_sigma) {
          out.sigma_dp_px.at(x, y) = std::sqrt(low.plain_variance + t * (high.plain_variance - low.plain_variance));
        }
        continue;
      }
      const float mean = (low.sum + t * (high.sum - low.sum)) / total;
      const float square = (low.sum_of_squares + t * (high.sum_of_squares - low.sum_of_squares)) / total;
      const float variance = std::max(square - mean * mean, 0.0f);
      disparities[x] = mean;
      confidences[x] = total * std::exp(-variance / (2 * options.spread_dp_px * options.spread_dp_px));
      if (has_sigma) {
        const float all = (low.variance + t * (high.variance - low.variance)) / total;
        const float own = (low.shared + t * (high.shared - low.shared)) / total +
                          ((1 - t) * (1 - t) * low.independent + t * t * high.independent) / (total * total);
        out.sigma_dp_px.at(x, y) = std::sqrt(own + std::max(variance - 2 * (all - own), 0.0f));
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
