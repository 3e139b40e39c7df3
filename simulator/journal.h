#pragma once
#include <cstdint>
#include <fstream>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "simulator/render/tile_store.h"

namespace dualpixel::simulator {

struct CameraView;
struct Scene;

/// The finished tiles of a long render, kept in a file, so that a program that was stopped can go on where it was. As
/// every tile depends on its own numbers alone, the picture is the same, byte for byte.
///
/// After a header with the key come records, each with a checksum: what was being written when the program ended is
/// found and dropped.
class Journal : public TileStore {
 public:
  /// Begins the file at `path`, or continues it where its key is `key`, which must identify all that the tiles
  /// depend on. This and all else throws InputError where the file is another's, or cannot be read or written.
  Journal(const std::string& path, std::uint64_t key);

  bool restore(std::uint64_t render, const Tile& tile, Views& views) override;
  void add(std::uint64_t render, const Tile& tile, const Views& views) override;

 private:
  /// Takes in the whole records of the open file; returns the bytes up to their end.
  std::uint64_t read_records();

  struct Location {
    std::uint64_t offset;  ///< of the pixels
    std::uint32_t floats;
  };
  std::string path_;
  std::mutex mutex_;
  std::fstream file_;
  std::map<std::pair<std::uint64_t, int>, Location> records_;  ///< of (render, tile)
};

/// A hash of all that `scene` and `camera` hold, and of `more`.
std::uint64_t fingerprint(const Scene& scene, const CameraView& camera, const std::string& more);

}  // namespace dualpixel::simulator
