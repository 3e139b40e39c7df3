#pragma once
#include <functional>
#include <string>
#include <vector>

namespace dualpixel::evaluation {

struct AtlasOptions {
  /// "thin", "prescription", a camera file or a lens file: what the scenes are rendered through. "ideal": nothing, the
  /// views are those of closed forms.
  std::string camera = "thin";
  std::vector<std::string> methods;  ///< matchers: these alone; NAME=COMMAND: another program beside them
  std::vector<std::string> rows;     ///< names; empty: all
  unsigned draws = 1;                ///< textures and noises that each figure is of
};

inline constexpr const char* kAtlasFile = "failures.json";

/// Measures the rows and writes DIR/failures.json and DIR/failures.html. Each row is kept in DIR/rows once it is
/// measured, and taken from there by the next call that asks for the same, so that an interrupted atlas goes on. Throws
/// InputError.
void run_failure_atlas(const AtlasOptions& options, const std::string& folder,
                       const std::function<void(double fraction)>& progress = {});

}  // namespace dualpixel::evaluation
