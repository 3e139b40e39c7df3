#include "datasets/state/webdataset.h"

#include <fmt/format.h>

#include <optional>

#include "capture/files.h"
#include "datasets/recipe/recipe.h"
#include "datasets/render/sample_folder.h"
#include "datasets/state/tar.h"

namespace dualpixel::datasets {
namespace {

constexpr const char* kShardsFile = "shards.json";

void add_sample(const nlohmann::json& sample, const std::string& dataset, TarFile& tar) {
  const auto name = sample.at("name").get<std::string>();
  const std::string folder = dataset + "/" + sample.at("folder").get<std::string>() + "/";
  for (const nlohmann::json& file : sample.at("files")) {
    const auto picture = file.get<std::string>();
    tar.add(name + "." + picture, read_file(folder + picture));
  }
  tar.add(name + ".json", read_file(folder + kSampleFile));
}

}  // namespace

int write_webdataset(const std::vector<nlohmann::json>& index, const std::string& dataset, std::uint64_t shard_bytes) {
  NewFolder folder(dataset + "/webdataset", kShardsFile);
  nlohmann::ordered_json shards = nlohmann::ordered_json::array();
  for (const auto& split : kSplits) {
    std::optional<TarFile> tar;
    int count = 0;
    for (const nlohmann::json& sample : index) {
      if (sample.at("split") != split.name) continue;
      if (!tar) {
        const std::string name = fmt::format("{}-{:06}.tar", split.name, count++);
        tar.emplace(folder.path() + "/" + name);
        shards.push_back({{"file", name}, {"samples", 0}});
      }
      add_sample(sample, dataset, *tar);
      shards.back()["samples"] = shards.back()["samples"].get<int>() + 1;
      if (tar->bytes() < shard_bytes) continue;
      tar->close();
      tar.reset();
    }
    if (tar) tar->close();
  }
  write_file(folder.path() + "/" + kShardsFile, shards.dump(1) + "\n");
  folder.commit();
  return static_cast<int>(shards.size());
}

}  // namespace dualpixel::datasets
