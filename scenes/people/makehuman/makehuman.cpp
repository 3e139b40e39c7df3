#include "scenes/people/makehuman/makehuman.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"

namespace dualpixel::scenes {
namespace {

namespace fs = std::filesystem;

constexpr float kMetresPerUnit = 0.1f;
constexpr int kMostVertices = 1 << 20;

// ---- reading -------------------------------------------------------------------------------------------------------

/// The words of a text file, line by line.
class Lines {
 public:
  explicit Lines(const std::string& path) : path_(path), bytes_(read_file(path, std::size_t{64} << 20)) {}

  /// The next line that has words and is no comment; false at the end.
  bool next(std::vector<std::string_view>& words) {
    while (at_ < bytes_.size()) {
      const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
      const std::string_view line(bytes_.data() + at_, end - at_);
      at_ = end + 1;
      ++number_;
      words.clear();
      for (std::size_t i = 0; i < line.size();) {
        while (i < line.size() && std::isspace(static_cast<unsigned char>(line[i])) != 0) ++i;
        const std::size_t first = i;
        while (i < line.size() && std::isspace(static_cast<unsigned char>(line[i])) == 0) ++i;
        if (i > first) words.push_back(line.substr(first, i - first));
      }
      if (!words.empty() && words[0][0] != '#') return true;
    }
    return false;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", printable(path_), number_, what));
  }
  float number(std::string_view word) const {
    float value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value) || std::abs(value) > 1e6f) {
      fail(fmt::format("'{}' is no number", printable(std::string(word), 40)));
    }
    return value;
  }
  int index(std::string_view word, int count) const {
    int value = -1;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < 0 || value >= count) {
      fail(fmt::format("'{}' is no index from 0 to {}", printable(std::string(word), 40), count - 1));
    }
    return value;
  }
  bool is_number(std::string_view word) const {
    return !word.empty() && (std::isdigit(static_cast<unsigned char>(word[0])) != 0 || word[0] == '-');
  }

 private:
  std::string path_, bytes_;
  std::size_t at_ = 0;
  int number_ = 0;
};

struct Obj {
  std::vector<vec3> positions;
  TexturedMesh faces;  ///< of the group `kept`, or of all
  std::map<std::string, std::vector<int>> group_vertices;
};

Obj read_obj(const std::string& path, const std::string& kept) {
  Lines lines(path);
  Obj obj;
  std::vector<vec2> uvs = {};
  std::map<std::pair<int, int>, unsigned> corner_of;
  std::string group;
  std::vector<std::string_view> words;
  while (lines.next(words)) {
    if (words[0] == "v") {
      if (words.size() < 4) lines.fail("a vertex has three numbers");
      if (obj.positions.size() >= kMostVertices) lines.fail("too many vertices");
      obj.positions.emplace_back(lines.number(words[1]), lines.number(words[2]), lines.number(words[3]));
    } else if (words[0] == "vt") {
      if (words.size() < 3) lines.fail("a texture coordinate has two numbers");
      uvs.emplace_back(lines.number(words[1]), 1 - lines.number(words[2]));
    } else if (words[0] == "g" && words.size() > 1) {
      group = words[1];
    } else if (words[0] == "f") {
      if (words.size() < 4 || words.size() > 64) lines.fail("a face has three corners or more");
      std::vector<unsigned> corners;
      for (std::size_t i = 1; i < words.size(); ++i) {
        const std::size_t slash = words[i].find('/');
        const int v = lines.index(words[i].substr(0, slash), static_cast<int>(obj.positions.size()) + 1) - 1;
        int t = -1;
        if (slash != std::string_view::npos) {
          const std::string_view rest = words[i].substr(slash + 1);
          const std::string_view word = rest.substr(0, rest.find('/'));
          if (!word.empty()) t = lines.index(word, static_cast<int>(uvs.size()) + 1) - 1;
        }
        if (v < 0) lines.fail("vertices are counted from 1");
        obj.group_vertices[group].push_back(v);
        if (!kept.empty() && group != kept) continue;
        const auto [it, is_new] = corner_of.try_emplace({v, t}, static_cast<unsigned>(obj.faces.vertex.size()));
        if (is_new) {
          obj.faces.vertex.push_back(v);
          obj.faces.uv.push_back(t < 0 ? vec2(0) : uvs[static_cast<std::size_t>(t)]);
        }
        corners.push_back(it->second);
      }
      for (std::size_t i = 2; i < corners.size(); ++i)
        obj.faces.triangles.emplace_back(corners[0], corners[i - 1], corners[i]);
    }
  }
  obj.faces.vertices = static_cast<int>(obj.positions.size());
  return obj;
}

std::shared_ptr<const simulator::Texture> read_texture(const std::string& path, vec3& mean) {
  constexpr int kMostSide = 4096;
  const PictureSize size = picture_size(path);
  if (size.width > kMostSide || size.height > kMostSide) {
    throw InputError(fmt::format("{}: {} x {} pixels; textures of up to {} a side are read", printable(path),
                                 size.width, size.height, kMostSide));
  }
  const Image image = read_image(path);
  auto texture = std::make_shared<simulator::Texture>();
  texture->width = image.width;
  texture->height = image.height;
  texture->srgb = true;
  texture->rgba.resize(image.pixel_count() * 4);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (int c = 0; c < 4; ++c) {
      const int from = c < 3 ? (image.channels < 3 ? 0 : c) : image.channels - 1;
      const bool opaque = c == 3 && image.channels != 4 && image.channels != 2;
      const float value = opaque ? 1 : image.data[i * image.channels + from];
      texture->rgba[4 * i + c] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255));
    }
  }
  simulator::keep_decoded(*texture);
  glm::vec4 sum(0);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const glm::vec4 texel = simulator::decode_texel(*texture, i);
    sum += texel.w > 0.5f ? glm::vec4(vec3(texel), 1) : glm::vec4(0);
  }
  mean = sum.w > 0 ? vec3(sum) / sum.w : vec3(0.5f);
  return texture;
}

