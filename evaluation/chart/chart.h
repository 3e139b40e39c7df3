#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Speed against accuracy, stage by stage: the page of `dualpixel chart`, the JSON beside it, and what has changed
/// since an older one.
namespace dualpixel::evaluation {

/// A mean over repetitions with its standard error; none where it was measured once.
struct Measured {
  double value = 0;
  std::optional<double> standard_error = {};
};

/// One setting of a stage. Smaller is better in both.
struct ChartPoint {
  std::string name;
  Measured error, time;
  bool is_default = false;
  std::optional<double> memory_mb = {};  ///< at most, besides what the program held before
  bool is_bound = false;                 ///< no setting: a part of the work done alone; never on the front
};

struct ChartSection {
  std::string title;
  std::string note;  ///< what was measured on what, and what repetitions are
  std::string error_unit, time_unit;
  std::vector<ChartPoint> points;
  std::string stage = {};           ///< of chart_stages() that measured it
  std::string default_reason = {};  ///< why the default is what it is
  std::vector<int> seeds = {};      ///< of the repetitions; none where nothing was drawn, or all is the scenes' own
};

/// A whole by its parts, one bar. A part below 0 takes from the others.
struct ChartBar {
  std::string title;
  std::string note;
  std::string unit;
  std::vector<std::pair<std::string, double>> parts;
  std::string stage = {};
};

/// What a cost grows with, on axes of decades.
struct ChartGrowth {
  std::string title;
  std::string note;
  std::string x_label, y_label;  ///< with units
  std::vector<std::pair<std::string, std::vector<std::pair<double, double>>>> lines;
  std::string stage = {};
};

/// What one stage has measured.
struct ChartPart {
  std::vector<ChartSection> sections;
  std::vector<ChartBar> bars = {};
  std::vector<ChartGrowth> growths = {};
  std::vector<std::string> left_out = {};  ///< what it could not measure here, and why
};

struct Chart {
  bool quick = false;
  std::string version;    ///< of the program
  std::string libraries;  ///< names and versions, as they were compiled with
  std::string machine;    ///< processor and threads
  std::vector<ChartSection> sections = {};
  std::vector<std::string> left_out = {};  ///< what a reader may miss, and why
  bool complete = false;
  std::vector<ChartBar> bars = {};
  std::vector<ChartGrowth> growths = {};
};

bool has_stage(const Chart& chart, const std::string& stage);
void add(Chart& chart, ChartPart part, const std::string& stage);

/// Whether no other setting has both less error and less time, one of them strictly; in the points' order.
std::vector<bool> pareto_front(const std::vector<ChartPoint>& points);

/// What more time buys: each point of the front, fastest first, with the next one.
struct FrontStep {
  std::string from, to;
  double more_time = 0, less_error = 0;
};
std::vector<FrontStep> front_steps(const std::vector<ChartPoint>& points);

/// The mean of repetitions, with its standard error where there are two or more.
Measured mean_of(const std::vector<double>& repetitions);

nlohmann::ordered_json to_json(const Chart& chart);
/// Whether this is a chart's JSON as other releases of the program write it.
bool is_of_other_version(const nlohmann::json& json);
/// Throws InputError that names `file`.
Chart read_chart(const nlohmann::json& json, const std::string& file);

/// A figure of one setting that differs from an older chart's by more than noise explains.
struct ChartChange {
  std::string section, point, figure;  ///< figure: "error" or "time"
  double before = 0, now = 0;
  bool worse() const { return now > before; }
};

struct ChartComparison {
  std::vector<ChartChange> changes;                ///< what got worse first
  std::vector<std::string> only_before, only_now;  ///< settings, as "section, setting"
};

/// Noise: three standard errors of the difference, where both have them. Time counts from 10 % on, error from 1 %,
/// since machines vary and rounding does. Of a section in other units, all settings are other ones.
ChartComparison compare(const Chart& before, const Chart& now);

/// One line a change, or a setting that only one of them has.
std::string to_text(const ChartComparison& comparison);

/// `since`: what has changed since an older chart, where one was given.
std::string to_page(const Chart& chart, const std::optional<ChartComparison>& since = {});

}  // namespace dualpixel::evaluation
