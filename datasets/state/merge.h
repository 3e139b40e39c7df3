#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "datasets/pictures/pictures.h"

namespace dualpixel::datasets {

inline constexpr const char* kIndexFile = "index.jsonl";

/// Joins what is rendered of a data set: writes index.jsonl, one line a sample in order of their names, with split,
/// folder, files, camera, exposure and statistics, and returns the lines. Of the dpdd layout it also lays the pictures
/// out as DPDD has them, by hard links: dpdd/{train,val,test}_{c,l,r}/source/NAME.png and dpdd/{...}_c/target/NAME.png;
/// of the google layout likewise google/{train,validation,test}/FOLDER/NAME/FILE (datasets/pictures/google.h).
/// Links of samples that are not there any more are removed.
/// Throws InputError where the folder is no data set, a sample cannot be read, or nothing is rendered, or a folder
/// of a layout's tree is a symbolic link; all is then as it was.
std::vector<nlohmann::json> merge_samples(const std::string& folder);

/// A line that says in how many of an index's samples rendering noise is more than twice the sensor's, so that a method
/// would be trained on it, and what helps; empty where in none.
std::string noise_warning(const std::vector<nlohmann::json>& index);

}  // namespace dualpixel::datasets