/// The texture that a .mhmat names, where it is there.
std::shared_ptr<const simulator::Texture> material_texture(const std::string& path, vec3& mean) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return nullptr;
  Lines lines(path);
  std::vector<std::string_view> words;
  while (lines.next(words)) {
    if (words[0] != "diffuseTexture" || words.size() < 2) continue;
    const std::string name(words[1]);
    if (name.find("..") != std::string::npos || name.front() == '/')
      lines.fail("a texture must lie beside its material");
    const fs::path texture = fs::path(path).parent_path() / name;
    return fs::is_regular_file(texture, ignored) ? read_texture(texture.string(), mean) : nullptr;
  }
  return nullptr;
}

FittedAsset read_fitted(const std::string& path, int base_vertices) {
  Lines lines(path);
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
      FittedAsset::Hold hold;
      if (words.size() != 1 && words.size() != 9) lines.fail("a row is a vertex, or three with weights and an offset");
      if (words.size() == 9) {
        for (int i = 0; i < 3; ++i) {
          hold.vertex[i] = lines.index(words[i], base_vertices);
          hold.weight[i] = lines.number(words[3 + i]);
          hold.offset[i] = lines.number(words[6 + i]) * kMetresPerUnit;
        }
      } else {
        hold.vertex.fill(lines.index(words[0], base_vertices));
      }
      if (asset.holds.size() >= kMostVertices) lines.fail("too many vertices");
      asset.holds.push_back(hold);
    } else if (section == Section::hidden) {
      for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] == "-") continue;
        const int from = lines.index(words[i], base_vertices);
        int to = from;
        if (i + 2 < words.size() && words[i + 1] == "-") to = lines.index(words[i + 2], base_vertices), i += 2;
        for (int v = from; v <= to; ++v) asset.hides[static_cast<std::size_t>(v)] = true;
      }
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

// ---- the parts of the body that move as one ------------------------------------------------------------------------

enum Part : std::uint8_t { kPelvis, kChest, kNeck, kHead, kFirstOfSide };
enum SidePart : std::uint8_t { kUpperArm, kForeArm, kTwist, kHand, kThigh, kShin, kFoot, kFirstFinger };
constexpr int kFingers = 4, kPhalanges = 3;
constexpr int kSideParts = kFirstFinger + kFingers * kPhalanges;
constexpr int kParts = kFirstOfSide + 2 * kSideParts;

int part_of(int side, int part) { return kFirstOfSide + side * kSideParts + part; }

/// Which parts a bone of the default rig belongs to, and how much.
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

struct PartMotion {
  mat3 axes{1};
  vec3 from{0}, to{0};
  vec3 moved(vec3 p) const { return to + axes * (p - from); }
};

mat3 between(vec3 a, vec3 b) {
  const vec3 axis = glm::cross(a, b);
  const float sine = glm::length(axis);
  if (sine < 1e-5f) return mat3(1);
  return mat3(glm::rotate(glm::mat4(1), std::atan2(sine, glm::dot(a, b)), axis / sine));
}

/// A morphed body: places at rest in meters, the floor at 0, and its joints.
struct Morphed {
  std::vector<vec3> rest;
  const MakeHumanAssets* assets;

  vec3 joint(const std::string& name) const {
    const std::vector<int>& about = assets->joints.at("joint-" + name);  // the constructor saw to it
    vec3 sum(0);
    for (const int v : about) sum += rest[static_cast<std::size_t>(v)];
    return sum / static_cast<float>(about.size());
  }
  vec3 joint(int side, const std::string& name) const { return joint((side == 0 ? "l-" : "r-") + name); }
};

/// Hair and hats are meshed on cells of the head's size, so a body of no human size could want any amount of memory.
constexpr float kLeastEyes_m = 0.03f, kMostEyes_m = 0.09f;

void require_human_sizes(const Morphed& body, const std::string& whose) {
  const float eyes_m = glm::distance(body.joint("l-eye"), body.joint("r-eye"));
  if (!(eyes_m >= kLeastEyes_m && eyes_m <= kMostEyes_m)) {
    throw InputError(fmt::format("{}: the eyes are {:.3f} m apart; {} to {} m is allowed", whose, eyes_m, kLeastEyes_m,
                                 kMostEyes_m));
  }
  for (const int v : body.assets->body.vertex) {
    const vec3 p = body.rest[static_cast<std::size_t>(v)];
    const float aside_m = std::max(std::abs(p.x), std::abs(p.z));
    if (!(aside_m <= 1.5f)) {
      throw InputError(fmt::format("{}: the body reaches {:.2f} m aside; up to 1.5 m is allowed", whose, aside_m));
    }
  }
}

std::vector<std::string> joint_names() {
  std::vector<std::string> names = {"neck", "jaw"};
  for (const char* side : {"l-", "r-"}) {
    for (const char* joint : {"eye", "shoulder", "elbow", "hand", "upper-leg", "knee", "ankle"})
      names.push_back(std::string(side) + joint);
    for (int finger = 0; finger < kFingers; ++finger) {
      for (int bone = 0; bone < kPhalanges; ++bone)
        names.push_back(fmt::format("{}finger-{}-{}", side, finger + 2, bone + 1));
    }
  }
  return names;
}

