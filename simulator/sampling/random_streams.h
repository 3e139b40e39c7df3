#pragma once
#include <cstdint>

namespace dualpixel::simulator {

/// What is drawn from one seed: hash(seed, stream, ...) gives each its own numbers. The values are part of what a seed
/// means: a capture is the same bytes only as long as they are.
enum RandomStream : std::uint64_t {
  kAllInFocusStream = 1,    ///< of truth
  kPhotographStream = 2,    ///< likewise
  kSensorNoiseStream = 3,   ///< of each frame
  kPoseStream = 4,          ///< rendering of each pose of each frame but the very first
  kFixedPatternStream = 5,  ///< of the sensor, under its own seed
  kHotPixelStream = 6,      ///< likewise
  kRowNoiseStream = 7,      ///< of each row of a frame, under the frame's seed
};

}  // namespace dualpixel::simulator
