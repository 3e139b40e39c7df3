#include "scenes/people/data_set/read_people_set.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"

namespace dualpixel::scenes {
namespace {

constexpr std::size_t kSide = kPictureSide_px;

/// Of a tag such as "turn:30".
double turn_of(const std::string& tag, const Fields& fields) {
  const char* const first = tag.data() + std::string_view("turn:").size();
  double turn_deg = -1;
  const auto [end, error] = std::from_chars(first, tag.data() + tag.size(), turn_deg);
  if (error == std::errc() && end == tag.data() + tag.size() && turn_deg >= 0 && turn_deg <= 180) return turn_deg;
  fields.fail("tags", tag + ": must be turn: and degrees, 0 to 180");
}

}  // namespace

std::string changed_file(const std::string& shard) {
  std::string index = shard + "/" + kShardFile;
  const nlohmann::json json = read_json_file(index);
  if (!json.is_object() || !json.contains("files") || !json["files"].is_object()) return index;
  const nlohmann::json& files = json["files"];
  for (const char* name : kShardFiles) {
    std::string path = shard + "/" + name;
    std::error_code error;
    if (!files.contains(name) || !std::filesystem::is_regular_file(path, error) || files[name] != file_hash(path)) {
      return path;
    }
  }
  return "";
}

void require_unchanged(const std::string& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_directory() || !entry.path().filename().string().starts_with("shard_")) continue;
    const std::string changed = changed_file(entry.path().string());
    if (!changed.empty()) {
      throw InputError(printable(changed) + ": is not as it was written, by the hash in shard.json");
    }
  }
}

void PeopleSet::add_shard(const std::string& shard, PeopleSetKind kind) {
  const auto map = [&](const char* name, const char* type, const std::vector<std::size_t>& rest) {
    arrays_.push_back(std::make_unique<MappedArray>(shard + "/" + name));
    arrays_.back()->require(type, rest);
    return arrays_.back().get();
  };
  const MappedArray* const pictures = map("pictures.npy", "|u1", {kSide, kSide, 3});
  const MappedArray* const masks = map("masks.npy", "|u1", {kSide, kSide});
  const MappedArray* const keypoints = map("keypoints.npy", "<f4", {kKeypoints, 3});
  const MappedArray* const faces = map("faces.npy", "<f4", {4});
  const std::size_t count = pictures->shape()[0];
  for (const MappedArray* array : {masks, keypoints, faces}) {
    if (array->shape()[0] == count) continue;
    throw InputError(
        fmt::format("{}: {} items; pictures.npy beside it has {}", printable(array->path()), array->shape()[0], count));
  }
  constexpr std::size_t kValues = std::size_t{kKeypoints} * 3;
  for (const auto& [array, values] : {std::pair{keypoints, kValues}, std::pair{faces, std::size_t{4}}}) {
    const float* const first = array->floats(0);
    if (std::all_of(first, first + count * values, [](float v) { return std::isfinite(v); })) continue;
    throw InputError(printable(array->path()) + ": holds a value that is not finite");
  }

  const std::string list = shard + "/samples.json";
  const nlohmann::json samples = read_json_file(list);
  if (!samples.is_array() || samples.size() != count) {
    throw InputError(
        fmt::format("{}: must be a list of {} samples, as pictures.npy beside it", printable(list), count));
  }
  for (std::size_t i = 0; i < count; ++i) {
    PersonSample sample{pictures->bytes(i), masks->bytes(i), keypoints->floats(i), faces->floats(i), {}};
    Fields fields(samples[i], list, fmt::format("/{}", i));
    fields.required("people").integer("people", sample.people, kind == PeopleSetKind::faces ? 0 : 1, 1000);
    const float* const face = sample.face;
    const auto in_picture = [](float center) { return center >= 0 && center <= static_cast<float>(kSide); };
    if (sample.people > 0 &&
        !(face[2] > 0 && face[3] > 0 && in_picture(face[0] + face[2] / 2) && in_picture(face[1] + face[3] / 2))) {
      throw InputError(fmt::format("{}: face {}: {} {} {} {}: must have a size, and its center in the picture",
                                   printable(faces->path()), i, face[0], face[1], face[2], face[3]));
    }
    fields.required("composite").boolean("composite", sample.composite);
    const nlohmann::json& tags = fields.raw("tags");
    if (!tags.is_array()) fields.fail("tags", "must be a list of words");
    for (const nlohmann::json& tag : tags) {
      if (!tag.is_string()) fields.fail("tags", "must be a list of words");
      sample.tags.push_back(printable(tag.get<std::string>()));
      if (sample.tags.back().starts_with("turn:")) sample.turn_deg = turn_of(sample.tags.back(), fields);
    }
    fields.required("seed").integer("seed", sample.seed, 0, std::numeric_limits<std::uint64_t>::max());
    samples_.push_back(std::move(sample));
  }
}

PeopleSet::PeopleSet(const std::vector<std::string>& folders, bool held_out, PeopleSetKind kind) {
  std::string hashed;
  for (const std::string& folder : folders) {
    const std::string index = folder + "/" + kSetFile;
    std::error_code error;
    if (std::filesystem::exists(folder + "/shard_00000", error) && !std::filesystem::exists(index, error)) {
      throw InputError(printable(folder) + ": is not finished: run `dualpixel people` with its options again");
    }
    const nlohmann::json json = read_json_file(index);
    const auto field = [&](const char* name) { return json.is_object() ? json.value(name, nlohmann::json()) : json; };
    if (field("format") != "dualpixel people" || field("version") != 1 || field("size_px") != kSide) {
      throw InputError(fmt::format("{}: /format, /version, /size_px: {}, {}, {}: must be \"dualpixel people\", 1, {}",
                                   printable(index), printable(field("format").dump()),
                                   printable(field("version").dump()), printable(field("size_px").dump()), kSide));
    }
    if (field("held_out") != held_out) {
      throw InputError(
          fmt::format("{}: /held_out: {}: must be {}: a network is evaluated on data that it was not trained on",
                      printable(index), printable(field("held_out").dump()), held_out));
    }
    if ((field("faces") == true) != (kind == PeopleSetKind::faces)) {
      throw InputError(
          fmt::format("{}: /faces: must be {}: sets of `dualpixel people --faces` train the face detector, "
                      "others the person network",
                      printable(index), kind == PeopleSetKind::faces));
    }
    Fields fields(json, index);
    for (const char* name : {"format", "version", "size_px", "count", "generator", "seed", "held_out", "composites",
                             "makehuman", "faces", "shards"}) {
      fields.has(name);
    }
    fields.done();
    std::vector<std::string> shards;
    for (std::filesystem::directory_iterator entry(folder, error), end; entry != end; entry.increment(error)) {
      if (entry->path().filename().string().starts_with("shard_")) shards.push_back(entry->path().string());
    }
    if (error) throw InputError(printable(folder) + ": cannot be read as a folder: " + error.message());
    std::sort(shards.begin(), shards.end());

    const std::size_t before = samples_.size();
    hashed += read_file(index);
    for (const std::string& shard : shards) {
      add_shard(shard, kind);
      hashed += read_file(shard + "/" + kShardFile);
    }
    if (field("count") != samples_.size() - before || samples_.size() == before) {
      throw InputError(fmt::format("{}: /count: {}: its shards hold {}", printable(index),
                                   printable(field("count").dump()), samples_.size() - before));
    }
  }
  hash_ = hash_of(hashed);
}

}  // namespace dualpixel::scenes
