#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "scenes/people/data_set/mapped_array.h"
#include "scenes/people/data_set/people_format.h"

/// Reading a people set, the folder that `dualpixel people` writes (docs/people.md): shards of NumPy arrays, mapped
/// into memory and never copied.
namespace dualpixel::scenes {

/// What a set is made to train (PeopleOptions::faces).
enum class PeopleSetKind { masks, faces };

/// One picture and the person in it whose face is the seed. Pointers into the mapped files. Pixels are those of the
/// 256 x 256 picture, centers at .5.
struct PersonSample {
  const std::uint8_t* picture;    ///< 256 x 256 x 3, sRGB, padded with 0
  const std::uint8_t* mask;       ///< 256 x 256, coverage 0..255
  const float* keypoints;         ///< 17 x (x, y, visibility: 0 outside the picture, 1 hidden, 2 visible)
  const float* face;              ///< x, y, width, height; 0 where there is nobody
  std::vector<std::string> tags;  ///< "hair:long", ...
  int people = 1;                 ///< in the picture; 0 in sets for faces alone
  bool composite = false;         ///< in front of another background
  std::uint64_t seed = 0;         ///< of the scene: a rendered picture and its composites share it
  double turn_deg = 0;            ///< of the head from the camera, 0..180, by the tag "turn:30" of sets for faces
};

/// The path of the first file of a shard (a folder) whose hash differs from the one in shard.json beside it; "": none.
std::string changed_file(const std::string& shard);

/// Throws InputError where a file of any shard of a set has changed.
void require_unchanged(const std::string& folder);

class PeopleSet {
 public:
  /// Reads every shard of every folder. Throws InputError for anything but a people set of version 1 and 256 px, for
  /// folders whose count differs from people.json, for keypoints or faces that are not finite, and where a set is held
  /// out and `held_out` is false or the other way round: training data must not be used for evaluation. Likewise where
  /// a set is of the other kind.
  PeopleSet(const std::vector<std::string>& folders, bool held_out, PeopleSetKind kind = PeopleSetKind::masks);

  std::size_t size() const { return samples_.size(); }
  const PersonSample& operator[](std::size_t i) const { return samples_[i]; }
  /// Identifies the data: a hash of people.json and of every shard.json, which hold the hashes of the arrays. Whether
  /// the arrays have changed since is not checked.
  const std::string& hash() const { return hash_; }

 private:
  void add_shard(const std::string& shard, PeopleSetKind kind);

  std::vector<std::unique_ptr<MappedArray>> arrays_;
  std::vector<PersonSample> samples_;
  std::string hash_;
};

}  // namespace dualpixel::scenes
