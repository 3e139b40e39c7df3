#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/portrait/run_portrait.h"

/// Time and memory of the whole pipeline beside Wadhwa et al. 2018, Table 4, and of the defocus renderers by
/// themselves.
namespace dualpixel::evaluation {

struct ModeTime {
  std::string mode;  ///< "dp", "seg", "dp+seg"
  double paper_ms = 0;
  double ms = 0, cpu_ms = 0;  ///< the best of five runs
  std::vector<pipeline::StageTime> stages;
  double peak_mb = 0;  ///< above what the process held before
};

struct RendererTime {
  std::string name;  ///< key in the JSON, words joined by _
  double ms = 0, cpu_ms = 0;
};

/// Scattering the whole picture at half its size by one radius.
struct RadiusTime {
  double radius_px = 0;  ///< of the full-size picture
  double gradient_ms = 0, gradient_cpu_ms = 0;
  std::optional<double> direct_ms, direct_cpu_ms;  ///< brute force; none above 20 px
};

struct DefocusBenchmark {
  std::vector<ModeTime> modes;
  std::vector<RendererTime> renderers;
  std::vector<RadiusTime> radii;
};

/// On a burst of the scene at its full size; all cores.
DefocusBenchmark measure_defocus_time(const std::string& scene_file);

/// A row of the paper's Table 4, beside the sum of the stages here that do the same.
struct TableFourRow {
  std::string name;
  double paper_ms = 0;  ///< on a phone with eight cores; NaN: not in the table
  double ms = 0;
};
std::vector<TableFourRow> table_four(const DefocusBenchmark& benchmark);

nlohmann::ordered_json to_json(const DefocusBenchmark& benchmark);
std::string to_page(const DefocusBenchmark& benchmark);

}  // namespace dualpixel::evaluation
