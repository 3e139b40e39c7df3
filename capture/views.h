#pragma once
#include <string>

#include "capture/capture.h"
#include "capture/error.h"

/// Captures of a camera without dual pixels hold mosaics alone: the frames' views are empty.
namespace dualpixel {

inline bool has_views(const Capture& capture) { return !capture.frames.front().left.empty(); }

/// Whether it has views or mosaics; where it has neither, there is but a picture that somebody else developed.
inline bool holds_photosites(const Capture& capture) {
  return has_views(capture) || !capture.frames.front().mosaic.empty();
}

/// Throws InputError where it has none; `path` begins the message.
inline void require_views(const Capture& capture, const std::string& path) {
  if (has_views(capture)) return;
  throw InputError(printable(path) +
                   ": has no dual-pixel views; `portrait` in mode seg, `info`, `score` and `report` can use it");
}

}  // namespace dualpixel
