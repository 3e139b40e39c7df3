#include "scenes/people/makehuman/assets.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <string_view>

#include "capture/error.h"
#include "capture/files.h"
#include "scenes/people/makehuman/body_parts.h"
#include "scenes/people/makehuman/fitted_asset.h"
#include "scenes/people/makehuman/morphed_body.h"
#include "scenes/people/makehuman/obj.h"
#include "scenes/people/makehuman/text_lines.h"
#include "scenes/people/makehuman/textures.h"

namespace dualpixel::scenes {
namespace {

namespace fs = std::filesystem;

/// Files with this ending ("": all) below a folder, sorted; none where there is no such folder.
std::vector<std::string> files_below(const fs::path& folder, const std::string& ending) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file(error) && (ending.empty() || it->path().extension() == ending))
      found.push_back(it->path().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

MakeHumanAssets::MakeHumanAssets(const std::string& root) : folder(root) {
  for (const char* part : {"3dobjs", "targets", "rigs", "skins", "hair", "clothes", "eyes", "eyebrows", "eyelashes"}) {
    for (const std::string& path : files_below(fs::path(folder) / part, ""))
      hash += fs::relative(path, folder).string() + " " + file_hash(path) + "\n";
  }
  hash = hash_of(hash);
  const auto in_folder = [&](const std::string& name) { return (fs::path(folder) / name).string(); };
  const std::string base_path = in_folder("3dobjs/base.obj");
  ObjMesh obj = read_obj(base_path, "body");
  if (obj.positions.empty() || obj.faces.triangles.empty())
    throw InputError(fmt::format("{}: no group 'body'", printable(base_path)));
  base.positions = std::move(obj.positions);
  for (vec3& p : base.positions) p *= kMetersPerUnit;
  base.body = std::move(obj.faces);
  for (auto& [group, vertices] : obj.group_vertices) {
    if (group.rfind("joint-", 0) != 0) continue;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    base.joints[group] = vertices;
  }
  require_a_body(base, base_path);
  const int count = static_cast<int>(base.positions.size());
  base.weights = read_weights(in_folder("rigs/default_weights.mhw"), count);
  vec3 ignored(0);
  for (const std::string& path : files_below(in_folder("skins"), ".png")) {
    skins.push_back({fs::path(path).parent_path().filename().string(), read_texture(path, ignored)});
  }
  for (const std::string& path : files_below(in_folder("eyes"), ".png")) irises.push_back(read_texture(path, ignored));
  const auto read_all = [&](const char* name, std::vector<FittedAsset>& to) {
    for (const std::string& path : files_below(in_folder(name), ".mhclo")) to.push_back(read_fitted(path, count));
  };
  read_all("hair", hair);
  read_all("clothes", clothes);
  read_all("eyes", eyes);
  read_all("eyebrows", brows);
  read_all("eyelashes", lashes);
  const auto without_texture = [](const FittedAsset& asset) { return asset.texture == nullptr; };
  for (auto* cards : {&hair, &brows, &lashes}) std::erase_if(*cards, without_texture);
  const auto split = [&](const char* word, std::vector<FittedAsset>& to) {
    for (auto& asset : clothes) {
      if (asset.name.find(word) != std::string::npos) to.push_back(asset);
    }
    std::erase_if(clothes, [&](const FittedAsset& asset) { return asset.name.find(word) != std::string::npos; });
  };
  split("fedora", hats);
  split("shoes", shoes);
  for (const char* name : {"head", "nose", "mouth", "chin", "forehead", "neck", "stomach", "torso", "hip"}) {
    for (const std::string& path : files_below(fs::path(folder) / "targets" / name, ".target")) {
      const std::string stem = fs::path(path).stem().string(), ending = "-incr";
      if (!stem.ends_with(ending)) continue;
      const std::string pair = stem.substr(0, stem.size() - ending.size());
      std::error_code error;
      if (fs::is_regular_file(fs::path(path).parent_path() / (pair + "-decr.target"), error))
        details.push_back(std::string(name) + "/" + pair);
    }
  }
}

const MorphTarget& MakeHumanAssets::target(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  auto& slot = targets_[name];
  if (!slot) {
    auto read = std::make_unique<MorphTarget>();
    TextLines lines((fs::path(folder) / "targets" / (name + ".target")).string());
    std::vector<std::string_view> words;
    while (lines.next(words)) {
      if (words.size() < 4) lines.fail("a target's row is a vertex and three numbers");
      read->vertex.push_back(lines.index(words[0], static_cast<int>(base.positions.size())));
      read->offset.push_back(kMetersPerUnit *
                             vec3(lines.number(words[1]), lines.number(words[2]), lines.number(words[3])));
    }
    slot = std::move(read);
  }
  return *slot;
}

}  // namespace dualpixel::scenes
