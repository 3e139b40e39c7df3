#include "evaluation/benchmarks/portrait_benchmark.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/timing.h"
#include "evaluation/metrics/statistics.h"
#include "pipeline/portrait/run_portrait.h"
#include "pipeline/segmentation/faces.h"
#include "pipeline/segmentation/network.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::Mode;

constexpr Mode kTimedModes[] = {Mode::dp, Mode::seg, Mode::dp_seg};
constexpr std::size_t kTimedModeCount = std::size(kTimedModes);
constexpr int kBestOf = 3;

/// Wall time of one run by stage; finding people is told apart as "faces" and "network".
using StageMs = std::map<std::string, double>;

double total_of(const StageMs& stages) {
  return std::accumulate(stages.begin(), stages.end(), 0.0,
                         [](double sum, const auto& stage) { return sum + stage.second; });
}

/// What the paper's rows are made of. Its totals are less than the sums of its rows.
struct PaperRow {
  const char* name;
  std::vector<std::string> stages;
  std::array<std::optional<double>, kTimedModeCount> paper_ms;
  std::optional<double> sigma_ms;
};

const std::vector<PaperRow>& paper_rows() {
  static const std::vector<PaperRow> rows = {
      {"face detection", {"faces"}, {143, 143, 143}, 46},
      {"person segmentation", {"network"}, {std::nullopt, 1612, 1612}, 729},
      {"burst", {"merge"}, {190, {}, 190}, 45},
      {"disparity", {"disparity", "flatten", "smooth", "upsample"}, {817, {}, 817}, 153},
      {"depth renderer", {"blur by disparity", "noise by disparity"}, {1241, {}, 1241}, 152},
      {"mask filtering", {"filter"}, {std::nullopt, 1048, {}}, 339},
      {"mask renderer", {"blur by mask", "noise by mask"}, {std::nullopt, 546, {}}, 67},
      {"not counted by the paper", {"demosaic", "display"}, {}, {}}};
  return rows;
}

/// The pipeline's stages under the names of paper_rows().
std::string row_stage(const std::string& stage, Mode mode) {
  const bool by_mask = mode == Mode::seg;
  if (stage == "blur" || stage == "noise") return stage + (by_mask ? " by mask" : " by disparity");
  if (stage == "mask") return by_mask ? "filter" : "flatten";
  return stage;
}

/// None where the mode needs people and finds nobody.
std::optional<StageMs> run(const Capture& capture, Mode mode, const std::string& matcher,
                           pipeline::PersonNetwork& network) {
  StageMs times;
  pipeline::PortraitOptions options = pipeline::default_options(matcher);
  options.mode = mode;
  options.find_people = [&](const Image& picture, const std::vector<pipeline::Face>&) {
    pipeline::FoundPeople found;
    times["faces"] = 1e3 * seconds([&] { found.detected = pipeline::find_faces(picture); });
    times["network"] = 1e3 * seconds([&] {
                         found.faces =
                             pipeline::seed_faces(found.detected, picture.width, picture.height, options.seed_faces);
                         if (!found.faces.empty()) found.mask = pipeline::person_mask(picture, found.faces, network);
                       });
    return found;
  };
  pipeline::PortraitResult result;
  try {
    result = pipeline::run_portrait(capture, options);
  } catch (const pipeline::NobodyFound&) {
    return {};
  }
  if (mode != Mode::dp && result.faces.empty()) return {};
  if (mode == Mode::dp) times["faces"] = 1e3 * seconds([&] { pipeline::find_faces(result.input); });
  for (const pipeline::StageTime& stage : result.stages) {
    if (stage.name != "people") times[row_stage(stage.name, mode)] += stage.ms;
  }
  return times;
}

std::optional<StageMs> best_run(const Capture& capture, Mode mode, const std::string& matcher,
                                pipeline::PersonNetwork& network) {
  std::optional<StageMs> best;
  for (int repeat = 0; repeat < kBestOf; ++repeat) {
    const std::optional<StageMs> times = run(capture, mode, matcher, network);
    if (!times) return {};
    if (!best || total_of(*times) < total_of(*best)) best = times;
  }
  return best;
}

std::optional<TimeSpread> spread_of(const std::vector<StageMs>& captures, const std::vector<std::string>& stages) {
  std::vector<double> sums;
  bool has_any = false;
  for (const StageMs& capture : captures) {
    double& sum = sums.emplace_back(0);
    for (const std::string& stage : stages) {
      const auto found = capture.find(stage);
      has_any = has_any || found != capture.end();
      if (found != capture.end()) sum += found->second;
    }
  }
  if (!has_any) return {};
  return TimeSpread{std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(sums.size()), deviation(sums),
                    sums.size()};
}

/// What the captures are, and whether they can be measured.
std::string check_captures(const std::vector<std::string>& captures) {
  std::vector<std::pair<std::int64_t, std::string>> sizes;
  for (const std::string& path : captures) {
    const Capture capture = read_capture(path, false);
    const bool has_views = !capture.frames.empty() && !capture.frames[0].left.data.empty();
    if (!has_views || capture.frames[0].mosaic.data.empty()) {
      throw InputError(printable(path) + ": has no views or no mosaic: both are needed");
    }
    const Camera& camera = capture.camera;
    sizes.emplace_back(std::int64_t{camera.width_px} * camera.height_px,
                       fmt::format("{} x {}, {} frames", camera.width_px, camera.height_px, capture.frames.size()));
  }
  const auto [least, most] = std::minmax_element(sizes.begin(), sizes.end());
  return least->second == most->second ? least->second : least->second + ", to " + most->second;
}

}  // namespace

