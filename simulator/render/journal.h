#pragma once
#include <cstdint>
#include <fstream>
#include <map>
#include <mutex>
#include <string>

#include "simulator/render/camera_view.h"
#include "simulator/render/sample_map.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

struct Views;

/// The finished tiles of a long render, kept in a file, so that a program that was stopped can go on where it was. As
/// every tile depends on its own numbers alone, the picture is the same, byte for byte.
///
/// After a header with the key come records, each with a checksum: what was being written when the program ended is
/// found and dropped. All functions may be called by any thread at any time.
class Journal {
 public:
  /// Goes on with the file at `path` where its key is `key`, which must stand for all that the tiles depend on;
  /// otherwise the file is begun anew. Throws InputError where it cannot be written.
  Journal(const std::string& path, std::uint64_t key);

  /// Puts `tile` of the render `render` (a number of its own within this journal) into `views`; false: not known.
  bool restore(std::uint64_t render, const Tile& tile, Views& views);
  void add(std::uint64_t render, const Tile& tile, const Views& views);

  std::size_t known() const { return places_.size(); }

 private:
  std::string path_;
  std::mutex mutex_;
  std::fstream file_;
  std::map<std::pair<std::uint64_t, int>, std::uint64_t> places_;  ///< of the pixels of (render, tile)
};

/// A number that stands for all that `scene` and `camera` hold, and for whatever else `more` says.
std::uint64_t fingerprint(const Scene& scene, const CameraView& camera, const std::string& more);

}  // namespace dualpixel::simulator
