#pragma once
#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <limits>
#include <vector>

#include "simulator/render/light/light_table.h"
#include "simulator/render/render_options.h"

namespace dualpixel::simulator {

/// Light at the points around one cell of a lattice.
struct CellLight {
  std::uint64_t key = 0;     ///< of the cell, for this number of reflections
  SurfaceLight light[2][2];  ///< at the points: of each row, left and right
  /// Between the least and the largest, over the largest. Of soft light 0 where noise explains it; other samples than
  /// those of `light` may have decided that.
  float soft_difference = 0, hard_difference = 0;
  float from_m = std::numeric_limits<float>::infinity();  ///< the least of them
};

/// The cells that one thread has used last: most are wanted again at once.
class RecentCells {
 public:
  CellLight& slot(std::uint64_t key) { return cells_[(key >> 1) % kCells]; }

 private:
  static constexpr std::size_t kCells = 1024;  // in the processor's second cache
  std::vector<CellLight> cells_ = std::vector<CellLight>(kCells);
};

/// `scramble`: of the light samples; other numbers give independent errors.
struct LightCache {
  explicit LightCache(const LightCacheOptions& o, std::uint64_t scramble_of_samples = 0)
      : options(o), scramble(scramble_of_samples), table(static_cast<std::size_t>(o.light_memory_mb * (1 << 20))) {}

  LightCacheOptions options;
  std::uint64_t scramble;
  LightTable table;
  tbb::enumerable_thread_specific<RecentCells> recent;
};

}  // namespace dualpixel::simulator
