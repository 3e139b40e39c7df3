#include "evaluation/chart/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/error.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "dualpixel-chart";
constexpr int kVersion = 5;
constexpr double kLeastTimeChange = 0.10, kLeastErrorChange = 0.01;
constexpr double kStandardErrors = 3;

Json json_of(const Measured& measured) {
  Json json = {{"value", measured.value}};
  if (measured.standard_error) json["standard_error"] = *measured.standard_error;
  return json;
}

Measured measured_of(const nlohmann::json& json) {
  Measured measured{json.at("value").get<double>()};
  if (json.contains("standard_error")) measured.standard_error = json["standard_error"].get<double>();
  return measured;
}

bool differs(const Measured& before, const Measured& now, double least) {
  const double change = std::abs(now.value - before.value);
  const double noise = std::hypot(before.standard_error.value_or(0), now.standard_error.value_or(0));
  return change > least * std::abs(before.value) && change > kStandardErrors * noise;
}

Json json_of(const std::vector<std::pair<double, double>>& points) {
  Json json = Json::array();
  for (const auto& [x, y] : points) json.push_back({x, y});
  return json;
}

Json json_of(const ChartSection& section) {
  Json points = Json::array();
  for (const ChartPoint& point : section.points) {
    points.push_back({{"name", point.name}, {"error", json_of(point.error)}, {"time", json_of(point.time)}});
    if (point.is_default) points.back()["default"] = true;
    if (point.memory_mb) points.back()["memory_mb"] = *point.memory_mb;
    if (point.is_bound) points.back()["bound"] = true;
  }
  return {{"title", section.title},         {"stage", section.stage},
          {"note", section.note},           {"default_reason", section.default_reason},
          {"seeds", section.seeds},         {"error_unit", section.error_unit},
          {"time_unit", section.time_unit}, {"points", points}};
}

Json json_of(const ChartBar& bar) {
  Json parts = Json::array();
  for (const auto& [name, value] : bar.parts) parts.push_back({{"name", name}, {"value", value}});
  return {{"title", bar.title}, {"stage", bar.stage}, {"note", bar.note}, {"unit", bar.unit}, {"parts", parts}};
}

Json json_of(const ChartGrowth& growth) {
  Json lines = Json::array();
  for (const auto& [name, points] : growth.lines) lines.push_back({{"name", name}, {"points", json_of(points)}});
  return {{"title", growth.title},     {"stage", growth.stage},     {"note", growth.note},
          {"x_label", growth.x_label}, {"y_label", growth.y_label}, {"lines", lines}};
}

ChartSection section_of(const nlohmann::json& json) {
  ChartSection section{json.at("title"), json.at("note"),           json.at("error_unit"), json.at("time_unit"), {},
                       json.at("stage"), json.at("default_reason"), json.at("seeds")};
  for (const nlohmann::json& point : json.at("points")) {
    ChartPoint& read =
        section.points.emplace_back(ChartPoint{point.at("name"), measured_of(point.at("error")),
                                               measured_of(point.at("time")), point.value("default", false)});
    if (point.contains("memory_mb")) read.memory_mb = point["memory_mb"].get<double>();
    read.is_bound = point.value("bound", false);
  }
  return section;
}

ChartBar bar_of(const nlohmann::json& json) {
  ChartBar bar{json.at("title"), json.at("note"), json.at("unit"), {}, json.at("stage")};
  for (const nlohmann::json& part : json.at("parts")) bar.parts.emplace_back(part.at("name"), part.at("value"));
  return bar;
}

ChartGrowth growth_of(const nlohmann::json& json) {
  ChartGrowth growth{json.at("title"), json.at("note"), json.at("x_label"), json.at("y_label"), {}, json.at("stage")};
  for (const nlohmann::json& line : json.at("lines")) {
    auto& points = growth.lines.emplace_back(line.at("name"), std::vector<std::pair<double, double>>{}).second;
    for (const nlohmann::json& point : line.at("points")) points.emplace_back(point.at(0), point.at(1));
  }
  return growth;
}

template <typename Entry>
const Entry* find_by(const std::vector<Entry>& entries, std::string Entry::*name, const std::string& wanted) {
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) { return entry.*name == wanted; });
  return found != entries.end() ? &*found : nullptr;
}

/// A setting of a section of the same title and units; nullptr: there is none.
const ChartPoint* find_point(const Chart& chart, const ChartSection& wanted, const std::string& name) {
  const ChartSection* section = find_by(chart.sections, &ChartSection::title, wanted.title);
  const bool comparable = section && section->error_unit == wanted.error_unit && section->time_unit == wanted.time_unit;
  return comparable ? find_by(section->points, &ChartPoint::name, name) : nullptr;
}

}  // namespace

std::vector<bool> pareto_front(const std::vector<ChartPoint>& points) {
  std::vector<bool> front;
  for (const ChartPoint& point : points) {
    const auto beats = [&](const ChartPoint& other) {
      const bool no_worse = other.error.value <= point.error.value && other.time.value <= point.time.value;
      const bool better = other.error.value < point.error.value || other.time.value < point.time.value;
      return !other.is_bound && no_worse && better;
    };
    front.push_back(!point.is_bound && std::none_of(points.begin(), points.end(), beats));
  }
  return front;
}

Measured mean_of(const std::vector<double>& repetitions) {
  const auto n = static_cast<double>(repetitions.size());
  const double mean = std::accumulate(repetitions.begin(), repetitions.end(), 0.0) / n;
  if (repetitions.size() < 2) return {mean};
  double squares = 0;
  for (const double value : repetitions) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (n - 1) / n)};
}

