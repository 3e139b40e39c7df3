#include "scenes/people/makehuman/body_parts.h"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"

namespace dualpixel::scenes {
namespace {

/// The parts that a bone of the default rig belongs to, with weights.
std::vector<std::pair<int, float>> parts_of_bone(const std::string& bone) {
  const auto starts = [&](const char* text) { return bone.rfind(text, 0) == 0; };
  const int side = bone.ends_with(".R") ? 1 : 0;
  const auto on_side = [&](int part) { return std::vector<std::pair<int, float>>{{part_of(side, part), 1.0f}}; };
  if (bone == "root" || starts("pelvis") || bone == "spine05") return {{kPelvis, 1}};
  if (bone == "spine04") return {{kPelvis, 0.5f}, {kChest, 0.5f}};
  if (starts("spine") || starts("breast") || starts("clavicle")) return {{kChest, 1}};
  if (starts("shoulder01")) return {{kChest, 0.6f}, {part_of(side, kUpperArm), 0.4f}};
  if (starts("upperarm")) return on_side(kUpperArm);
  if (starts("lowerarm01")) return on_side(kForeArm);
  if (starts("lowerarm02")) return on_side(kTwist);
  if (starts("finger") && bone.size() > 8 && bone[6] >= '2' && bone[6] <= '5' && bone[8] >= '1' && bone[8] <= '3') {
    return on_side(kFirstFinger + (bone[6] - '2') * kPhalanges + (bone[8] - '1'));
  }
  if (starts("wrist") || starts("metacarpal") || starts("finger")) return on_side(kHand);
  if (starts("upperleg")) return on_side(kThigh);
  if (starts("lowerleg")) return on_side(kShin);
  if (starts("foot") || starts("toe")) return on_side(kFoot);
  if (bone == "neck01") return {{kChest, 0.5f}, {kNeck, 0.5f}};
  if (starts("neck")) return {{kNeck, 1}};
  return {{kHead, 1}};
}

}  // namespace

PartWeights read_weights(const std::string& path, int base_vertices) {
  PartWeights weights;
  weights.of_vertex.resize(static_cast<std::size_t>(base_vertices));
  const nlohmann::json json = read_json_file(path);
  if (!json.is_object() || !json.contains("weights") || !json["weights"].is_object()) {
    throw InputError(fmt::format("{}: no JSON object with 'weights'", printable(path)));
  }
  for (const auto& [bone, list] : json["weights"].items()) {
    if (!list.is_array())
      throw InputError(fmt::format("{}: weights of '{}' are no list", printable(path), printable(bone)));
    for (const auto& entry : list) {
      if (!entry.is_array() || entry.size() != 2 || !entry[0].is_number_integer() || !entry[1].is_number() ||
          entry[0].get<std::int64_t>() < 0 || entry[0].get<std::int64_t>() >= base_vertices) {
        throw InputError(fmt::format("{}: weights of '{}' are not pairs of a vertex and a number", printable(path),
                                     printable(bone)));
      }
      const auto weight = entry[1].get<float>();
      if (!(weight >= 0 && weight <= 1)) {
        throw InputError(fmt::format("{}: weights of '{}': {}: 0 to 1 is allowed", printable(path), printable(bone),
                                     entry[1].dump()));
      }
      for (const auto& [part, share] : parts_of_bone(bone)) {
        weights.of_vertex[entry[0].get<std::size_t>()].emplace_back(part, share * weight);
      }
    }
  }
  for (auto& list : weights.of_vertex) {
    std::sort(list.begin(), list.end());
    std::vector<std::pair<int, float>> merged;
    float total = 0;
    for (const auto& [part, weight] : list) {
      if (merged.empty() || merged.back().first != part) merged.emplace_back(part, 0.0f);
      merged.back().second += weight;
      total += weight;
    }
    for (auto& [part, weight] : merged) weight = total > 0 ? weight / total : 0;
    if (total > 0) {
      list = merged;
    } else {
      list = {{kHead, 1.0f}};  // hair's and eyes' helpers
    }
  }
  return weights;
}

}  // namespace dualpixel::scenes
