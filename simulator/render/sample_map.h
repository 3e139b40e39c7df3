#pragma once
#include <pmmintrin.h>
#include <tbb/parallel_for.h>
#include <xmmintrin.h>

#include <algorithm>
#include <cstdint>
#include <vector>

/// How many samples each part of a picture gets.
namespace dualpixel::simulator {

struct SampleMap {
  static constexpr int kTile = 16;  ///< photosites a side: neighbors share the part of the scene that caches hold
  int width_px = 0, height_px = 0;
  std::vector<std::uint32_t> samples;  ///< of each tile's photosites, row by row
  std::vector<float> error_ratio;      ///< expected standard error over the allowed one, RMS; empty: not known

  int columns() const { return (width_px + kTile - 1) / kTile; }
  int rows() const { return (height_px + kTile - 1) / kTile; }
  double total_samples() const;
};

SampleMap uniform_map(int width_px, int height_px, std::uint32_t samples);

/// Photosites [x0, x1) x [y0, y1).
struct Tile {
  int index, x0, x1, y0, y1;
  std::uint32_t samples;
};

inline Tile tile_at(const SampleMap& map, int index) {
  const int x0 = index % map.columns() * SampleMap::kTile, y0 = index / map.columns() * SampleMap::kTile;
  return {index,
          x0,
          std::min(x0 + SampleMap::kTile, map.width_px),
          y0,
          std::min(y0 + SampleMap::kTile, map.height_px),
          map.samples[index]};
}

/// `work(tile)` for every tile, on all threads.
template <class Work>
void for_tiles(const SampleMap& map, const Work& work) {
  tbb::parallel_for(
      tbb::blocked_range<int>(0, map.columns() * map.rows()),
      [&](const tbb::blocked_range<int>& range) {
        // Embree's advice: denormals cost time and carry no light.
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
        for (int i = range.begin(); i < range.end(); ++i) work(tile_at(map, i));
      },
      tbb::simple_partitioner());
}

}  // namespace dualpixel::simulator
