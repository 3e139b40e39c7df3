#pragma once
#include <functional>
#include <string>
#include <vector>

#include "capture/image/image.h"

/// The stages of the pipeline before and after matching, each given what is ever harder for it. (How matching fails:
/// evaluation/failures/.)
namespace dualpixel::evaluation {

struct StageOutcome {
  double figure = 0;  ///< StageRow::figure
  Image picture_srgb;
};

struct StageRow {
  std::string stage;  ///< "burst", "calibration", "edges", "people", "defocus"
  std::string name;   ///< key in the JSON; no two rows have the same
  std::string title;
  std::string sweep;           ///< the swept quantity, with unit
  std::string key;             ///< the same as a key, with unit
  std::vector<double> values;  ///< from harmless to hopeless
  std::string figure;          ///< what is measured, with unit
  double limit = 0;            ///< beyond it the stage is broken
  bool falls = false;          ///< the figure falls towards the limit: broken is what lies below
  std::string reason;          ///< why the limit lies there
  /// Calls the product's own functions. Another draw, from 0: other noise, textures or people.
  std::function<StageOutcome(double value, unsigned draw)> make;
  bool log = false;       ///< values are charted on a logarithmic axis
  std::string note = {};  ///< what is seen, and why no value breaks the stage where none does
};

std::vector<StageRow> burst_rows();
std::vector<StageRow> calibration_rows();
std::vector<StageRow> edge_rows();
/// None where the build has no person network.
std::vector<StageRow> people_rows();
std::vector<StageRow> defocus_rows();

}  // namespace dualpixel::evaluation
