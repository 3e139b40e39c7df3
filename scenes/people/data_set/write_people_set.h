#pragma once
#include <functional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "scenes/people/people.h"

/// A set of people on disk (docs/people.md) and its contact sheet.
namespace dualpixel::scenes {

inline constexpr int kMostSamples = 10'000'000, kMostComposites = 100;

/// Throws InputError where an option lies outside its range.
void check_people_options(const PeopleOptions& options);

/// Writes shards and then people.json under `folder`. A shard that is there whole, from the same options, generator and
/// assets, is kept: a run that was ended goes on where it was; people.json is gone while any is made. Refused
/// (InputError) are a whole set of more samples, shards beyond the count, a set of another seed, kind, generator,
/// number of composites or assets, whole or begun, and a folder of something else. Each shard appears under its name in
/// one step. `each` gets the samples of every shard that is made.
void write_people_set(const PeopleOptions& options, const std::string& folder,
                      const std::function<void(double)>& progress = {},
                      const std::function<void(const std::vector<PeopleSample>&)>& each = {});

/// The first samples, at most `most`, side by side: mask outlined, face boxed, keypoints as dots (seen: full, hidden:
/// hollow). sRGB, 0..1.
Image contact_sheet(const std::vector<PeopleSample>& samples, int most, int columns);

}  // namespace dualpixel::scenes
