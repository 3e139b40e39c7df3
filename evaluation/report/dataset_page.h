#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace dualpixel::evaluation {

/// What a data set is like, as one page: samples of each split, distributions of disparity, depth, light, focus and
/// rendering noise, and a contact sheet. `index` is that of datasets::merge_samples(folder). It lies here and not with
/// the data sets, as our pages and plots do. Throws InputError where a preview cannot be read.
std::string dataset_page(const std::vector<nlohmann::json>& index, const std::string& folder);

}  // namespace dualpixel::evaluation
