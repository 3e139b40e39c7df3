#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "capture/image/map_file.h"

namespace dualpixel::tools {

/// A disparity that any program found, as files on the command line.
struct MapFiles {
  std::string disparity, confidence, sigma;  ///< empty: not given
  IntegerScale integers;
  bool scaled = false;  ///< whether `integers` was given

  bool any() const { return !(disparity + confidence + sigma).empty(); }
};

/// --disparity, --confidence, --sigma, --scale, --offset. `sizes` says which a map may have. `files` must outlive
/// parsing. Returns --disparity.
CLI::Option* add_map_options(CLI::App& command, MapFiles& files, const std::string& sizes);

struct DisparityMaps {
  Image disparity_dp_px, confidence, sigma_dp_px;
};

/// What is wrong with a file goes to `problems`, and its map stays empty.
DisparityMaps read_maps(const MapFiles& files, std::vector<std::string>& problems);

}  // namespace dualpixel::tools
