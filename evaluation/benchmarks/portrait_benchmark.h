#pragma once
#include <array>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

/// Time and memory of the whole portrait on captures, faces and person network included, beside Wadhwa et al. 2018,
/// Table 4.
namespace dualpixel::evaluation {

/// In the order of the paper's columns.
inline constexpr const char* kTableFourModes[] = {"dp", "seg", "dp+seg"};

/// Wall time over captures, all cores, milliseconds.
struct TimeSpread {
  double mean_ms = 0, sigma_ms = 0;
  std::size_t captures = 0;
};

/// A row of the table: a part of the work in each mode that has it.
struct TableFourRow {
  std::string name;
  std::array<std::optional<TimeSpread>, 3> ours;
  std::array<std::optional<double>, 3> paper_ms;  ///< on a phone with eight cores
  std::optional<double> paper_sigma_ms;
};

struct PortraitBenchmark {
  std::string matcher;
  std::size_t captures = 0, with_people = 0;  ///< seg and dp+seg are those with people alone
  std::string sizes;                          ///< of the captures: "672 x 504, 9 frames", the smallest and the largest
  int threads = 0;
  std::vector<TableFourRow> rows;                ///< the last is the total
  std::array<std::optional<double>, 3> peak_mb;  ///< the most over captures, above what the process held before
};

/// Each mode on each capture, the best of three by its total. Faces are found in mode dp, too, as the paper's totals
/// have it. `matcher`: a name of pipeline/disparity/matchers.h. Throws InputError where a capture cannot be read, has
/// no views or no mosaic, and in a build without oneDNN.
PortraitBenchmark measure_portraits(const std::vector<std::string>& captures, const std::string& matcher,
                                    const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const PortraitBenchmark& benchmark);
/// For a terminal.
std::string to_text(const PortraitBenchmark& benchmark);

}  // namespace dualpixel::evaluation
