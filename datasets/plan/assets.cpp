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
#include "simulator/scene/gltf/gltf.h"

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

/// Reads files for an entry of a recipe's scenes.
struct Reader {
  bool own_light;  ///< the scenes' own environments are used: nothing in the recipe replaces them
  std::vector<std::string>& warnings;
  std::map<std::string, std::string> hashes = {};  ///< of pictures, by path

  /// Hash of the picture that a scene file names to light the scene; empty: it names none.
  std::string environment_of(const std::string& path, const json& scene_file) {
    const json light = own_light && scene_file.is_object() ? scene_file.value("environment", json()) : json();
    // "set" may give the model: a path beside another one is refused later
    if (!light.is_object() || !light.value("path", json()).is_string()) return "";
    const std::string picture = path_beside(path, light["path"].get<std::string>());
    std::string& hash = hashes[picture];
    if (hash.empty()) hash = file_hash(picture);
    return hash;
  }
};

Asset file_asset(const std::string& path, double weight, Reader& reader) {
  SceneOrigin origin{.scene_file = scenes::read_scene_document(path), .path = path};
  origin.scene = {{"file", path}, {"xxh64", scene_hash(path, origin.scene_file)}};
  origin.geometry = simulator::geometry_hash(gltf_of(path, origin.scene_file));
  origin.environment = reader.environment_of(path, origin.scene_file);
  return {std::make_shared<const SceneOrigin>(std::move(origin)), {}, weight};
}

/// Files under a folder in order of their paths.
std::vector<std::string> files_under(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> paths;
  fs::recursive_directory_iterator entry(folder, error);
  std::string last = folder;
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code none;  // of a link that leads nowhere
    last = entry->path().string();
    if (entry->is_regular_file(none)) paths.push_back(entry->path().lexically_normal().string());
  }
  if (error) throw InputError(printable(last) + ": cannot be read as a folder: " + error.message());
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// Other JSON files beside models are skipped; a file that cannot be parsed may be a broken scene file, so it is an
/// error.
bool is_scene_file(const std::string& path) {
  if (!path.ends_with(".json")) return false;
  const json document = read_json_file(path);
  return document.is_object() && document.contains("gltf") && document.contains("version");
}

/// Scene files, and those glTF files that none of them names.
std::vector<Asset> folder_assets(const SceneSource& source, Reader& reader) {
  std::vector<Asset> assets;
  std::set<std::string> named;
  std::vector<std::string> others;
  const std::vector<std::string> paths = files_under(source.folder);
  for (const std::string& path : paths) {
    if (is_scene_file(path)) {
      assets.push_back(file_asset(path, 1, reader));
      named.insert(fs::path(gltf_of(path, assets.back().origin->scene_file)).lexically_normal().string());
    } else if (path.ends_with(".json")) {
      others.push_back(path);
    }
  }
  for (const std::string& path : paths) {
    if (scenes::is_gltf(path) && !named.contains(path)) assets.push_back(file_asset(path, 1, reader));
  }
  if (assets.empty()) throw InputError(printable(source.folder) + ": holds no scene file and no .glb or .gltf file");
  for (Asset& asset : assets) asset.weight = source.weight / static_cast<double>(assets.size());
  if (!others.empty()) {
    reader.warnings.push_back(fmt::format("{}: no scene file, which has version and gltf: left out{}",
                                          printable(others.front()),
                                          others.size() > 1 ? fmt::format(", with {} more", others.size() - 1) : ""));
  }
  return assets;
}

std::vector<Asset> kind_assets(const SceneSource& source, Reader& reader) {
  const scenes::SceneKind& kind = scenes::scene_kind(source.kind);
  SceneOrigin origin{.scene = {{"kind", source.kind}}, .path = source.kind, .geometry = source.kind};
  origin.scene_file =
      scenes::scene_file_start(kind, {source.kind, source.seeds[0], scenes::assignments_of(source.set)});
  if (!source.set.empty()) origin.scene["set"] = source.set;
  origin.environment = reader.environment_of(source.kind, origin.scene_file);
  std::map<std::string, std::shared_ptr<const SceneOrigin>> origins;  // "": models that the seed makes
  scenes::SceneOrder order{source.kind, 0, scenes::assignments_of(source.set)};
  const auto origin_of = [&](std::uint64_t seed) {
    order.seed = seed;
    const std::string model = scenes::fixed_model_of(kind, order);
    std::shared_ptr<const SceneOrigin>& shared = origins[model];
    if (!shared) {
      SceneOrigin own = origin;
      own.one_model = !model.empty();
      if (own.one_model) own.geometry += " " + model;
      shared = std::make_shared<const SceneOrigin>(std::move(own));
    }
    return shared;
  };
  const double count = static_cast<double>(source.seeds[1] - source.seeds[0] + 1);
  std::vector<Asset> assets;
  assets.reserve(static_cast<std::size_t>(count));
  for (std::uint64_t seed = source.seeds[0]; seed <= source.seeds[1]; ++seed) {
    assets.push_back({origin_of(seed), seed, source.weight / count});
  }
  return assets;
}

std::vector<Asset> assets_of(const SceneSource& source, Reader& reader) {
  if (!source.file.empty()) return {file_asset(source.file, source.weight, reader)};
  return source.folder.empty() ? kind_assets(source, reader) : folder_assets(source, reader);
}

/// Whether no sample is lit by the picture that its scene file names.
bool replaces_light(const Recipe& recipe) {
  const auto model = recipe.set.find("environment.model");
  const bool another_model =
      model != recipe.set.end() && std::none_of(model->second.values.begin(), model->second.values.end(),
                                                [](const json& value) { return value == "file"; });
  return another_model || !recipe.relations.environments.empty() || recipe.set.contains("environment") ||
         recipe.set.contains("environment.path");
}

