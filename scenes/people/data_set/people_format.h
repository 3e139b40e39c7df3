#pragma once

/// The sizes and names that people sets (docs/people.md), the network that learns from them, and nothing else agree on.
namespace dualpixel::scenes {

inline constexpr int kPictureSide_px = 256;
/// What a set consists of, and a shard: written last, and what it holds the hashes of.
inline constexpr const char *kSetFile = "people.json", *kShardFile = "shard.json";
inline constexpr const char* kShardFiles[] = {"pictures.npy", "masks.npy", "keypoints.npy", "faces.npy",
                                              "samples.json"};
inline constexpr int kKeypoints = 17;  ///< COCO's: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles

}  // namespace dualpixel::scenes
