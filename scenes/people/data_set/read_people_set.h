#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "scenes/people/data_set/people_format.h"

/// Reading a people set, the folder that `dualpixel people` writes (docs/people.md): shards of NumPy arrays, mapped
/// into memory and never copied.
namespace dualpixel::scenes {

/// One picture and the person in it whose face is the seed; pointers into the mapped files. Pixels are those of the
/// 256 x 256 picture, centers at .5.
struct PersonSample {
  const std::uint8_t* picture;    ///< 256 x 256 x 3, sRGB, padded with 0
  const std::uint8_t* mask;       ///< 256 x 256, coverage 0..255
  const float* keypoints;         ///< 17 x (x, y, visibility: 0 not in the picture, 1 hidden, 2 seen)
  const float* face;              ///< x, y, width, height
  std::vector<std::string> tags;  ///< "hair:long", ...
  int people = 1;                 ///< in the picture
  bool composite = false;         ///< set before another background
  std::uint64_t seed = 0;         ///< of the scene: a rendered picture and its composites share it
};

/// A NumPy file (version 1, C order) of uint8 or little-endian float32, mapped. Throws InputError where it is
/// anything else, or shorter or longer than its header says.
class MappedArray {
 public:
  explicit MappedArray(const std::string& path);
  ~MappedArray();
  MappedArray(const MappedArray&) = delete;
  MappedArray& operator=(const MappedArray&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<std::size_t>& shape() const { return shape_; }
  /// Values from item `i` of the first dimension on, of a file that holds such (require()).
  const std::uint8_t* bytes(std::size_t i) const;
  const float* floats(std::size_t i) const;
  /// Throws InputError unless the file holds `type` values of the shape (any, rest...).
  void require(const std::string& type, const std::vector<std::size_t>& rest) const;

 private:
  void read_header();

  std::string path_;
  std::string type_;
  std::vector<std::size_t> shape_;
  std::size_t item_bytes_ = 0;
  std::size_t header_bytes_ = 0;
  std::size_t file_bytes_ = 0;
  const char* file_ = nullptr;
};

/// Of the files of a shard (a folder), the first that is not as shard.json beside it says, by its hash: its path. None
/// of them: "".
std::string changed_file(const std::string& shard);

/// Throws InputError where that is so in any shard of a set.
void require_unchanged(const std::string& folder);

class PeopleSet {
 public:
  /// Every shard of every folder. Throws InputError for what is no people set of version 1 and 256 px, for folders
  /// that disagree with people.json about their count, for keypoints or faces that are not finite, and where a folder
  /// is not held out though `held_out` says so, or the other way round: what is learned from must not be judged with.
  PeopleSet(const std::vector<std::string>& folders, bool held_out);

  std::size_t size() const { return samples_.size(); }
  const PersonSample& operator[](std::size_t i) const { return samples_[i]; }
  /// Of people.json and of every shard.json, in which `dualpixel people` wrote the hashes of the arrays: tells one set
  /// from another. Whether the arrays still are those is not looked at.
  const std::string& hash() const { return hash_; }

 private:
  void add_shard(const std::string& shard);

  std::vector<std::unique_ptr<MappedArray>> arrays_;
  std::vector<PersonSample> samples_;
  std::string hash_;
};

}  // namespace dualpixel::scenes
