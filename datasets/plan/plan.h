#pragma once
#include <array>
#include <string>
#include <vector>

#include "datasets/plan/assets.h"
#include "datasets/plan/sample_line.h"

namespace dualpixel::datasets {

/// The lines of a data set, and what they will take.
struct Plan {
  std::vector<SampleLine> lines;
  std::array<std::size_t, kSplitCount> samples{}, scenes{};  ///< of each split
  double bytes_per_sample = 0;                               ///< of pictures before compression, mean
  std::vector<std::string> warnings;  ///< of files left out; the first sample's that has any, and how many have
};

/// Sample k's line. It depends on the recipe without its count, on the files that it names, and on k alone.
SampleLine plan_line(const Recipe& recipe, const Assets& assets, int k);

/// Plans all samples, and checks that each is a scene that can be simulated. Throws InputError that names the recipe,
/// the first sample that is none, and why.
Plan make_plan(const Recipe& recipe);

inline constexpr const char* kPlanFile = "plan.jsonl";
inline constexpr const char* kDatasetFile = "dataset.json";

/// Writes plan.jsonl and dataset.json, which holds the recipe and the plan's hash, into a new folder. A folder that
/// holds the same plan is left as it is, and one that holds its first lines gets the others; another plan, or anything
/// else, is refused with InputError.
void write_plan(const Plan& plan, const Recipe& recipe, const std::string& folder);

/// The lines of the data set in `folder`. Throws InputError where it is none, or was changed.
std::vector<SampleLine> read_plan(const std::string& folder);

}  // namespace dualpixel::datasets