/// Directions are taken along limbs and across hands, and elbows and knees must bend: joints lie in or about the body,
/// and the two bones of a limb are alike.
void require_limbs(const Morphed& body, const std::string& whose) {
  vec3 low(1e9f), high(-1e9f);
  for (const int v : body.assets->body.vertex) {
    low = glm::min(low, body.rest[static_cast<std::size_t>(v)]);
    high = glm::max(high, body.rest[static_cast<std::size_t>(v)]);
  }
  constexpr float kAbout_m = 0.1f;
  for (const std::string& name : joint_names()) {
    const vec3 at = body.joint(name);
    if (at == glm::clamp(at, low - kAbout_m, high + kAbout_m)) continue;
    throw InputError(
        fmt::format("{}: joint-{} is at {:.2f}, {:.2f}, {:.2f} m; at most {} m outside the body is allowed", whose,
                    name, at.x, at.y, at.z, kAbout_m));
  }

  constexpr float kShortest_m = 0.01f, kMostUnlike = 2;
  const auto require = [&](float length_m, const std::string& what) {
    if (length_m >= kShortest_m) return;
    throw InputError(fmt::format("{}: {} is {:.4f} m; {} m or more is allowed", whose, what, length_m, kShortest_m));
  };
  constexpr const char* kLimbs[][3] = {{"shoulder", "elbow", "hand"}, {"upper-leg", "knee", "ankle"}};
  for (const std::string side : {"l-", "r-"}) {
    const auto length_m = [&](const char* from, const char* to) {
      return glm::distance(body.joint(side + from), body.joint(side + to));
    };
    for (const auto& [from, middle, to] : kLimbs) {
      const float first_m = length_m(from, middle), second_m = length_m(middle, to);
      require(first_m, fmt::format("from {0}{1} to {0}{2}", side, from, middle));
      require(second_m, fmt::format("from {0}{1} to {0}{2}", side, middle, to));
      if (std::max(first_m, second_m) <= kMostUnlike * std::min(first_m, second_m)) continue;
      throw InputError(
          fmt::format("{0}: from {1}{2} to {1}{3} is {4:.3f} m, to {1}{5} {6:.3f} m; one may be {7} times "
                      "the other at most",
                      whose, side, from, middle, first_m, to, second_m, kMostUnlike));
    }
    require(length_m("hand", "finger-3-1"), fmt::format("from {0}hand to {0}finger-3-1", side));
    const vec3 along = glm::normalize(body.joint(side + "finger-3-1") - body.joint(side + "hand"));
    const vec3 across = body.joint(side + "finger-2-1") - body.joint(side + "finger-5-1");
    require(glm::length(across - along * glm::dot(across, along)), fmt::format("across {}hand it", side));
  }
}

void require_a_body(const MakeHumanAssets& assets, const std::string& path) {
  for (const std::string& name : joint_names()) {
    if (assets.joints.count("joint-" + name) == 0)
      throw InputError(fmt::format("{}: no group 'joint-{}'", printable(path), name));
  }
  float low = 1e9f, high = -1e9f;
  for (const int v : assets.body.vertex) {
    low = std::min(low, assets.base[static_cast<std::size_t>(v)].y);
    high = std::max(high, assets.base[static_cast<std::size_t>(v)].y);
  }
  if (high - low < 1 || high - low > 2.5f) {
    throw InputError(fmt::format("{}: the body is {:.2f} m high; 1 to 2.5 m is allowed (a unit is 10 cm)",
                                 printable(path), high - low));
  }
  const Morphed body{assets.base, &assets};
  require_human_sizes(body, printable(path));
  require_limbs(body, printable(path));
}

struct RestFrames {
  vec3 pelvis, chest, neck, head;
};

RestFrames rest_frames(const Morphed& morphed, float stature) {
  RestFrames f;
  f.pelvis = 0.5f * (morphed.joint("l-upper-leg") + morphed.joint("r-upper-leg")) + vec3(0, 0.01f * stature, 0);
  f.chest = f.pelvis + vec3(0, 0.065f * stature, 0);
  f.neck = morphed.joint("neck");
  const vec3 eyes = 0.5f * (morphed.joint("l-eye") + morphed.joint("r-eye"));
  const float s = glm::distance(morphed.joint("l-eye"), morphed.joint("r-eye")) / 0.062f;
  f.head = eyes - s * vec3(0, 0.0148f, 0.0715f);
  return f;
}

