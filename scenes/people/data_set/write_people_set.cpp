#include "scenes/people/data_set/write_people_set.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "scenes/people/data_set/people_format.h"
#include "scenes/people/data_set/read_people_set.h"
#include "scenes/people/data_set/shard_files.h"

namespace dualpixel::scenes {
namespace {

namespace fs = std::filesystem;
constexpr const char* kShardFormat = "dualpixel people shard";

std::string shard_name(int shard) { return fmt::format("shard_{:05}", shard); }

int samples_of_shard(const PeopleOptions& options, int shard) {
  return std::min(kShardSamples, options.count - shard * kShardSamples);
}

int generator_of(const PeopleOptions& options) {
  if (options.faces) return kFacesGenerator;
  if (!options.held_out) return kTrainingGenerator;
  return options.makehuman ? kHeldOutMakeHumanGenerator : kHeldOutGenerator;
}

/// What a shard depends on: one with the same recipe is kept.
nlohmann::ordered_json shard_recipe(const PeopleOptions& options, int shard) {
  nlohmann::ordered_json recipe = {{"format", kShardFormat},
                                   {"version", 1},
                                   {"generator", generator_of(options)},
                                   {"shard", shard},
                                   {"count", samples_of_shard(options, shard)},
                                   {"seed", options.seed},
                                   {"held_out", options.held_out},
                                   {"composites", options.composites},
                                   {"makehuman", options.makehuman ? options.makehuman->hash : ""}};
  if (options.faces) recipe["faces"] = true;
  return recipe;
}

/// A file's JSON object; an empty one where there is none, as after a killed run, whose shard is made again.
nlohmann::json object_in(const std::string& path) {
  try {
    nlohmann::json json = read_json_file(path);
    if (json.is_object()) return json;
  } catch (const InputError&) {
  }
  return nlohmann::json::object();
}

/// Whether a shard of this recipe is there and complete, with unchanged files.
bool is_there(const std::string& folder, const nlohmann::ordered_json& recipe) {
  nlohmann::json written = object_in(folder + "/" + kShardFile);
  written.erase("files");
  return written == nlohmann::json(recipe) && changed_file(folder).empty();
}

/// Shards of a larger set in the same folder would be read as part of this one.
void refuse_shards_beyond(const std::string& folder, int shards) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("shard_") && name >= shard_name(shards)) {
      throw InputError(fmt::format("{}/{}: from a set of more than {} shards: remove it, or choose another folder",
                                   printable(folder), printable(name), shards));
    }
  }
}

/// What all samples of a set depend on, as people.json says it.
nlohmann::ordered_json set_recipe(const PeopleOptions& options) {
  nlohmann::ordered_json recipe = {{"generator", generator_of(options)},
                                   {"seed", options.seed},
                                   {"held_out", options.held_out},
                                   {"composites", options.composites},
                                   {"makehuman", options.makehuman != nullptr}};
  if (options.faces) recipe["faces"] = true;
  return recipe;
}

/// A set of other options, another generator or other assets may be hours of work: it is not overwritten.
void refuse_another(const std::string& folder, nlohmann::json written, const nlohmann::ordered_json& recipe) {
  if (!written.contains("generator")) written["generator"] = 2;  // the last generator that sets did not name
  if ((written["faces"] == true) != recipe.contains("faces")) {
    throw InputError(printable(folder) +
                     ": holds a set of the other kind (--faces): choose another folder, or remove this one");
  }
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

/// Refuses a folder that cannot be made or written to. It is made with the first shard, minutes later, so that a run
/// that ends before leaves nothing.
void require_folder(const std::string& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder, error);  // empty where there is no working folder any more
  // a dangling link is there
  while (!there.empty() && fs::symlink_status(there, error).type() == fs::file_type::not_found) {
    there = there.parent_path();
  }
  if (!fs::is_directory(there, error) || access(there.c_str(), W_OK | X_OK) != 0) {
    throw InputError(fmt::format("{}: cannot be made a folder", printable(folder)));
  }
}

/// Refuses a folder that holds a set of other options, or something that is not a set.
void refuse_other_contents(const std::string& folder, const PeopleOptions& options) {
  std::vector<std::string> shards;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("shard_")) shards.push_back(entry.path().string());
  }
  const bool whole = fs::exists(folder + "/" + kSetFile);
  nlohmann::json set = object_in(folder + "/" + kSetFile);
  if (whole ? set["format"] != "dualpixel people" : shards.empty() && !holds_nothing(folder)) {
    throw InputError(printable(folder) + ": holds something that is not a set of people: choose another folder");
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

void write_shard(const std::vector<PeopleSample>& samples, const std::string& path,
                 const nlohmann::ordered_json& recipe) {
  NewFolder out(path, kShardFile);
  PeopleArrays arrays;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const PeopleSample& s : samples) {
    arrays.pictures.insert(arrays.pictures.end(), s.picture.begin(), s.picture.end());
    arrays.masks.insert(arrays.masks.end(), s.mask.begin(), s.mask.end());
    for (const glm::vec3& k : s.keypoints) arrays.keypoints.insert(arrays.keypoints.end(), {k.x, k.y, k.z});
    arrays.faces.insert(arrays.faces.end(), {s.face.x, s.face.y, s.face.z, s.face.w});
    list.push_back({{"seed", s.seed},
                    {"picture", s.picture_index},
                    {"people", s.people},
                    {"composite", s.composite},
                    {"tags", s.tags}});
  }
  arrays.samples_json = list.dump() + "\n";
  write_shard_files(out.path(), arrays, recipe);
  out.commit();
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

bool write_people_set(const PeopleOptions& options, const std::string& folder,
                      const std::function<void(double)>& progress,
                      const std::function<void(const std::vector<PeopleSample>&)>& each,
                      const std::atomic<int>* stopped) {
  check_people_options(options);
  require_folder(folder);
  const int shards = (options.count + kShardSamples - 1) / kShardSamples;
  if (fs::exists(folder)) {
    refuse_other_contents(folder, options);
    refuse_shards_beyond(folder, shards);
  }
  for (int shard = 0; shard < shards; ++shard) {
    const std::string path = folder + "/" + shard_name(shard);
    const nlohmann::ordered_json recipe = shard_recipe(options, shard);
    if (!is_there(path, recipe)) {
      if (stopped && *stopped != 0) return false;
      std::error_code ignored;
      fs::remove(folder + "/" + kSetFile, ignored);  // the set is incomplete until it is written again
      const auto samples = make_people_shard(options, shard, samples_of_shard(options, shard), [&](double fraction) {
        if (progress) progress((shard + fraction) / shards);
      });
      write_shard(samples, path, recipe);
      if (each) each(samples);
    }
    if (progress) progress((shard + 1.0) / shards);
  }
  replace_file(folder + "/" + kSetFile, people_index(options.count, set_recipe(options), shards).dump(2) + "\n");
  return true;
}

}  // namespace dualpixel::scenes