PortraitBenchmark measure_portraits(const std::vector<std::string>& captures, const std::string& matcher,
                                    const std::function<void(double)>& progress) {
  pipeline::PersonNetwork network;
  PortraitBenchmark benchmark{
      .matcher = matcher,
      .sizes = check_captures(captures),
      .threads = static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism))};
  std::array<std::vector<StageMs>, kTimedModeCount> runs;
  for (const std::string& path : captures) {
    const Capture capture = read_capture(path, false);
    for (std::size_t column = 0; column < kTimedModeCount; ++column) {
      const std::optional<StageMs> best = best_run(capture, kTimedModes[column], matcher, network);
      if (!best) continue;
      runs[column].push_back(*best);
      std::optional<double>& peak = benchmark.peak_mb[column];
      peak = std::max(peak.value_or(0), peak_mb([&] { run(capture, kTimedModes[column], matcher, network); }));
    }
    ++benchmark.captures;
    if (progress) progress(static_cast<double>(benchmark.captures) / static_cast<double>(captures.size()));
  }
  benchmark.with_people = runs[1].size();
  std::vector<std::string> all;
  for (const PaperRow& paper : paper_rows()) {
    all.insert(all.end(), paper.stages.begin(), paper.stages.end());
    TableFourRow& row = benchmark.rows.emplace_back(TableFourRow{paper.name, {}, paper.paper_ms, paper.sigma_ms});
    for (std::size_t column = 0; column < kTimedModeCount; ++column)
      row.ours[column] = spread_of(runs[column], paper.stages);
  }
  TableFourRow& total = benchmark.rows.emplace_back(TableFourRow{"total", {}, {2134, 3343, 3854}, {}});
  for (std::size_t column = 0; column < kTimedModeCount; ++column) total.ours[column] = spread_of(runs[column], all);
  return benchmark;
}

nlohmann::ordered_json to_json(const PortraitBenchmark& benchmark) {
  nlohmann::ordered_json json = {{"format", "dualpixel-bench-portrait"},
                                 {"version", 1},
                                 {"matcher", benchmark.matcher},
                                 {"threads", benchmark.threads},
                                 {"sizes", benchmark.sizes},
                                 {"captures", benchmark.captures},
                                 {"with_people", benchmark.with_people},
                                 {"rows", nlohmann::ordered_json::array()}};
  for (const TableFourRow& row : benchmark.rows) {
    nlohmann::ordered_json modes;
    for (std::size_t column = 0; column < kTimedModeCount; ++column) {
      nlohmann::ordered_json& mode = modes[kTableFourModes[column]];
      mode = nlohmann::ordered_json::object();
      if (const auto& ours = row.ours[column]) {
        mode = {{"ms", ours->mean_ms}, {"captures", ours->captures}};
        if (ours->captures > 1) mode["sigma_ms"] = ours->sigma_ms;
      }
      if (row.paper_ms[column]) mode["paper_ms"] = *row.paper_ms[column];
    }
    json["rows"].push_back({{"name", row.name}, {"modes", modes}});
    if (row.paper_sigma_ms) json["rows"].back()["paper_sigma_ms"] = *row.paper_sigma_ms;
  }
  for (std::size_t column = 0; column < kTimedModeCount; ++column) {
    if (const auto peak = benchmark.peak_mb[column]) json["peak_mb"][kTableFourModes[column]] = *peak;
  }
  return json;
}

namespace {

std::string text_of(const TimeSpread& time) {
  return time.captures > 1 ? fmt::format("{:.1f} ± {:.1f}", time.mean_ms, time.sigma_ms)
                           : fmt::format("{:.1f}", time.mean_ms);
}

}  // namespace

std::string to_text(const PortraitBenchmark& benchmark) {
  std::string text = fmt::format(
      "{} capture{} ({}), people found in {}; matcher {}, {} threads. Wall ms, mean ± σ; the paper's are of 5.4 "
      "megapixels, on a phone with eight cores\n{:<26}",
      benchmark.captures, benchmark.captures == 1 ? "" : "s", benchmark.sizes, benchmark.with_people, benchmark.matcher,
      benchmark.threads, "");
  for (const char* mode : kTableFourModes) text += fmt::format("{:>15}{:>8}", mode, "paper");
  text += fmt::format("{:>9}\n", "paper σ");
  for (const TableFourRow& row : benchmark.rows) {
    text += fmt::format("{:<26}", row.name);
    for (std::size_t column = 0; column < kTimedModeCount; ++column) {
      const auto& ours = row.ours[column];
      text += fmt::format("{:>15}", ours ? text_of(*ours) : "-");
      text += fmt::format("{:>8}", row.paper_ms[column] ? fmt::format("{:.0f}", *row.paper_ms[column]) : "-");
    }
    text += fmt::format("{:>9}\n", row.paper_sigma_ms ? fmt::format("{:.0f}", *row.paper_sigma_ms) : "-");
  }
  text += fmt::format("{:<26}", "peak memory, MB");
  for (const auto& peak : benchmark.peak_mb) {
    text += fmt::format("{:>15}{:>8}", peak ? fmt::format("{:.0f}", *peak) : "-", "");
  }
  return text + "\n";
}

}  // namespace dualpixel::evaluation