std::vector<PartMotion> motions_of(const Morphed& morphed, const RestFrames& rest, const Skeleton& k,
                                   const Pose& pose) {
  std::vector<PartMotion> motion(kParts);
  motion[kPelvis] = {k.pelvis.axes, rest.pelvis, k.pelvis.origin};
  motion[kChest] = {k.chest.axes, rest.chest, k.chest.origin};
  motion[kNeck] = {k.bones[Skeleton::kNeckBone].axes, rest.neck, k.neck_base};
  motion[kHead] = {k.head.axes, rest.head, k.head.origin};
  for (int side = 0; side < 2; ++side) {
    const vec3 shoulder = morphed.joint(side, "shoulder"), elbow = morphed.joint(side, "elbow"),
               wrist = morphed.joint(side, "hand");
    const vec3 hip = morphed.joint(side, "upper-leg"), knee = morphed.joint(side, "knee"),
               ankle = morphed.joint(side, "ankle");
    const auto limb = [](const mat3& from, vec3 rest_along, vec3 posed_along) {
      return from * between(glm::normalize(rest_along), glm::normalize(posed_along) * from);
    };
    const auto set = [&](int part, const mat3& axes, vec3 from, vec3 to) {
      motion[part_of(side, part)] = {axes, from, to};
    };
    const mat3 upper = limb(k.chest.axes, elbow - shoulder, k.elbow[side] - k.shoulder[side]);
    const mat3 fore = limb(upper, wrist - elbow, k.wrist[side] - k.elbow[side]);
    // the hand's own frame at rest: fingers along y, palm towards z, x towards the thumb of a right hand and away from
    // a left one's
    const vec3 along = glm::normalize(morphed.joint(side, "finger-3-1") - wrist);
    vec3 across = morphed.joint(side, "finger-2-1") - morphed.joint(side, "finger-5-1");
    across = glm::normalize(across - along * glm::dot(across, along)) * (side == 0 ? -1.0f : 1.0f);
    const mat3 rest_hand(across, along, glm::cross(across, along));
    const mat3 hand = k.hand[side].axes * glm::transpose(rest_hand);
    // how far the hand turns about the forearm: half way down, the forearm has turned by a good half of that
    const vec3 axis = glm::normalize(k.wrist[side] - k.elbow[side]);
    const auto flat = [&](vec3 v) { return v - axis * glm::dot(v, axis); };
    const vec3 before = flat(fore * across), after = flat(hand * across);
    const float twist = std::atan2(glm::dot(glm::cross(before, after), axis), glm::dot(before, after));
    set(kUpperArm, upper, shoulder, k.shoulder[side]);
    set(kForeArm, mat3(glm::rotate(glm::mat4(1), 0.15f * twist, axis)) * fore, elbow, k.elbow[side]);
    set(kTwist, mat3(glm::rotate(glm::mat4(1), 0.6f * twist, axis)) * fore, elbow, k.elbow[side]);
    set(kHand, hand, wrist, k.wrist[side]);
    const mat3 thigh = limb(k.pelvis.axes, knee - hip, k.knee[side] - k.hip[side]);
    set(kThigh, thigh, hip, k.hip[side]);
    set(kShin, limb(thigh, ankle - knee, k.ankle[side] - k.knee[side]), knee, k.knee[side]);
    set(kFoot, k.pelvis.axes, ankle, k.ankle[side]);
    // fingers bend towards the palm about the hand's x; they are a little bent at rest
    const float bend = 1.1f * (pose.arm[side].curl - 0.25f);
    for (int finger = 0; finger < kFingers; ++finger) {
      PartMotion parent = motion[part_of(side, kHand)];
      for (int bone = 0; bone < kPhalanges; ++bone) {
        const vec3 joint = morphed.joint(side, fmt::format("finger-{}-{}", finger + 2, bone + 1));
        const mat3 turned = mat3(glm::rotate(glm::mat4(1), bend, k.hand[side].axes[0])) * parent.axes;
        const PartMotion own{turned, joint, parent.moved(joint)};
        motion[part_of(side, kFirstFinger + finger * kPhalanges + bone)] = own;
        parent = own;
      }
    }
  }
  return motion;
}

using Weights = std::vector<std::pair<int, float>>;

vec3 moved(const std::vector<PartMotion>& motion, const Weights& weights, vec3 p) {
  vec3 sum(0);
  for (const auto& [part, weight] : weights) sum += weight * motion[static_cast<std::size_t>(part)].moved(p);
  return sum;
}

/// A mesh with posed vertices as a piece; normals are smooth across texture seams. `visible`: which vertices stay.
SceneObject object_of(const TexturedMesh& mesh, const std::vector<vec3>& posed, const std::vector<vec3>& rest,
                      bool textured, const std::vector<bool>& hidden, float lowest_m) {
  SceneObject whole;
  whole.positions = posed;
  for (const glm::uvec3& t : mesh.triangles)
    whole.triangles.emplace_back(mesh.vertex[t.x], mesh.vertex[t.y], mesh.vertex[t.z]);
  smooth_normals(whole);
  SceneObject object;
  for (std::size_t i = 0; i < mesh.vertex.size(); ++i) {
    const auto v = static_cast<std::size_t>(mesh.vertex[i]);
    object.positions.push_back(posed[v]);
    object.normals.push_back(whole.normals[v]);
    object.rest.push_back(textured ? vec3(mesh.uv[i], 0) : rest[v]);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = whole.triangles[i];
    if (!hidden.empty() && (hidden[t.x] || hidden[t.y] || hidden[t.z])) continue;
    if (std::max({posed[t.x].y, posed[t.y].y, posed[t.z].y}) < lowest_m) continue;
    object.triangles.push_back(mesh.triangles[i]);
  }
  return object;
}

/// One of a kind of asset, of the group that is wanted where this set has any of it (see makehuman.h); null where there
/// is none of the kind.
template <typename T, typename GroupOf>
const T* one_of(RandomStream& rng, const std::vector<T>& kind, GroupOf group_of, int wanted) {
  std::map<int, int> sizes, before;
  for (const T& asset : kind) ++sizes[group_of(asset)];
  std::vector<const T*> any, own, fitting;
  for (const T& asset : kind) {
    const int group = group_of(asset), n = sizes[group];
    const bool held_out = n > 1 && before[group]++ >= n - std::max(n / 5, 1);
    any.push_back(&asset);
    if (held_out != rng.held_out()) continue;
    own.push_back(&asset);
    if (group == wanted) fitting.push_back(&asset);
  }
  const std::vector<const T*>& from = !fitting.empty() ? fitting : !own.empty() ? own : any;
  return from.empty() ? nullptr : from[static_cast<std::size_t>(rng.below(static_cast<int>(from.size())))];
}
template <typename T>
const T* one_of(RandomStream& rng, const std::vector<T>& kind) {
  return one_of(
      rng, kind, [](const T&) { return 0; }, 0);
}