bool has_stage(const Chart& chart, const std::string& stage) {
  const auto has = [&](const auto& entries) {
    return std::any_of(entries.begin(), entries.end(), [&](const auto& entry) { return entry.stage == stage; });
  };
  return has(chart.sections) || has(chart.bars) || has(chart.growths);
}

void add(Chart& chart, ChartPart part, const std::string& stage) {
  const auto append = [&](auto& to, auto& from) {
    for (auto& entry : from) {
      entry.stage = stage;
      to.push_back(std::move(entry));
    }
  };
  append(chart.sections, part.sections);
  append(chart.bars, part.bars);
  append(chart.growths, part.growths);
  for (const std::string& line : part.left_out) {
    const bool is_new = std::find(chart.left_out.begin(), chart.left_out.end(), line) == chart.left_out.end();
    if (is_new) chart.left_out.push_back(line);  // a stage that measured nothing is tried again by a resumed run
  }
}

std::vector<FrontStep> front_steps(const std::vector<ChartPoint>& points) {
  const std::vector<bool> on_front = pareto_front(points);
  std::vector<const ChartPoint*> front;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (on_front[i]) front.push_back(&points[i]);
  }
  std::stable_sort(front.begin(), front.end(),
                   [](const ChartPoint* a, const ChartPoint* b) { return a->time.value < b->time.value; });
  std::vector<FrontStep> steps;
  for (std::size_t i = 1; i < front.size(); ++i) {
    const ChartPoint &from = *front[i - 1], &to = *front[i];
    steps.push_back({from.name, to.name, to.time.value - from.time.value, from.error.value - to.error.value});
  }
  return steps;
}

Json to_json(const Chart& chart) {
  Json json = {{"format", kFormat},          {"version", kVersion},
               {"program", chart.version},   {"libraries", chart.libraries},
               {"machine", chart.machine},   {"quick", chart.quick},
               {"complete", chart.complete}, {"sections", Json::array()},
               {"bars", Json::array()},      {"growths", Json::array()},
               {"left_out", chart.left_out}};
  for (const ChartSection& section : chart.sections) json["sections"].push_back(json_of(section));
  for (const ChartBar& bar : chart.bars) json["bars"].push_back(json_of(bar));
  for (const ChartGrowth& growth : chart.growths) json["growths"].push_back(json_of(growth));
  return json;
}

bool is_of_other_version(const nlohmann::json& json) {
  return json.is_object() && json.contains("format") && json["format"] == kFormat && json.contains("version") &&
         json["version"] != kVersion;
}

Chart read_chart(const nlohmann::json& json, const std::string& file) {
  try {
    if (json.at("format") != kFormat || json.at("version") != kVersion) {
      throw InputError(fmt::format("{}: /format, /version: must be \"{}\" and {}; measure it anew by 'dualpixel chart'",
                                   printable(file), kFormat, kVersion));
    }
    Chart chart{json.at("quick"),    json.at("program"), json.at("libraries"), json.at("machine"), {},
                json.at("left_out"), json.at("complete")};
    for (const nlohmann::json& section : json.at("sections")) chart.sections.push_back(section_of(section));
    for (const nlohmann::json& bar : json.at("bars")) chart.bars.push_back(bar_of(bar));
    for (const nlohmann::json& growth : json.at("growths")) chart.growths.push_back(growth_of(growth));
    return chart;
  } catch (const nlohmann::json::exception&) {
    throw InputError(printable(file) + ": is not what 'dualpixel chart' writes beside its page");
  }
}

ChartComparison compare(const Chart& before, const Chart& now) {
  ChartComparison comparison;
  const auto list_missing = [](const Chart& from, const Chart& other, std::vector<std::string>& list) {
    for (const ChartSection& section : from.sections) {
      for (const ChartPoint& point : section.points) {
        if (!find_point(other, section, point.name)) list.push_back(section.title + ", " + point.name);
      }
    }
  };
  list_missing(before, now, comparison.only_before);
  list_missing(now, before, comparison.only_now);
  for (const ChartSection& section : now.sections) {
    for (const ChartPoint& point : section.points) {
      const ChartPoint* old = find_point(before, section, point.name);
      if (!old) continue;
      const auto add = [&](const char* figure, Measured ChartPoint::*of, double least) {
        if (differs(old->*of, point.*of, least)) {
          comparison.changes.push_back({section.title, point.name, figure, (old->*of).value, (point.*of).value});
        }
      };
      add("error", &ChartPoint::error, kLeastErrorChange);
      add("time", &ChartPoint::time, kLeastTimeChange);
    }
  }
  std::stable_partition(comparison.changes.begin(), comparison.changes.end(),
                        [](const ChartChange& change) { return change.worse(); });
  return comparison;
}

std::string to_text(const ChartComparison& comparison) {
  std::string text = comparison.changes.empty() ? "nothing changed by more than noise\n" : "";
  for (const ChartChange& change : comparison.changes) {
    const std::string share =
        change.before != 0 ? fmt::format(" ({:+.1f} %)", 100 * (change.now / change.before - 1)) : "";
    text += fmt::format("{:<6} {}, {}: {} {:.4g}, was {:.4g}{}\n", change.worse() ? "worse" : "better",
                        printable(change.section), printable(change.point), change.figure, change.now, change.before,
                        share);
  }
  for (const std::string& setting : comparison.only_before) text += "gone   " + printable(setting) + "\n";
  for (const std::string& setting : comparison.only_now) text += "new    " + printable(setting) + "\n";
  return text;
}

}  // namespace dualpixel::evaluation