std::vector<Asset> all_assets(const Recipe& recipe, std::vector<std::string>& warnings) {
  Reader reader{!replaces_light(recipe), warnings};
  std::vector<Asset> all;
  for (std::size_t i = 0; i < recipe.scenes.size(); ++i) {
    if (recipe.scenes[i].weight <= 0) continue;
    try {
      std::vector<Asset> some = assets_of(recipe.scenes[i], reader);
      all.insert(all.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: /scenes/{}: {}", printable(recipe.path), i, error.what()));
    }
  }
  if (all.empty()) throw InputError(printable(recipe.path) + ": /scenes: all weights are 0: one must not be");
  return all;
}

/// The number by which things of one name are dealt out: by chance, and the same in every recipe of that seed.
std::uint64_t key_of(const Recipe& recipe, const std::string& name) {
  return Draws(recipe.seed, 0, "split " + name).bits();
}

/// Each scene's key; scenes that share geometry or a picture that lights them, which are a group, have the same.
std::vector<std::uint64_t> family_keys(const Recipe& recipe, const std::vector<Asset>& scenes) {
  std::map<std::uint64_t, std::uint64_t> parents;
  const auto root = [&](std::uint64_t key) {
    for (auto parent = parents.find(key); parent != parents.end(); parent = parents.find(key)) key = parent->second;
    return key;
  };
  std::vector<std::uint64_t> keys;
  keys.reserve(scenes.size());
  for (const Asset& scene : scenes) {
    keys.push_back(key_of(recipe, scene.geometry()));
    if (scene.origin->environment.empty()) continue;
    const std::uint64_t a = root(keys.back()), b = root(key_of(recipe, scene.origin->environment));
    if (a != b) parents[std::max(a, b)] = std::min(a, b);
  }
  // a group's root is its least key: dealt out by that, large groups would all be in the first split
  const auto key_of_group = [&](std::uint64_t key) { return simulator::hash(recipe.seed, root(key)); };
  if (!parents.empty()) std::transform(keys.begin(), keys.end(), keys.begin(), key_of_group);
  return keys;
}

/// Which split each key is in: their order is one by chance, and is cut by the shares.
class Deal {
 public:
  /// `one` and `many` are what messages call the things.
  Deal(const Recipe& recipe, std::vector<std::uint64_t> keys, const char* field, const char* one, const char* many)
      : order_(std::move(keys)) {
    std::sort(order_.begin(), order_.end());
    order_.erase(std::unique(order_.begin(), order_.end()), order_.end());
    const std::size_t splits = splits_with_a_share(recipe);
    if (order_.size() < splits) {
      throw InputError(fmt::format("{}: /{}: {} {}: must be {} at least, one for each split of /split",
                                   printable(recipe.path), field, order_.size(), order_.size() == 1 ? one : many,
                                   splits));
    }
    counts_ = split_counts(order_.size(), recipe.shares);
  }

  std::size_t split_of(std::uint64_t key) const {
    auto rank = static_cast<std::size_t>(std::lower_bound(order_.begin(), order_.end(), key) - order_.begin());
    std::size_t split = 0;
    for (; rank >= counts_[split]; ++split) rank -= counts_[split];
    return split;
  }

 private:
  std::vector<std::uint64_t> order_;
  std::array<std::size_t, kSplitCount> counts_;
};

void add_environments(const Recipe& recipe, Assets& assets) {
  std::map<std::string, std::uint64_t> keys;  // of each path
  std::vector<std::uint64_t> all;
  for (const std::string& path : files_under(recipe.relations.environments)) {
    const std::string extension = extension_of(path);
    if (extension != ".exr" && extension != ".hdr") continue;
    all.push_back(keys[path] = key_of(recipe, file_hash(path)));
  }
  if (all.empty()) throw InputError(printable(recipe.relations.environments) + ": holds no .exr and no .hdr file");
  const Deal deal(recipe, all, "relations/environments", "different file", "different files");
  for (const auto& [path, key] : keys) assets[deal.split_of(key)].environments.push_back(path);
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

json Asset::scene() const {
  json scene = origin->scene;
  if (seed) scene["seed"] = *seed;
  return scene;
}

std::string Asset::path() const { return seed ? fmt::format("{} {}", origin->path, *seed) : origin->path; }

std::string Asset::geometry() const {
  return seed && !origin->one_model ? fmt::format("{} {}", origin->geometry, *seed) : origin->geometry;
}

const Asset& SplitAssets::scene_at(double share) const {
  const auto end = std::upper_bound(ends.begin(), ends.end(), share * ends.back());
  return scenes[std::min(static_cast<std::size_t>(end - ends.begin()), scenes.size() - 1)];
}

Assets gather_assets(const Recipe& recipe, std::vector<std::string>& warnings) {
  std::vector<Asset> all = all_assets(recipe, warnings);
  const std::vector<std::uint64_t> keys = family_keys(recipe, all);
  const Deal deal(recipe, keys, "scenes", "group of scenes that share no model and no light",
                  "groups of scenes that share no model and no light");
  Assets assets;
  for (std::size_t i = 0; i < all.size(); ++i) {
    SplitAssets& split = assets[deal.split_of(keys[i])];
    split.ends.push_back((split.ends.empty() ? 0 : split.ends.back()) + all[i].weight);
    split.scenes.push_back(std::move(all[i]));
  }
  if (!recipe.relations.environments.empty()) add_environments(recipe, assets);
  return assets;
}

}  // namespace dualpixel::datasets
