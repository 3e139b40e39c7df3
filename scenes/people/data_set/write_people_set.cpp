#include "scenes/people/data_set/write_people_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/npy.h"
#include "capture/json_fields.h"
#include "scenes/people/data_set/read_people_set.h"
#include "scenes/people/makehuman/makehuman.h"

namespace dualpixel::scenes {
namespace {

namespace fs = std::filesystem;
constexpr const char* kShardFormat = "dualpixel people shard";

std::string shard_name(int shard) { return fmt::format("shard_{:05}", shard); }

int samples_of_shard(const PeopleOptions& options, int shard) {
  return std::min(kShardSamples, options.count - shard * kShardSamples);
}

int generator_of(const PeopleOptions& options) {
  if (!options.held_out) return kTrainingGenerator;
  return options.makehuman ? kHeldOutMakeHumanGenerator : kHeldOutGenerator;
}

/// What a shard was made from, and so whether it need not be made again.
nlohmann::ordered_json shard_recipe(const PeopleOptions& options, int shard) {
  return {{"format", kShardFormat},
          {"version", 1},
          {"generator", generator_of(options)},
          {"shard", shard},
          {"count", samples_of_shard(options, shard)},
          {"seed", options.seed},
          {"held_out", options.held_out},
          {"composites", options.composites},
          {"makehuman", options.makehuman ? options.makehuman->hash : ""}};
}

/// A file's JSON object, an empty one where there is none: what a run that was ended by force left is made anew.
nlohmann::json object_in(const std::string& path) {
  try {
    nlohmann::json json = read_json_file(path);
    if (json.is_object()) return json;
  } catch (const InputError&) {
  }
  return nlohmann::json::object();
}

/// Whether a shard of this recipe is there with all its files as they were written.
bool is_there(const std::string& folder, const nlohmann::ordered_json& recipe) {
  nlohmann::json written = object_in(folder + "/" + kShardFile);
  written.erase("files");
  return written == nlohmann::json(recipe) && changed_file(folder).empty();
}

/// Shards of a larger set in the same folder would be taken for a part of this one.
void refuse_shards_beyond(const std::string& folder, int shards) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("shard_") && name >= shard_name(shards)) {
      throw InputError(fmt::format("{}/{}: from a set of more than {} shards: remove it, or choose another folder",
                                   printable(folder), printable(name), shards));
    }
  }
}

/// What people.json says of that which every sample depends on.
nlohmann::ordered_json set_recipe(const PeopleOptions& options) {
  return {{"generator", generator_of(options)},
          {"seed", options.seed},
          {"held_out", options.held_out},
          {"composites", options.composites},
          {"makehuman", options.makehuman != nullptr}};
}

/// What other options, another generator or other assets made may be hours of somebody's work.
void refuse_another(const std::string& folder, nlohmann::json written, const nlohmann::ordered_json& recipe) {
  if (!written.contains("generator")) written["generator"] = 2;  // the last that did not write itself down
  // the generator last: held-out sets have their own
  for (const char* name : {"held_out", "makehuman", "composites", "seed", "generator"}) {
    if (!written.contains(name) || written[name] == nlohmann::json(recipe[name])) continue;
    const std::string difference =
        name == std::string_view("makehuman")
            ? "other figures (--makehuman)"
            : fmt::format("{} {}, not {}", name, printable(written[name].dump()), recipe[name].dump());
    throw InputError(fmt::format("{}: holds a set with {}: choose another folder, or remove this one",
                                 printable(folder), difference));
  }
}

/// A set of other options, and what is no set, is not ours to write into.
void refuse_what_is_another(const std::string& folder, const PeopleOptions& options) {
  std::vector<std::string> shards;
  bool strangers = false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("shard_")) shards.push_back(entry.path().string());
    strangers = strangers || !name.starts_with(kTemporaryPrefix);  // a killed run may have left one
  }
  const bool whole = fs::exists(folder + "/" + kSetFile);
  nlohmann::json set = object_in(folder + "/" + kSetFile);
  if (whole ? set["format"] != "dualpixel people" : shards.empty() && strangers) {
    throw InputError(printable(folder) + ": holds something that is no set of people: choose another folder");
  }
  if (whole) refuse_another(folder, set, set_recipe(options));
  if (whole && set["count"].is_number_integer() && set["count"] > options.count) {
    throw InputError(fmt::format("{}: holds a set of {} samples, --count {} would remove some: choose another folder",
                                 printable(folder), set["count"].dump(), options.count));
  }
  for (const std::string& shard : shards) {
    nlohmann::json written = object_in(shard + "/" + kShardFile);
    if (written["format"] == kShardFormat) refuse_another(folder, std::move(written), shard_recipe(options, 0));
  }
}

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

