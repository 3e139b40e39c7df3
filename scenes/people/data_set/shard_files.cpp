#include "scenes/people/data_set/shard_files.h"

#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "capture/files.h"
#include "capture/image/npy.h"
#include "scenes/people/data_set/people_format.h"

namespace dualpixel::scenes {
namespace {

template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

}  // namespace

void write_shard_files(const std::string& folder, const PeopleArrays& arrays, nlohmann::ordered_json recipe) {
  constexpr std::size_t kSide = kPictureSide_px;
  const std::size_t n = arrays.faces.size() / 4;
  const std::string contents[] = {npy_bytes("|u1", {n, kSide, kSide, 3}, bytes_of(arrays.pictures)),
                                  npy_bytes("|u1", {n, kSide, kSide}, bytes_of(arrays.masks)),
                                  npy_bytes("<f4", {n, kKeypoints, 3}, bytes_of(arrays.keypoints)),
                                  npy_bytes("<f4", {n, 4}, bytes_of(arrays.faces)), arrays.samples_json};
  for (std::size_t i = 0; i < std::size(contents); ++i) {
    write_file(folder + "/" + kShardFiles[i], contents[i]);
    recipe["files"][kShardFiles[i]] = hash_of(contents[i]);
  }
  write_file(folder + "/" + kShardFile, recipe.dump(2) + "\n");
}

nlohmann::ordered_json people_index(int count, const nlohmann::ordered_json& recipe, int shards) {
  nlohmann::ordered_json json = {
      {"format", "dualpixel people"}, {"version", 1}, {"size_px", kPictureSide_px}, {"count", count}};
  json.update(recipe);
  json["shards"] = shards;
  return json;
}

}  // namespace dualpixel::scenes
