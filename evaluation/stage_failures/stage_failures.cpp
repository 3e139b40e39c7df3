#include "evaluation/stage_failures/stage_failures.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/names.h"
#include "evaluation/report/report_images.h"

namespace dualpixel::evaluation {
namespace {

/// Also where the figure is not a number.
bool is_broken(const StageRow& row, double figure) {
  return row.falls ? !(figure >= row.limit) : !(figure <= row.limit);
}

std::size_t first_broken(const StageRow& row, const std::vector<double>& figures) {
  const auto found = std::find_if(figures.begin(), figures.end(), [&](double f) { return is_broken(row, f); });
  return static_cast<std::size_t>(found - figures.begin());
}

}  // namespace

std::vector<StageRow> stage_rows() {
  std::vector<StageRow> all;
  for (const auto& rows : {burst_rows(), calibration_rows(), edge_rows(), people_rows(), defocus_rows()}) {
    all.insert(all.end(), rows.begin(), rows.end());
  }
  return all;
}

std::vector<StageRow> stage_rows_named(const std::vector<std::string>& names) {
  std::vector<StageRow> all = stage_rows();
  if (names.empty()) return all;
  std::vector<std::string> known;
  for (const StageRow& row : all) {
    if (known.empty() || std::find(known.begin(), known.end(), row.stage) == known.end()) known.push_back(row.stage);
  }
  for (const StageRow& row : all) known.push_back(row.name);
  for (const std::string& name : names) {
    if (name == "people" && people_rows().empty()) throw InputError("--row people: this build has no person network");
    if (std::find(known.begin(), known.end(), name) == known.end()) refuse_name("--row", name, known);
  }
  std::vector<StageRow> chosen;
  std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [&](const StageRow& row) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return name == row.name || name == row.stage; });
  });
  return chosen;
}

StageSweep measure_stage_row(const StageRow& row, unsigned draws, const std::function<void(double)>& progress) {
  StageSweep sweep{row, {}, {}};
  std::vector<std::vector<double>> figures(draws);  // of each draw, step by step
  for (const double value : row.values) {
    StageStep& step = sweep.steps.emplace_back();
    step.value = value;
    for (unsigned draw = 0; draw < draws; ++draw) {
      const StageOutcome outcome = row.make(value, draw);
      figures[draw].push_back(outcome.figure);
      step.figure += outcome.figure / draws;
      step.low = draw == 0 ? outcome.figure : std::min(step.low, outcome.figure);
      step.high = draw == 0 ? outcome.figure : std::max(step.high, outcome.figure);
      if (draw == 0) step.picture_uri = jpeg_data_uri(outcome.picture_srgb);
      if (progress) {
        const auto done = static_cast<double>(sweep.steps.size() - 1) + (draw + 1.0) / draws;
        progress(done / static_cast<double>(row.values.size()));
      }
    }
  }
  std::vector<double> means;
  for (const StageStep& step : sweep.steps) means.push_back(step.figure);
  sweep.breaks = {first_broken(row, means), means.size(), 0};
  for (const std::vector<double>& of_draw : figures) {
    sweep.breaks.low = std::min(sweep.breaks.low, first_broken(row, of_draw));
    sweep.breaks.high = std::max(sweep.breaks.high, first_broken(row, of_draw));
  }
  return sweep;
}

std::string StageSweep::value_at(std::size_t step) const {
  return step < steps.size() ? fmt::format("{:g}", steps[step].value) : "never";
}

nlohmann::ordered_json to_json(const std::vector<StageSweep>& sweeps, unsigned draws) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const StageSweep& sweep : sweeps) {
    const StageRow& row = sweep.row;
    const auto& [step, low, high] = sweep.breaks;
    nlohmann::ordered_json json = {{"stage", row.stage},
                                   {"name", row.name},
                                   {"title", row.title},
                                   {"sweep", row.sweep},
                                   {"key", row.key},
                                   {"figure", row.figure},
                                   {row.falls ? "broken_below" : "broken_above", row.limit},
                                   {"reason", row.reason},
                                   {"note", row.note},
                                   {"breaks_at", sweep.value_at(step)},
                                   {"breaks_at_of_draws", {sweep.value_at(low), sweep.value_at(high)}}};
    for (const StageStep& s : sweep.steps) {
      json["steps"].push_back({{row.key, s.value}, {"figure", s.figure}, {"lowest", s.low}, {"highest", s.high}});
    }
    rows.push_back(json);
  }
  return {{"format", "dualpixel-experiment-stages"}, {"version", 1}, {"draws", draws}, {"rows", rows}};
}

}  // namespace dualpixel::evaluation