void write_shard(const std::vector<PeopleSample>& samples, const std::string& path, nlohmann::ordered_json recipe) {
  NewFolder out(path, kShardFile);
  const std::size_t n = samples.size(), side = kPictureSide_px;
  std::vector<std::uint8_t> pictures, masks;
  std::vector<float> keypoints, faces;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const PeopleSample& s : samples) {
    pictures.insert(pictures.end(), s.picture.begin(), s.picture.end());
    masks.insert(masks.end(), s.mask.begin(), s.mask.end());
    for (const glm::vec3& k : s.keypoints) keypoints.insert(keypoints.end(), {k.x, k.y, k.z});
    faces.insert(faces.end(), {s.face.x, s.face.y, s.face.z, s.face.w});
    list.push_back({{"seed", s.seed},
                    {"picture", s.picture_index},
                    {"people", s.people},
                    {"composite", s.composite},
                    {"tags", s.tags}});
  }
  const std::string contents[] = {npy_bytes("|u1", {n, side, side, 3}, bytes_of(pictures)),
                                  npy_bytes("|u1", {n, side, side}, bytes_of(masks)),
                                  npy_bytes("<f4", {n, kKeypoints, 3}, bytes_of(keypoints)),
                                  npy_bytes("<f4", {n, 4}, bytes_of(faces)), list.dump() + "\n"};
  for (std::size_t i = 0; i < std::size(contents); ++i) {
    write_file(out.path() + "/" + kShardFiles[i], contents[i]);
    recipe["files"][kShardFiles[i]] = hash_of(contents[i]);
  }
  write_file(out.path() + "/" + kShardFile, recipe.dump(2) + "\n");
  out.commit();
}

struct Color {
  float r, g, b;
};

void paint(Image& image, int x, int y, Color color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  image.at(x, y, 0) = color.r, image.at(x, y, 1) = color.g, image.at(x, y, 2) = color.b;
}

}  // namespace

void check_people_options(const PeopleOptions& options) {
  if (options.count < 1 || options.count > kMostSamples) {
    throw InputError(fmt::format("--count {}: 1 to {} samples can be made", options.count, kMostSamples));
  }
  if (options.composites < 0 || options.composites > kMostComposites) {
    throw InputError(
        fmt::format("--composites {}: 0 to {} of each picture can be made", options.composites, kMostComposites));
  }
}

void write_people_set(const PeopleOptions& options, const std::string& folder,
                      const std::function<void(double)>& progress,
                      const std::function<void(const std::vector<PeopleSample>&)>& each) {
  check_people_options(options);
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder)) throw InputError(fmt::format("{}: cannot be made a folder", printable(folder)));
  const int shards = (options.count + kShardSamples - 1) / kShardSamples;
  refuse_what_is_another(folder, options);
  refuse_shards_beyond(folder, shards);
  for (int shard = 0; shard < shards; ++shard) {
    const std::string path = folder + "/" + shard_name(shard);
    const nlohmann::ordered_json recipe = shard_recipe(options, shard);
    if (!is_there(path, recipe)) {
      fs::remove(folder + "/" + kSetFile, error);  // until it is written anew, the set is not whole
      const auto samples = make_people_shard(options, shard, samples_of_shard(options, shard), [&](double fraction) {
        if (progress) progress((shard + fraction) / shards);
      });
      write_shard(samples, path, recipe);
      if (each) each(samples);
    }
    if (progress) progress((shard + 1.0) / shards);
  }
  nlohmann::ordered_json json = {
      {"format", "dualpixel people"}, {"version", 1}, {"size_px", kPictureSide_px}, {"count", options.count}};
  json.update(set_recipe(options));
  json["shards"] = shards;
  replace_file(folder + "/" + kSetFile, json.dump(2) + "\n");
}

Image contact_sheet(const std::vector<PeopleSample>& samples, int most, int columns) {
  const int n = std::min(static_cast<int>(samples.size()), most), rows = (n + columns - 1) / columns;
  Image sheet(std::min(columns, n) * kPictureSide_px, rows * kPictureSide_px, 3);
  for (int i = 0; i < n; ++i) {
    const PeopleSample& s = samples[i];
    const int left = i % columns * kPictureSide_px, top = i / columns * kPictureSide_px;
    const auto mask_at = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < kPictureSide_px && y < kPictureSide_px &&
             s.mask[static_cast<std::size_t>(y) * kPictureSide_px + x] > 127;
    };
    for (int y = 0; y < kPictureSide_px; ++y) {
      for (int x = 0; x < kPictureSide_px; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * kPictureSide_px + x;
        for (int c = 0; c < 3; ++c) sheet.at(left + x, top + y, c) = static_cast<float>(s.picture[3 * at + c]) / 255;
        const bool edge =
            mask_at(x, y) && !(mask_at(x - 1, y) && mask_at(x + 1, y) && mask_at(x, y - 1) && mask_at(x, y + 1));
        if (edge) paint(sheet, left + x, top + y, {0, 1, 0.3f});
      }
    }
    const int x0 = static_cast<int>(s.face.x), y0 = static_cast<int>(s.face.y), side = static_cast<int>(s.face.z);
    for (int k = 0; k <= side; ++k) {
      for (const auto& [x, y] : {std::pair{x0 + k, y0}, {x0 + k, y0 + side}, {x0, y0 + k}, {x0 + side, y0 + k}}) {
        if (x >= 0 && y >= 0 && x < kPictureSide_px && y < kPictureSide_px)
          paint(sheet, left + x, top + y, {1, 0.9f, 0});
      }
    }
    for (const glm::vec3& k : s.keypoints) {
      if (k.z < 0.5f) continue;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (k.z < 1.5f && dx == 0 && dy == 0) continue;
          paint(sheet, left + static_cast<int>(k.x) + dx, top + static_cast<int>(k.y) + dy,
                k.z > 1.5f ? Color{1, 0, 0.2f} : Color{0.2f, 0.6f, 1});
        }
      }
    }
  }
  return sheet;
}

}  // namespace dualpixel::scenes