bool is_for_women(const std::string& name) { return name.find("female") != std::string::npos; }

/// A figure under way.
struct Dressing {
  SceneModel& scene;
  Figure& figure;
  const Morphed& morphed;
  const std::vector<PartMotion>& motion;
  std::vector<vec3> posed;   ///< of the base mesh
  std::vector<bool> hidden;  ///< of its vertices: beneath clothes
};

void add_fitted(Dressing& dressing, const FittedAsset& asset, const Material& material, float grow_m = 0) {
  const auto& rest = dressing.morphed.rest;
  vec3 scale(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto& s = asset.scale[axis];
    if (s.length > 0) scale[axis] = std::abs(rest[s.a][axis] - rest[s.b][axis]) / (s.length * kMetresPerUnit);
  }
  const PartWeights& weights = dressing.morphed.assets->weights;
  std::vector<vec3> posed, at_rest;
  for (int i = 0; i < asset.mesh.vertices; ++i) {
    const FittedAsset::Hold& hold = asset.holds[static_cast<std::size_t>(i)];
    vec3 p(0), q(0);
    for (int j = 0; j < 3; ++j) p += hold.weight[j] * rest[static_cast<std::size_t>(hold.vertex[j])];
    p += hold.offset * scale;
    for (int j = 0; j < 3; ++j) {
      if (hold.weight[j] != 0)
        q += hold.weight[j] * moved(dressing.motion, weights.of_vertex[static_cast<std::size_t>(hold.vertex[j])], p);
    }
    at_rest.push_back(p - vec3(0, 0.72f * dressing.figure.body.stature_m, 0));
    posed.push_back(q);
  }
  SceneObject object = object_of(asset.mesh, posed, at_rest, material.kind == Material::Kind::textured, {},
                                 dressing.figure.lowest_m - 0.05f);
  if (grow_m > 0) {
    for (std::size_t i = 0; i < object.positions.size(); ++i) object.positions[i] += grow_m * object.normals[i];
  }
  add_object(dressing.scene, dressing.figure, std::move(object), material);
}

/// The asset's texture, dyed: its mean becomes `color`; plain where it has none.
Material dyed(const FittedAsset& asset, vec3 color, bool cut_out) {
  Material material;
  material.a = color;
  if (!asset.texture) return material;
  material.kind = Material::Kind::textured;
  material.texture = asset.texture;
  material.a = color / glm::max(asset.mean_color, vec3(0.02f));
  material.cut_out = cut_out;
  return material;
}

/// Cloth that follows the body at a little distance, over what `covers(rest place, weights)` says.
template <typename Covers>
void add_shell(Dressing& dressing, const Covers& covers, float room_m, float folds_m, const Material& material,
               RandomStream& rng) {
  const MakeHumanAssets& assets = *dressing.morphed.assets;
  const auto& rest = dressing.morphed.rest;
  const float chest_m = 0.72f * dressing.figure.body.stature_m;
  std::vector<bool> bare(dressing.posed.size());
  std::vector<vec3> at_rest(dressing.posed.size());
  for (std::size_t v = 0; v < bare.size(); ++v) {
    bare[v] = v >= assets.weights.of_vertex.size() || !covers(rest[v], assets.weights.of_vertex[v]);
    at_rest[v] = rest[v] - vec3(0, chest_m, 0);
  }
  SceneObject object = object_of(assets.body, dressing.posed, at_rest, false, bare, dressing.figure.lowest_m - 0.05f);
  const auto seed = rng.seed();
  for (std::size_t i = 0; i < object.positions.size(); ++i) {
    const vec3 bent = object.rest[i] + 0.06f * noise(seed + 1, object.rest[i] * 9.0f);
    const float fold =
        fractal(seed, bent * vec3(15, 9, 13), 2) + std::abs(noise(seed + 2, bent * vec3(11, 17, 11)) - 0.5f);
    object.positions[i] += object.normals[i] * (room_m + folds_m * fold);
  }
  smooth_normals(object);
  add_object(dressing.scene, dressing.figure, std::move(object), material);
}

float weight_of(const Weights& weights, std::initializer_list<int> parts) {
  float sum = 0;
  for (const auto& [part, weight] : weights) {
    if (std::find(parts.begin(), parts.end(), part) != parts.end()) sum += weight;
  }
  return sum;
}

