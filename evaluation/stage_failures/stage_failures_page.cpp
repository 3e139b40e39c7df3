#include <fmt/format.h>

#include <algorithm>

#include "evaluation/report/failure_style.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"
#include "evaluation/stage_failures/stage_failures.h"

namespace dualpixel::evaluation {
namespace {

/// From red, broken at the first step, to green, never.
std::string break_cell(const StageSweep& sweep) {
  constexpr std::size_t kShades = 6;
  const auto& [step, low, high] = sweep.breaks;
  const std::size_t shade = (kShades - 1) * step / std::max<std::size_t>(sweep.steps.size(), 1);
  std::string text = sweep.value_at(step);
  if (low != high) {
    text += fmt::format(" <span class=\"soft\">{} … {}</span>", sweep.value_at(low), sweep.value_at(high));
  }
  return fmt::format("<td class=\"s{}\"><a href=\"#{}\">{}</a></td>", shade, escape_name(sweep.row.name), text);
}

std::string overview(const std::vector<StageSweep>& sweeps) {
  std::string html =
      "<div class=\"scroll\"><table class=\"atlas\"><thead><tr><td>stage</td><td>failure</td><td>swept</td>"
      "<td>breaks at</td><td>broken</td></tr></thead><tbody>\n";
  for (const StageSweep& sweep : sweeps) {
    const StageRow& row = sweep.row;
    html += fmt::format(
        "<tr><td>{}</td><td>{}<br><span class=\"soft\">{}</span></td><td>{}, {} … {}</td>{}<td>{} {} {:g}</td></tr>\n",
        escape_html(row.stage), escape_html(row.title), escape_html(row.name), escape_html(row.sweep),
        sweep.value_at(0), sweep.value_at(sweep.steps.size() - 1), break_cell(sweep), escape_html(row.figure),
        row.falls ? "&lt;" : "&gt;", row.limit);
  }
  return html + "</tbody></table></div>\n";
}

std::string strip_of(const StageSweep& sweep) {
  std::string values = "<tr><th>" + escape_html(sweep.row.sweep) + "</th>", pictures = "<tr><th>result</th>";
  for (std::size_t i = 0; i < sweep.steps.size(); ++i) {
    const StageStep& step = sweep.steps[i];
    values += fmt::format("<th>{:g}</th>", step.value);
    pictures += fmt::format("<td{}><img src=\"{}\" alt=\"{:g}\"></td>",
                            i >= sweep.breaks.step ? " class=\"broken\"" : "", step.picture_uri, step.value);
  }
  return "<div class=\"scroll\"><table class=\"strips\">" + values + "</tr>\n" + pictures + "</tr>\n</table></div>\n";
}

std::string curve_of(const StageSweep& sweep) {
  const StageRow& row = sweep.row;
  Plot plot;
  plot.title = row.title;
  plot.x_label = row.sweep;
  plot.y_label = row.figure;
  plot.log_x = row.log;
  Series mean{"mean", {}}, low{"lowest draw", {}, true}, high{"highest draw", {}, true}, limit{"broken", {}, true};
  for (const StageStep& step : sweep.steps) {
    mean.points.emplace_back(step.value, step.figure);
    low.points.emplace_back(step.value, step.low);
    high.points.emplace_back(step.value, step.high);
    limit.points.emplace_back(step.value, row.limit);
  }
  plot.series = {mean, limit};
  const bool draws_differ =
      std::any_of(sweep.steps.begin(), sweep.steps.end(), [](const StageStep& s) { return s.low < s.high; });
  if (draws_differ) plot.series.insert(plot.series.end(), {low, high});
  return html_plots({plot});
}

}  // namespace

std::string to_page(const std::vector<StageSweep>& sweeps, unsigned draws) {
  const std::string title = "How the stages before and after matching fail";
  std::string body = fmt::format(
      "<h1>{}</h1>\n<p>Each row makes one thing worse, step by step, for one stage of the pipeline. A cell names the "
      "first step at which the row's figure, the mean of {} draw{}, lies beyond the limit beside it, from red (at "
      "once) "
      "to green (never); in gray, where single draws differ, the first and the last of theirs. Under a failure stands "
      "its name for --row. A click leads to "
      "curves and pictures.</p>\n",
      title, draws, draws == 1 ? "" : "s");
  body += overview(sweeps);
  for (const StageSweep& sweep : sweeps) {
    const StageRow& row = sweep.row;
    body += fmt::format("<h2 id=\"{}\">{}</h2>\n<p>{} {}</p>\n", escape_name(row.name), escape_html(row.title),
                        escape_html(row.note), "Broken: " + escape_html(row.reason));
    body += strip_of(sweep) + curve_of(sweep);
  }
  return html_page(title, body, kFailureStyle);
}

}  // namespace dualpixel::evaluation
