#pragma once
#include <cstdint>

namespace dualpixel::simulator {

struct Tile;
struct Views;

/// What remembers finished tiles, so that a long render can go on where it was stopped: every tile depends on its own
/// numbers alone. Both functions may be called by any thread at any time, and may throw.
class TileStore {
 public:
  virtual ~TileStore() = default;
  /// Puts `tile` of the render `render` (a number of its own within this store) into `views`; false: not known.
  virtual bool restore(std::uint64_t render, const Tile& tile, Views& views) = 0;
  virtual void add(std::uint64_t render, const Tile& tile, const Views& views) = 0;
};

}  // namespace dualpixel::simulator
