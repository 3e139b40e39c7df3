#pragma once
#include "scenes/people/sample.h"

/// File names of a people set (docs/people.md).
namespace dualpixel::scenes {

/// Of a set and of a shard: written last. A shard's holds the hashes of its files.
inline constexpr const char *kSetFile = "people.json", *kShardFile = "shard.json";
inline constexpr const char* kShardFiles[] = {"pictures.npy", "masks.npy", "keypoints.npy", "faces.npy",
                                              "samples.json"};

}  // namespace dualpixel::scenes
