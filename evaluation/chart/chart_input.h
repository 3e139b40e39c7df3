#pragma once
#include <string>

namespace dualpixel::evaluation {

/// What the stages of a chart are measured on.
struct ChartInput {
  bool quick = false;
  std::string scenes_folder, lenses_folder;  ///< the shipped scenes, as built; lens_models/
  std::string scratch;                       ///< an empty folder, for captures that a benchmark reads
  std::string program;                       ///< dualpixel itself, for what another process has to do
  std::string cycles_script;                 ///< tools/compare_cycles.py; empty: Cycles is left out
};

}  // namespace dualpixel::evaluation
