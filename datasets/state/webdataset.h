#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace dualpixel::datasets {

inline constexpr std::uint64_t kShardBytes = 1'000'000'000;

/// Packs samples as WebDataset (github.com/webdataset) reads them, into DATASET/webdataset: tar files of about
/// `shard_bytes`, train-000000.tar and so on, whose files are named by sample and picture, 000017.left.npy,
/// 000017.json (its sample.json). `index` is that of merge_samples(). What was there is replaced. Returns how many
/// there are. Throws InputError.
int write_webdataset(const std::vector<nlohmann::json>& index, const std::string& dataset,
                     std::uint64_t shard_bytes = kShardBytes);

}  // namespace dualpixel::datasets
