#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "capture/error.h"
#include "evaluation/chart/chart.h"
#include "evaluation/report/bar.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();

/// Whether a logarithmic axis shows more than a linear one would.
bool spans_decades(const std::vector<ChartPoint>& points, Measured ChartPoint::*of) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const ChartPoint& point : points) {
    low = std::min(low, (point.*of).value);
    high = std::max(high, (point.*of).value);
  }
  return high > 4 * low && low > 0;
}

/// The front and the default bear their names, others show theirs under the pointer; the table below holds all.
Plot plot_of(const ChartSection& section) {
  const std::vector<bool> front = pareto_front(section.points);
  Plot plot;
  plot.title = section.title;
  plot.x_label = "time, " + section.time_unit;
  plot.y_label = "error, " + section.error_unit;
  plot.wide = true;
  plot.log_x = spans_decades(section.points, &ChartPoint::time);
  plot.log_y = spans_decades(section.points, &ChartPoint::error);
  Series others{"others", {}, false, true}, best{"Pareto front", {}, false, true}, chosen{"default", {}, false, true},
      bounds{"bound", {}, false, true};
  Series line{"", {}}, errors{"± one standard error", {}};
  std::vector<std::pair<double, double>> front_points;
  for (std::size_t i = 0; i < section.points.size(); ++i) {
    const ChartPoint& point = section.points[i];
    Series& dots = point.is_bound ? bounds : point.is_default ? chosen : front[i] ? best : others;
    dots.points.emplace_back(point.time.value, point.error.value);
    dots.labels.push_back(point.name);
    if (front[i]) front_points.emplace_back(point.time.value, point.error.value);
    if (point.error.standard_error) {
      const double half = *point.error.standard_error;
      for (const double end : {point.error.value - half, point.error.value + half}) {
        errors.points.emplace_back(point.time.value, end);
      }
      errors.points.emplace_back(kGap, kGap);
    }
  }
  best.write_labels = chosen.write_labels = true;
  std::sort(front_points.begin(), front_points.end());
  line.points = front_points;
  line.dashed = true;
  plot.series = {best, chosen, others, errors, line, bounds};
  plot.series.erase(std::remove_if(plot.series.begin(), plot.series.end(),
                                   [](const Series& series) { return series.points.empty(); }),
                    plot.series.end());
  return plot;
}

std::string text_of(const Measured& measured) {
  if (!measured.standard_error) return fmt::format("{:.4g}", measured.value);
  return fmt::format("{:.4g} ± {:.2g}", measured.value, *measured.standard_error);
}

Table table_of(const ChartSection& section) {
  const std::vector<bool> front = pareto_front(section.points);
  const bool memory = std::any_of(section.points.begin(), section.points.end(),
                                  [](const ChartPoint& point) { return point.memory_mb.has_value(); });
  Table table{{"setting", "error, " + section.error_unit, "time, " + section.time_unit, "on the front", "default"}, {}};
  if (memory) table.header.push_back("memory, MB");
  for (std::size_t i = 0; i < section.points.size(); ++i) {
    const ChartPoint& point = section.points[i];
    table.rows.push_back(
        {point.name, text_of(point.error), text_of(point.time), front[i] ? "yes" : "", point.is_default ? "yes" : ""});
    if (memory) table.rows.back().push_back(cell_of(point.memory_mb, 0));
  }
  return table;
}

std::string paragraph(const std::string& text) {
  return text.empty() ? "" : "<p class=\"soft\">" + escape_html(printable(text, 1000)) + "</p>\n";
}

std::string heading(const std::string& title, const std::string& note) {
  return "<h2>" + escape_name(title) + "</h2>\n" + paragraph(note);
}

