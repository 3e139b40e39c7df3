#include "scenes/people/makehuman/fitted_asset.h"

#include <fmt/format.h>
#include <filesystem>
#include <string_view>
#include <vector>

#include "capture/error.h"
#include "scenes/people/makehuman/obj.h"
#include "scenes/people/makehuman/text_lines.h"
#include "scenes/people/makehuman/textures.h"

namespace dualpixel::scenes {
namespace {

namespace fs = std::filesystem;

/// A row of the section "verts": one vertex of the base mesh, or three with weights and an offset.
void read_hold(const TextLines& lines, const std::vector<std::string_view>& words, int base_vertices,
               FittedAsset& asset) {
  FittedAsset::Hold hold;
  if (words.size() != 1 && words.size() != 9) lines.fail("a row is a vertex, or three with weights and an offset");
  if (words.size() == 9) {
    for (int i = 0; i < 3; ++i) {
      hold.vertex[i] = lines.index(words[i], base_vertices);
      hold.weight[i] = lines.number(words[3 + i]);
      hold.offset[i] = lines.number(words[6 + i]) * kMetersPerUnit;
    }
  } else {
    hold.vertex.fill(lines.index(words[0], base_vertices));
  }
  if (asset.holds.size() >= kMostVertices) lines.fail("too many vertices");
  asset.holds.push_back(hold);
}

/// A row of the section "delete_verts": vertices and ranges such as "3 - 9".
void read_hidden(const TextLines& lines, const std::vector<std::string_view>& words, int base_vertices,
                 FittedAsset& asset) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "-") continue;
    const int from = lines.index(words[i], base_vertices);
    int to = from;
    if (i + 2 < words.size() && words[i + 1] == "-") to = lines.index(words[i + 2], base_vertices), i += 2;
    for (int v = from; v <= to; ++v) asset.hides[static_cast<std::size_t>(v)] = true;
  }
}

}  // namespace

FittedAsset read_fitted(const std::string& path, int base_vertices) {
  TextLines lines(path);
  FittedAsset asset;
  asset.name = fs::path(path).stem().string();
  asset.hides.assign(static_cast<std::size_t>(base_vertices), false);
  const fs::path folder = fs::path(path).parent_path();
  enum class Section { header, vertices, hidden } section = Section::header;
  std::string obj, material;
  std::vector<std::string_view> words;
  while (lines.next(words)) {
    if (!lines.is_number(words[0])) {
      const std::string key(words[0]);
      const std::string value = words.size() > 1 ? std::string(words[1]) : "";
      // other keys may follow these two before their rows
      if (key == "verts") section = Section::vertices;
      if (key == "delete_verts") section = Section::hidden;
      if (key == "obj_file") obj = value;
      if (key == "material") material = value;
      for (int axis = 0; axis < 3; ++axis) {
        constexpr const char* kScale[] = {"x_scale", "y_scale", "z_scale"};
        if (key != kScale[axis]) continue;
        if (words.size() < 4) lines.fail("a scale is two vertices and a length");
        asset.scale[axis] = {lines.index(words[1], base_vertices), lines.index(words[2], base_vertices),
                             lines.number(words[3])};
      }
    } else if (section == Section::vertices) {
      read_hold(lines, words, base_vertices, asset);
    } else if (section == Section::hidden) {
      read_hidden(lines, words, base_vertices, asset);
    }
  }
  if (obj.empty() || obj.find("..") != std::string::npos || obj.front() == '/')
    lines.fail("obj_file must name a file beside this one");
  asset.mesh = read_obj((folder / obj).string(), "").faces;
  if (asset.mesh.vertices > static_cast<int>(asset.holds.size())) {
    lines.fail(
        fmt::format("{} vertices are fitted, {} has {}", asset.holds.size(), printable(obj), asset.mesh.vertices));
  }
  if (!material.empty() && material.find("..") == std::string::npos && material.front() != '/') {
    asset.texture = material_texture((folder / material).string(), asset.mean_color);
  }
  return asset;
}

}  // namespace dualpixel::scenes