void add_shell_clothes(Dressing& dressing, RandomStream& rng) {
  const Morphed& m = dressing.morphed;
  const float h = dressing.figure.body.stature_m;
  const std::array<vec3, 2> shoulder{m.joint(0, "shoulder"), m.joint(1, "shoulder")},
      wrist{m.joint(0, "hand"), m.joint(1, "hand")};
  const vec3 neck = m.joint("neck");
  const float hip = m.joint(0, "upper-leg").y;
  const float sleeve = rng.chance(0.4f) ? rng.uniform(0.25f, 0.5f) : rng.chance(0.8f) ? 0.97f : 0.05f;
  const float hem = hip - rng.uniform(-0.02f, 0.1f) * h, neckline = rng.uniform(-0.01f, 0.05f) * h,
              vee = rng.chance(0.35f) ? rng.uniform(0.5f, 2) : 0;
  const float leg = rng.chance(0.25f) ? rng.uniform(0.25f, 0.5f) : 0.97f, knee_to_hip = hip * leg;
  const Material lower = cloth_material(rng);
  add_shell(
      dressing,
      [&](vec3 p, const Weights& w) {
        const float legs =
            weight_of(w, {part_of(0, kThigh), part_of(1, kThigh), part_of(0, kShin), part_of(1, kShin), kPelvis});
        return legs > 0.5f && p.y > hip - knee_to_hip && p.y < std::min(hip + 0.09f * h, hem + 0.03f * h);
      },
      rng.uniform(0.006f, 0.014f), rng.uniform(0.004f, 0.015f), lower, rng);
  Material upper = cloth_material(rng);
  if (rng.chance(0.4f)) upper.v[kPlacket] = rng.uniform(0.2f, 1);
  const auto covers_top = [&](vec3 p, const Weights& w) {
    for (int side = 0; side < 2; ++side) {
      const float arm = weight_of(w, {part_of(side, kUpperArm), part_of(side, kForeArm), part_of(side, kTwist)});
      if (arm < 0.5f) continue;
      const vec3 along = wrist[side] - shoulder[side];
      return glm::dot(p - shoulder[side], along) / glm::dot(along, along) < sleeve;
    }
    const float arms = weight_of(w, {part_of(0, kUpperArm), part_of(1, kUpperArm)});
    if (weight_of(w, {kPelvis, kChest, kNeck, part_of(0, kThigh), part_of(1, kThigh)}) + arms < 0.6f) return false;
    const float opening =
        neck.y - neckline -
        (p.z > neck.z ? 0.3f * (p.z - neck.z) + 0.2f * h * std::max(vee * 0.06f - std::abs(p.x) / h, 0.0f) * 4 : 0.0f);
    return p.y > hem && (p.y < opening || std::abs(p.x) > 0.055f * h) && weight_of(w, {kNeck}) < 0.6f;
  };
  add_shell(dressing, covers_top, rng.uniform(0.009f, 0.022f), rng.uniform(0.006f, 0.024f), upper, rng);
  if (rng.chance(0.25f)) {  // a second layer, open in front
    const float open = rng.uniform(0.03f, 0.08f) * h;
    add_shell(
        dressing, [&](vec3 p, const Weights& w) { return covers_top(p, w) && !(p.z > neck.z && std::abs(p.x) < open); },
        0.03f, rng.uniform(0.006f, 0.02f), cloth_material(rng), rng);
  }
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
  Obj obj = read_obj(base_path, "body");
  if (obj.positions.empty() || obj.faces.triangles.empty())
    throw InputError(fmt::format("{}: no group 'body'", printable(base_path)));
  base = std::move(obj.positions);
  for (vec3& p : base) p *= kMetresPerUnit;
  body = std::move(obj.faces);
  for (auto& [group, vertices] : obj.group_vertices) {
    if (group.rfind("joint-", 0) != 0) continue;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    joints[group] = vertices;
  }
  require_a_body(*this, base_path);
  const int count = static_cast<int>(base.size());
  weights = read_weights(in_folder("rigs/default_weights.mhw"), count);
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
    Lines lines((fs::path(folder) / "targets" / (name + ".target")).string());
    std::vector<std::string_view> words;
    while (lines.next(words)) {
      if (words.size() < 4) lines.fail("a target's row is a vertex and three numbers");
      read->vertex.push_back(lines.index(words[0], static_cast<int>(base.size())));
      read->offset.push_back(kMetresPerUnit *
                             vec3(lines.number(words[1]), lines.number(words[2]), lines.number(words[3])));
    }
    slot = std::move(read);
  }
  return *slot;
}

