#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

#include "scenes/people/body/figure.h"
#include "scenes/people/data_set/people_format.h"
#include "scenes/people/photo/shoot.h"

/// Pictures of people with their truth, for training and judging a segmentation network (Wadhwa et al. 2018, section
/// 3.1): procedural figures in procedural surroundings, and composites of them over other backgrounds. A sample depends
/// on (seed, held_out, composites, makehuman, shard, place in the shard) alone, not on how many there are.
namespace dualpixel::scenes {

inline constexpr int kMostPeople = 5, kShardSamples = 512;
/// Raised whenever the same options give other samples.
inline constexpr int kTrainingGenerator = 8, kHeldOutGenerator = 2, kHeldOutMakeHumanGenerator = 3;

class MakeHumanAssets;

struct PeopleOptions {
  int count = kShardSamples;  ///< samples in all
  std::uint64_t seed = 1;
  bool held_out = false;  ///< from pools and uniform numbers that training never draws: see random_stream.h
  int composites = 4;     ///< of each rendered picture over other backgrounds
  /// Set: half of the people are made from these; see makehuman.h. A set's bytes then depend on them, too.
  std::shared_ptr<const MakeHumanAssets> makehuman;
};

/// One picture and one of its people.
struct PeopleSample {
  std::vector<std::uint8_t> picture;            ///< 256 x 256 x 3, sRGB; the photograph centerd, 0 around it
  std::vector<std::uint8_t> mask;               ///< 256 x 256: 255 times the share of the pixel that shows this person
  std::array<glm::vec3, kKeypoints> keypoints;  ///< COCO's order; x, y, 0 out of the picture | 1 hidden | 2 seen
  glm::vec4 face{0};                            ///< x, y, width, height: brow to chin, square
  std::uint64_t seed = 0;                       ///< of the picture
  int picture_index = 0;                        ///< samples of one picture have the same
  int people = 1;                               ///< in the picture, bystanders not counted
  bool composite = false;
  std::vector<std::string> tags;
};

/// The samples of one shard, `count` of them; the same for any number of threads.
std::vector<PeopleSample> make_people_shard(const PeopleOptions& options, int shard, int count,
                                            const std::function<void(double)>& progress = {});

/// The 17 keypoints in the world, meters.
std::array<vec3, kKeypoints> keypoints_of(const Figure& figure);
/// Keypoints, face box and tags of one in the picture, in the camera's pixels. A keypoint is seen where the first thing
/// on the way to it is its own part of the person; else it is hidden.
PeopleSample truth_of(const RayTracer& tracer, const simulator::CameraView& camera, const Figure& figure,
                      const Rendering& exposure);
/// The square that a frontal face detector would draw, in the camera's pixels: x, y, width, height.
glm::vec4 face_box(const Figure& figure, const simulator::CameraView& camera);

}  // namespace dualpixel::scenes
