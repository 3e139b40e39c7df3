#pragma once
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "scenes/people/people.h"

/// Writing a people set (docs/people.md).
namespace dualpixel::scenes {

inline constexpr int kMostSamples = 10'000'000, kMostComposites = 100;

/// Throws InputError where an option is out of range.
void check_people_options(const PeopleOptions& options);

/// Writes shards and then people.json under `folder`. A complete shard of the same options, generator and assets is
/// kept, so that an interrupted run resumes; people.json is absent while shards are made, and each shard appears in one
/// step. Throws InputError, and changes nothing, where the folder holds a complete set of more samples, shards beyond
/// the count, a set (complete or not) of another seed, kind, generator, number of composites or assets, or something
/// else. `each` gets the samples of every shard that is made. False where `stopped` became other than 0: no further
/// shard is begun then.
bool write_people_set(const PeopleOptions& options, const std::string& folder,
                      const std::function<void(double)>& progress = {},
                      const std::function<void(const std::vector<PeopleSample>&)>& each = {},
                      const std::atomic<int>* stopped = nullptr);

}  // namespace dualpixel::scenes