Figure add_makehuman_figure(SceneModel& scene, const MakeHumanAssets& assets, RandomStream rng,
                            const FigureOptions& options) {
  Figure figure;
  figure.tags.emplace_back("makehuman");
  RandomStream body_rng = rng.substream(1), pose_rng = rng.substream(2), material_rng = rng.substream(3);
  figure.body = make_body(body_rng);
  figure.pose = make_pose(pose_rng, figure.body, options.gesture);
  figure.pose.head_yaw = std::clamp(figure.pose.head_yaw + options.head_yaw, -1.25f, 1.25f);
  figure.person = options.person;
  figure.head_cell_m = std::clamp(1.1f * options.meters_per_px, 0.0038f, 0.014f);
  figure.body_cell_m = std::clamp(2.4f * options.meters_per_px, 0.009f, 0.024f);

  // shape: mixtures of the macro targets, then details of the face
  const bool man = figure.body.woman < 0.5f;
  const std::string gender = man ? "male" : "female";
  Morphed morphed{assets.base, &assets};
  const auto apply = [&](const std::string& name, float weight) {
    if (std::abs(weight) < 1e-3f) return;
    const MorphTarget& target = assets.target(name);
    for (std::size_t i = 0; i < target.vertex.size(); ++i)
      morphed.rest[static_cast<std::size_t>(target.vertex[i])] += weight * target.offset[i];
  };
  constexpr const char* kOrigins[] = {"african", "asian", "caucasian"};
  const auto sex_and_age = [](bool woman, bool old) { return (woman ? 1 : 0) + (old ? 2 : 0); };
  const MakeHumanAssets::Skin* skin = one_of(
      material_rng, assets.skins,
      [&](const MakeHumanAssets::Skin& one) {
        return sex_and_age(is_for_women(one.name), one.name.starts_with("old"));
      },
      sex_and_age(!man, figure.body.old));
  int origin = body_rng.below(3);
  for (int i = 0; i < 3; ++i) {
    if (skin && skin->name.find(kOrigins[i]) != std::string::npos) origin = i;
  }
  const int second = body_rng.below(3);
  const float mixed = body_rng.uniform(0, 0.4f);
  const float older = figure.body.old ? body_rng.uniform(0.4f, 0.9f) : body_rng.uniform(0, 0.25f);
  const float younger = figure.body.child ? body_rng.uniform(0.4f, 1) : 0;
  const float muscle = body_rng.uniform(-0.6f, 0.8f), heavy = std::clamp(figure.body.girth, -1.0f, 1.0f);
  const std::pair<const char*, float> ages[] = {
      {"young", (1 - older) * (1 - younger)}, {"old", older * (1 - younger)}, {"child", younger}};
  const std::pair<const char*, float> muscles[] = {{"averagemuscle", 1 - std::abs(muscle)},
                                                   {muscle > 0 ? "maxmuscle" : "minmuscle", std::abs(muscle)}};
  const std::pair<const char*, float> fats[] = {{"averageweight", 1 - std::abs(heavy)},
                                                {heavy > 0 ? "maxweight" : "minweight", std::abs(heavy)}};
  for (const auto& [age, a] : ages) {
    apply(fmt::format("macrodetails/{}-{}-{}", kOrigins[origin], gender, age), a * (1 - mixed));
    apply(fmt::format("macrodetails/{}-{}-{}", kOrigins[second], gender, age), a * mixed);
    for (const auto& [m, b] : muscles) {
      for (const auto& [f, c] : fats)
        apply(fmt::format("macrodetails/universal-{}-{}-{}-{}", gender, age, m, f), a * b * c);
    }
  }
  for (const std::string& detail : assets.details) {
    const float amount = 0.28f * body_rng.normal();
    apply(detail + (amount > 0 ? "-incr" : "-decr"), std::abs(amount));
  }
  if (body_rng.chance(0.45f))
    apply(fmt::format("expression/units/{}/mouth-corner-puller", kOrigins[origin]), body_rng.uniform(0.2f, 0.9f));

  const std::string whose = printable(assets.folder) + "/targets: of a morphed body";
  require_human_sizes(morphed, whose);

  // stand it on the floor, and scale it to its stature: the targets know no centimetres
  float low = 1e9f, high = -1e9f;
  for (const int v : assets.body.vertex) {
    low = std::min(low, morphed.rest[static_cast<std::size_t>(v)].y);
    high = std::max(high, morphed.rest[static_cast<std::size_t>(v)].y);
  }
  if (!(high - low >= 0.4f && high - low <= 3)) {
    throw InputError(fmt::format("{}: the height is {:.2f} m; 0.4 to 3 m is allowed", whose, high - low));
  }
  require_limbs(morphed, whose);
  const float grow = figure.body.child ? 1 : std::clamp(figure.body.stature_m / (high - low), 0.93f, 1.07f);
  for (vec3& p : morphed.rest) p = grow * (p - vec3(0, low, 0));
  const float h = grow * (high - low);
  figure.body.stature_m = h;
  const RestFrames rest = rest_frames(morphed, h);
  const vec3 left_eye = morphed.joint("l-eye"), right_eye = morphed.joint("r-eye");
  const float s = glm::distance(left_eye, right_eye) / 0.062f;
  figure.body.head_scale = s;
  Proportions proportions;
  proportions.pelvis_m = rest.pelvis.y;
  proportions.sitting_pelvis_m = 0.28f * h;
  proportions.chest = rest.chest - rest.pelvis;
  proportions.neck_base = rest.neck - rest.chest;
  proportions.neck = rest.head - rest.neck;
  proportions.shoulder = morphed.joint(0, "shoulder") - rest.chest;
  proportions.hip = morphed.joint(0, "upper-leg") - rest.pelvis;
  proportions.upper_arm_m = glm::distance(morphed.joint(0, "shoulder"), morphed.joint(0, "elbow"));
  proportions.fore_arm_m = glm::distance(morphed.joint(0, "elbow"), morphed.joint(0, "hand"));
  proportions.thigh_m = glm::distance(morphed.joint(0, "upper-leg"), morphed.joint(0, "knee"));
  proportions.shank_m = glm::distance(morphed.joint(0, "knee"), morphed.joint(0, "ankle"));
  figure.body.shoulder_half_m = proportions.shoulder.x;
  figure.body.hip_half_m = proportions.hip.x;
  figure.skeleton = make_skeleton(figure.body, figure.pose, options.place, options.yaw, proportions);
  figure.lowest_m = options.lowest_m;
  figure.top_cloth_m = figure.legs_cloth_m = 0.04f;  // of the shells below; suits are about as wide
  figure.bare.cones = torso_cones(figure, 0);
  const std::vector<PartMotion> motion = motions_of(morphed, rest, figure.skeleton, figure.pose);

  // face: the eyes are joints, nose and ears the outermost places of the head
  vec3 nose(0, 0, -1);
  std::array<vec3, 2> ear{left_eye, right_eye};
  for (const int v : assets.body.vertex) {
    const vec3 p = morphed.rest[static_cast<std::size_t>(v)], q = (p - rest.head) / s;
    if (std::abs(q.x) < 0.01f && q.y > -0.05f && q.y < 0.005f && p.z > nose.z) nose = p;
    if (q.y > -0.03f && q.y < 0.03f && q.z < 0.03f && q.z > -0.05f) {
      if (p.x > ear[0].x) ear[0] = p;
      if (p.x < ear[1].x) ear[1] = p;
    }
  }
  const auto on_head = [&](vec3 p) { return motion[kHead].moved(p); };
  const vec3 cornea(0, 0, 0.012f * s);
  figure.face_points = {on_head(nose), on_head(left_eye + cornea), on_head(right_eye + cornea), on_head(ear[0]),
                        on_head(ear[1])};
  const vec3 chin = morphed.joint("jaw");
  for (const vec3& p : {rest.head + s * vec3(0, 0.045f, 0.088f), chin, rest.head + s * vec3(0.062f, 0, 0.05f),
                        rest.head + s * vec3(-0.062f, 0, 0.05f)}) {
    figure.face_outline.push_back(on_head(p));
  }

  Dressing dressing{scene, figure, morphed, motion, {}, std::vector<bool>(morphed.rest.size(), false)};
  for (std::size_t v = 0; v < morphed.rest.size(); ++v)
    dressing.posed.push_back(moved(motion, assets.weights.of_vertex[v], morphed.rest[v]));

  // looks
  Material& hair_material = figure.hair;
  hair_material.kind = Material::Kind::hair;
  hair_material.a = hair_color(material_rng, figure.body.old);
  if (origin != 2 && !figure.body.old && material_rng.chance(0.8f))
    hair_material.a = vec3(0.012f, 0.01f, 0.009f) * material_rng.uniform(0.5f, 2.5f);
  hair_material.b = hair_material.a * material_rng.uniform(1.0f, 2.2f);
  hair_material.seed = material_rng.seed();
  hair_material.gloss = material_rng.uniform(0.03f, 0.2f);
  hair_material.gloss_power = material_rng.uniform(5, 20);
  figure.skin.kind = Material::Kind::skin;
  figure.skin.a = skin_color(material_rng);
  figure.skin.softness = material_rng.uniform(0.15f, 0.45f);
  figure.skin.gloss = material_rng.uniform(0.05f, 0.25f);
  figure.skin.gloss_power = material_rng.uniform(8, 30);
  figure.face = figure.skin;
  if (skin) {
    figure.skin.kind = Material::Kind::textured;
    figure.skin.texture = skin->texture;
    figure.skin.a = vec3(material_rng.uniform(0.7f, 1.25f)) *
                    (1.0f + 0.06f * vec3(material_rng.normal(), material_rng.normal(), material_rng.normal()));
  }

  // clothes, and the body where they do not hide it
  RandomStream clothes_rng = rng.substream(5);
  if (!assets.clothes.empty() && clothes_rng.chance(0.5f)) {
    const FittedAsset& suit = *one_of(
        clothes_rng, assets.clothes, [](const FittedAsset& one) { return is_for_women(one.name) ? 1 : 0; },
        man ? 0 : 1);
    Material material = dyed(suit, random_color(clothes_rng), false);
    if (suit.texture && clothes_rng.chance(0.5f)) material.a = vec3(clothes_rng.uniform(0.6f, 1.3f));
    if (!suit.texture) material = cloth_material(clothes_rng);
    add_fitted(dressing, suit, material);
    dressing.hidden = suit.hides;
    figure.tags.push_back("top:" + suit.name);
  } else {
    add_shell_clothes(dressing, clothes_rng);
    figure.tags.emplace_back("top:shell");
  }
  if (!assets.shoes.empty() && figure.skeleton.ankle[0].y > figure.lowest_m) {
    const FittedAsset& shoes = *one_of(clothes_rng, assets.shoes);
    add_fitted(dressing, shoes, dyed(shoes, random_color(clothes_rng), false));
  }
  add_object(
      scene, figure,
      object_of(assets.body, dressing.posed, morphed.rest, skin != nullptr, dressing.hidden, figure.lowest_m - 0.05f),
      figure.skin);

  // eyes, brows, lashes
  RandomStream head_rng = rng.substream(6);
  if (const FittedAsset* eye = one_of(head_rng, assets.eyes)) {
    Material material;
    material.a = vec3(0.9f);
    material.gloss = 0.4f;
    material.gloss_power = 200;
    if (!assets.irises.empty()) {
      material.kind = Material::Kind::textured;
      material.texture = *one_of(head_rng, assets.irises);
    }
    add_fitted(dressing, *eye, material);
  }
  if (const FittedAsset* brow = one_of(head_rng, assets.brows))
    add_fitted(dressing, *brow, dyed(*brow, glm::min(hair_material.a, vec3(0.15f)), true));
  if (const FittedAsset* lash = one_of(head_rng, assets.lashes))
    add_fitted(dressing, *lash, dyed(*lash, vec3(0.02f), true));

  // hair: a fitted one, or ours, as large as the skull under it
  const FittedAsset* cut = one_of(head_rng, assets.hair);
  if (cut && head_rng.chance(0.55f) && (!man || cut->name.rfind("short", 0) == 0 || head_rng.chance(0.15f))) {
    Material material = dyed(*cut, hair_material.a, true);
    material.gloss = hair_material.gloss;
    material.gloss_power = hair_material.gloss_power;
    add_fitted(dressing, *cut, material);
    figure.tags.push_back("hair:" + cut->name);
    if (head_rng.chance(0.12f)) {
      if (const FittedAsset* hat = one_of(head_rng, assets.hats)) {
        add_fitted(dressing, *hat, cloth_material(head_rng), 0.004f);
        figure.tags.push_back("hat:" + hat->name);
      }
    }
  } else {
    vec3 reach(0);
    for (const int v : assets.body.vertex) {
      const vec3 q = morphed.rest[static_cast<std::size_t>(v)] - rest.head;
      if (q.y < 0.03f * s) continue;
      reach = glm::max(reach, vec3(std::abs(q.x) / 0.078f, q.y / 0.136f, -q.z / 0.109f));
    }
    // whatever a morph made of it
    figure.body.head_scale = std::clamp(std::max({reach.x, reach.y, reach.z}), 0.7f * s, 1.5f * s);
    add_hair_and_hat(scene, figure, rng.substream(7));
    figure.body.head_scale = s;
  }
  add_held_thing(scene, figure, rng.substream(8));
  if (figure.pose.sitting) add_seat(scene, figure, rng.substream(9));
  return figure;
}

}  // namespace dualpixel::scenes
