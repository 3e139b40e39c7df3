#include "datasets/plan/assets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "capture/path_beside.h"
#include "scenes/framing/scene_document.h"
#include "scenes/kinds/kinds.h"

namespace dualpixel::datasets {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string gltf_of(const std::string& path, const json& scene_file) {
  const auto found = scene_file.find("gltf");
  if (found == scene_file.end() || !found->is_string()) {
    throw InputError(printable(path) + ": /gltf: is required: must name the glTF file");
  }
  return path_beside(path, found->get<std::string>());
}

Asset file_asset(const std::string& path, double weight) {
  Asset asset{.scene_file = scenes::read_scene_document(path), .path = path, .weight = weight};
  asset.scene = {{"file", path}, {"xxh64", scene_hash(path, asset.scene_file)}};
  asset.identity = file_hash(gltf_of(path, asset.scene_file));
  return asset;
}

/// Files under a folder in order of their paths.
std::vector<std::string> files_under(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder, error)) {
    if (entry.is_regular_file(error)) paths.push_back(entry.path().lexically_normal().string());
  }
  if (error) throw InputError(printable(folder) + ": cannot be read as a folder: " + error.message());
  std::sort(paths.begin(), paths.end());
  return paths;
}

bool is_scene_file(const std::string& path) {
  if (!path.ends_with(".json")) return false;
  try {
    const json document = read_json_file(path);
    return document.is_object() && document.contains("gltf") && document.contains("version");
  } catch (const InputError&) {
    return false;  // some other file that lies beside models
  }
}

/// Scene files, and those glTF files that none of them names.
std::vector<Asset> folder_assets(const SceneSource& source) {
  std::vector<Asset> assets;
  std::set<std::string> named;
  const std::vector<std::string> paths = files_under(source.folder);
  for (const std::string& path : paths) {
    if (!is_scene_file(path)) continue;
    assets.push_back(file_asset(path, 1));
    named.insert(fs::path(gltf_of(path, assets.back().scene_file)).lexically_normal().string());
  }
  for (const std::string& path : paths) {
    if (scenes::is_gltf(path) && !named.contains(path)) assets.push_back(file_asset(path, 1));
  }
  if (assets.empty()) throw InputError(printable(source.folder) + ": holds no scene file and no .glb or .gltf file");
  for (Asset& asset : assets) asset.weight = source.weight / static_cast<double>(assets.size());
  return assets;
}

std::vector<Asset> kind_assets(const SceneSource& source) {
  const scenes::SceneKind& kind = scenes::scene_kind(source.kind);
  const double count = static_cast<double>(source.seeds[1] - source.seeds[0] + 1);
  const json start = scenes::scene_file_start(kind, {source.kind, source.seeds[0], scenes::assignments_of(source.set)});
  std::vector<Asset> assets;
  for (std::uint64_t seed = source.seeds[0]; seed <= source.seeds[1]; ++seed) {
    json scene = {{"kind", source.kind}, {"seed", seed}};
    if (!source.set.empty()) scene["set"] = source.set;
    const std::string identity = fmt::format("{} {}", source.kind, seed);
    assets.push_back({std::move(scene), start, identity, identity, source.weight / count});
  }
  return assets;
}

std::vector<Asset> assets_of(const SceneSource& source) {
  if (!source.file.empty()) return {file_asset(source.file, source.weight)};
  return source.folder.empty() ? kind_assets(source) : folder_assets(source);
}

std::vector<Asset> all_assets(const Recipe& recipe) {
  std::vector<Asset> all;
  for (std::size_t i = 0; i < recipe.scenes.size(); ++i) {
    try {
      std::vector<Asset> some = assets_of(recipe.scenes[i]);
      all.insert(all.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: /scenes/{}: {}", printable(recipe.path), i, error.what()));
    }
  }
  return all;
}

/// Which split each of the identities is in: their order is shuffled by the seed, and dealt out by the shares.
std::map<std::string, std::size_t> deal(const Recipe& recipe, const std::set<std::string>& identities,
                                        const char* field) {
  const auto splits = static_cast<std::size_t>(
      std::count_if(recipe.shares.begin(), recipe.shares.end(), [](double share) { return share > 0; }));
  if (identities.size() < splits) {
    throw InputError(fmt::format("{}: /{}: {} different {}: must be {} at least, one for each split of /split",
                                 printable(recipe.path), field, identities.size(),
                                 identities.size() == 1 ? "file or seed" : "files or seeds", splits));
  }
  std::vector<std::pair<std::uint64_t, std::string>> order;
  for (const std::string& identity : identities) {
    order.emplace_back(Draws(recipe.seed, 0, "split " + identity).bits(), identity);
  }
  std::sort(order.begin(), order.end());
  const auto counts = split_counts(order.size(), recipe.shares);
  std::map<std::string, std::size_t> result;
  std::size_t next = 0;
  for (std::size_t split = 0; split < kSplitCount; ++split) {
    for (std::size_t i = 0; i < counts[split]; ++i) result[order[next++].second] = split;
  }
  return result;
}

void add_environments(const Recipe& recipe, Assets& assets) {
  std::map<std::string, std::string> identities;  // of each path
  std::set<std::string> different;
  for (const std::string& path : files_under(recipe.relations.environments)) {
    if (!path.ends_with(".exr") && !path.ends_with(".hdr")) continue;
    different.insert(identities[path] = file_hash(path));
  }
  if (different.empty()) {
    throw InputError(printable(recipe.relations.environments) + ": holds no .exr and no .hdr file");
  }
  const auto splits = deal(recipe, different, "relations/environments");
  for (const auto& [path, identity] : identities) assets[splits.at(identity)].environments.push_back(path);
}

}  // namespace

std::array<std::size_t, kSplitCount> split_counts(std::size_t things, const std::array<double, kSplitCount>& shares) {
  std::array<std::size_t, kSplitCount> counts{};
  std::size_t sum = 0;
  for (std::size_t i = 0; i < kSplitCount; ++i) {
    if (shares[i] <= 0) continue;
    counts[i] = std::max<std::size_t>(1, std::lround(shares[i] * static_cast<double>(things)));
    sum += counts[i];
  }
  for (; sum > things; --sum) --*std::max_element(counts.begin(), counts.end());
  *std::max_element(counts.begin(), counts.end()) += things - sum;
  return counts;
}

std::string scene_hash(const std::string& file, const json& scene_file) {
  const std::string gltf = file_hash(gltf_of(file, scene_file));
  return scenes::is_gltf(file) ? gltf : hash_of(file_hash(file) + gltf);
}

Assets gather_assets(const Recipe& recipe) {
  std::vector<Asset> all = all_assets(recipe);
  std::erase_if(all, [](const Asset& asset) { return asset.weight <= 0; });
  if (all.empty()) throw InputError(printable(recipe.path) + ": /scenes: all weights are 0: one must not be");
  std::set<std::string> identities;
  for (const Asset& asset : all) identities.insert(asset.identity);
  const auto splits = deal(recipe, identities, "scenes");
  Assets assets;
  for (Asset& asset : all) assets[splits.at(asset.identity)].scenes.push_back(std::move(asset));
  if (!recipe.relations.environments.empty()) add_environments(recipe, assets);
  return assets;
}

}  // namespace dualpixel::datasets
