#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "scenes/people/makehuman/asset_types.h"

/// The rigid parts that a MakeHuman body is skinned to.
namespace dualpixel::scenes {

enum Part : std::uint8_t { kPelvis, kChest, kNeck, kHead, kFirstOfSide };
enum SidePart : std::uint8_t { kUpperArm, kForeArm, kTwist, kHand, kThigh, kShin, kFoot, kFirstFinger };
inline constexpr int kFingers = 4, kPhalanges = 3;
inline constexpr int kSideParts = kFirstFinger + kFingers * kPhalanges;
inline constexpr int kParts = kFirstOfSide + 2 * kSideParts;

/// Of SidePart: 0 left, 1 right.
inline int part_of(int side, int part) { return kFirstOfSide + side * kSideParts + part; }

using Weights = std::vector<std::pair<int, float>>;

/// Reads a .mhw file: weights per bone of the default rig, merged to parts; they sum to 1 for each vertex.
PartWeights read_weights(const std::string& path, int base_vertices);

}  // namespace dualpixel::scenes
