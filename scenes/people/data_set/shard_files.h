#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace dualpixel::scenes {

/// The contents of a shard's files, N samples in C order (docs/people.md).
struct PeopleArrays {
  std::vector<std::uint8_t> pictures;  ///< N x 256 x 256 x 3
  std::vector<std::uint8_t> masks;     ///< N x 256 x 256
  std::vector<float> keypoints;        ///< N x 17 x 3
  std::vector<float> faces;            ///< N x 4
  std::string samples_json;            ///< a list of N objects
};

/// Writes the files of a shard into a folder that is there, and last shard.json: `recipe` with the files' hashes.
void write_shard_files(const std::string& folder, const PeopleArrays& arrays, nlohmann::ordered_json recipe);

/// The content of people.json: format and sizes, then `recipe`, which says what all samples depend on.
nlohmann::ordered_json people_index(int count, const nlohmann::ordered_json& recipe, int shards);

}  // namespace dualpixel::scenes
