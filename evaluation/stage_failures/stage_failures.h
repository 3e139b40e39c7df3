#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/stage_failures/stage_row.h"

namespace dualpixel::evaluation {

struct StageStep {
  double value = 0;          ///< of the swept quantity
  double figure = 0;         ///< mean over the draws
  double low = 0, high = 0;  ///< of single draws
  std::string picture_uri;   ///< of the first draw: a JPEG file as a data URI
};

/// Indices of steps; as many as there are steps: it holds throughout.
struct StageBreak {
  std::size_t step = 0;           ///< the first whose mean lies beyond the limit
  std::size_t low = 0, high = 0;  ///< the first and the last of the single draws' own
};

struct StageSweep {
  StageRow row;
  std::vector<StageStep> steps;
  StageBreak breaks;

  /// The value of a step as text; "never" at the end.
  std::string value_at(std::size_t step) const;
};

/// All rows, in the order of the pipeline's stages.
std::vector<StageRow> stage_rows();

/// Those that `names` name, by row or by stage; all where there are none. Throws InputError for an unknown one.
std::vector<StageRow> stage_rows_named(const std::vector<std::string>& names);

/// `draws`: how many draws each figure is the mean of, 1 or more.
StageSweep measure_stage_row(const StageRow& row, unsigned draws,
                             const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const std::vector<StageSweep>& sweeps, unsigned draws);
/// A table of all rows, whose cells lead to curves and pictures.
std::string to_page(const std::vector<StageSweep>& sweeps, unsigned draws);

}  // namespace dualpixel::evaluation
