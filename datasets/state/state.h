#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "datasets/recipe/recipe.h"

/// A data set as a whole: what is there of it.
namespace dualpixel::datasets {

struct DatasetState {
  struct Counts {
    int planned = 0, there = 0, failed = 0;  ///< failed: tried, and not there
  };
  std::array<Counts, kSplitCount> splits;
  std::map<std::string, std::string> reasons;  ///< of the failed, by name

  Counts total() const;
};

/// Throws InputError where `folder` is no data set.
DatasetState state_of(const std::string& folder);

/// What is not as it was written, one line for each sample that is there; empty: all is well. Samples are read.
std::vector<std::string> faults_of(const std::string& folder);

struct Cleared {
  int leftovers = 0;  ///< temporary folders of programs that ended
  int damaged = 0;    ///< samples that are not as they were written, which the next render makes again
  int scenes = 0;     ///< drawn scenes, where no sample is missing any more
};

/// Removes what a data set does not need. Not while it is being rendered. Throws InputError, and removes nothing, where
/// the folder of samples or of scenes is a link.
Cleared clear(const std::string& folder);

}  // namespace dualpixel::datasets