/// Nothing where the front is a single point.
std::string steps_of(const ChartSection& section) {
  const std::vector<FrontStep> steps = front_steps(section.points);
  if (steps.empty()) return "";
  Table table{{"from", "to", "more time, " + section.time_unit, "less error, " + section.error_unit,
               fmt::format("error saved per {}", section.time_unit)},
              {}};
  for (const FrontStep& step : steps) {
    table.rows.push_back({step.from, step.to, fmt::format("{:.3g}", step.more_time),
                          fmt::format("{:.3g}", step.less_error),
                          step.more_time > 0 ? fmt::format("{:.2g}", step.less_error / step.more_time) : "–"});
  }
  return html_table(table);
}

/// Plot, reason of the default, table, and what more time buys, but where that stands on top.
std::string html_section(const ChartSection& section, bool is_first) {
  std::string html = heading(section.title, section.note) + html_plots({plot_of(section)});
  if (!section.default_reason.empty()) html += paragraph("Default: " + section.default_reason);
  html += html_table(table_of(section));
  const std::string steps = steps_of(section);
  if (!steps.empty() && !is_first) {
    html += "<details><summary>What more time buys, along the front</summary>" + steps + "</details>\n";
  }
  return html;
}

std::string changes_section(const ChartComparison& since) {
  std::string html = heading("Since the older chart", "");
  Table table{{"setting", "figure", "was", "is", "change, %"}, {}};
  for (const ChartChange& change : since.changes) {
    const double percent = change.before != 0 ? 100 * (change.now / change.before - 1) : kGap;
    table.rows.push_back({change.section + ", " + change.point,
                          fmt::format("{}, {}", change.figure, change.worse() ? "worse" : "better"),
                          fmt::format("{:.4g}", change.before), fmt::format("{:.4g}", change.now),
                          cell_of(percent, 1)});
  }
  html += table.rows.empty() ? paragraph("Nothing changed by more than noise.") : html_table(table);
  for (const auto& [what, settings] : {std::pair{"Gone", &since.only_before}, std::pair{"New", &since.only_now}}) {
    if (settings->empty()) continue;
    html += paragraph(fmt::format("{}:", what)) + "<ul>";
    for (const std::string& setting : *settings) html += "<li>" + escape_name(setting) + "</li>";
    html += "</ul>\n";
  }
  return html;
}

std::string growth_section(const ChartGrowth& growth) {
  Plot plot{growth.title, growth.x_label, growth.y_label, {}, true, true, false, true};
  for (const auto& [name, points] : growth.lines) plot.series.push_back({name, points, false, points.size() == 1});
  return heading(growth.title, growth.note) + html_plots({plot});
}

}  // namespace

std::string to_page(const Chart& chart, const std::optional<ChartComparison>& since) {
  std::string body = fmt::format(
      "<h1>Speed against accuracy</h1>\n<p>{}{}; dualpixel {} ({}). To the left and down is better; a setting on the "
      "Pareto "
      "front has no other that is both faster and more accurate.</p>\n",
      escape_name(chart.machine), chart.quick ? ", in short" : "", escape_name(chart.version),
      escape_html(printable(chart.libraries, 1000)));
  if (!chart.complete) body += paragraph("Not all of it is measured yet: the same command goes on where it stopped.");
  if (since) body += changes_section(*since);
  for (const ChartBar& bar : chart.bars) {
    body += heading(bar.title, bar.note) + "<div class=\"plots wide-plot\">" +
            svg_bar({bar.title, bar.unit, bar.parts}) + "</div>\n";
  }
  if (!chart.sections.empty()) {  // the whole pipeline comes first
    const std::string steps = steps_of(chart.sections.front());
    if (!steps.empty()) body += heading("What more time buys: " + chart.sections.front().title, "") + steps;
  }
  for (const ChartSection& section : chart.sections) body += html_section(section, &section == &chart.sections.front());
  for (const ChartGrowth& growth : chart.growths) body += growth_section(growth);
  if (!chart.left_out.empty()) {
    body += "<h2>Not on this page</h2>\n<ul>";
    for (const std::string& line : chart.left_out) body += "<li>" + escape_html(printable(line, 1000)) + "</li>";
    body += "</ul>\n";
  }
  return html_page("Speed against accuracy", body);
}

}  // namespace dualpixel::evaluation
