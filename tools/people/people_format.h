#pragma once

/// The sizes that people sets (docs/people.md), the network that learns from them, and nothing else agree on.
namespace dualpixel::tools {

inline constexpr int kPictureSide_px = 256;
inline constexpr int kKeypoints = 17;  ///< COCO's: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles

}  // namespace dualpixel::tools
