#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "scenes/people/makehuman/assets.h"
#include "scenes/people/sample.h"

/// Pictures of people with ground truth, for training and judging a segmentation network (Wadhwa et al. 2018, section
/// 3.1): procedural people in procedural environments, and composites of them in front of other backgrounds.
///
/// How the parts depend on each other: each includes only what is above it.
///
///   procedural                     random streams, noise, signed distances, surface nets (shared with make_scenes)
///   shape                          materials, objects, the scene's data structure
///   body | environment | photo     figures; where they are; camera, rendering, processing
///   clothing | hair | held         what a figure wears and holds; all three need only body
///   procedural_figure | makehuman  a whole person; makehuman needs hair and held, not clothing
///   truth                          keypoints, face boxes (needs body and photo)
///   picture, composite, people     one picture, composites, a shard of samples
///   data_set                       reading and writing sets
namespace dualpixel::scenes {

inline constexpr int kShardSamples = 512;
/// Raised whenever the same options give other samples.
inline constexpr int kTrainingGenerator = 8, kHeldOutGenerator = 2, kHeldOutMakeHumanGenerator = 3, kFacesGenerator = 2;

struct PeopleOptions {
  int count = kShardSamples;  ///< samples
  std::uint64_t seed = 1;
  bool held_out = false;  ///< from pools and intervals that training sets never draw from: see random_stream.h
  int composites = 4;     ///< of each rendered picture in front of other backgrounds
  /// For a face detector: heads turned anyhow, a sample of each face however small or hidden, and pictures of nobody.
  bool faces = false;
  /// Set: half of the people are made from these, and the set's bytes depend on them.
  std::shared_ptr<const MakeHumanAssets> makehuman;
};

/// The samples of one shard, `count` of them; the same for any number of threads. A sample depends on (seed, held_out,
/// composites, makehuman, shard, its index in the shard) alone, not on how many there are; but in a set for a face
/// detector, where no rendered picture is cut, the last ones are those that fit.
std::vector<PeopleSample> make_people_shard(const PeopleOptions& options, int shard, int count,
                                            const std::function<void(double)>& progress = {});

}  // namespace dualpixel::scenes
