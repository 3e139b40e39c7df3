#include <fmt/format.h>

#include <algorithm>

#include "evaluation/failures/failure_atlas.h"
#include "evaluation/report/failure_style.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kOverconfident = 0.01;  // more of a picture is marked

using Figure = std::optional<double> FailureFigures::*;

Series curve(const FailureSweep& sweep, std::size_t method, const std::string& name, Figure figure, bool dashed) {
  Series series{name, {}, dashed, false};
  for (const FailureStep& step : sweep.steps) {
    if (const auto value = step.methods[method].*figure) series.points.emplace_back(step.value, *value);
  }
  return series;
}

std::string plots(const FailureSweep& sweep) {
  Plot wrong, trusted, sigma;
  wrong.title = "Wrong by > 0.5 px (dashed: and trusted)";
  trusted.title = "Trusted (dashed: mean confidence)";
  sigma.title = "Error that 68 % stay under (dashed: predicted)";
  wrong.y_label = trusted.y_label = "share of pixels";
  sigma.y_label = "DP px";
  sigma.log_y = true;
  for (std::size_t m = 0; m < sweep.methods.size(); ++m) {
    const std::string& name = sweep.methods[m];
    Series& line = wrong.series.emplace_back(Series{name, {}, false, false});
    for (const FailureStep& step : sweep.steps) line.points.emplace_back(step.value, step.methods[m].wrong);
    wrong.series.push_back(curve(sweep, m, name + ", and trusted", &FailureFigures::overconfident, true));
    trusted.series.push_back(curve(sweep, m, name, &FailureFigures::trusted, false));
    trusted.series.push_back(curve(sweep, m, name + ", confidence", &FailureFigures::confidence, true));
    sigma.series.push_back(curve(sweep, m, name, &FailureFigures::error_68_dp_px, false));
    sigma.series.push_back(curve(sweep, m, name + ", predicted", &FailureFigures::sigma_dp_px, true));
  }
  for (Plot* plot : {&wrong, &trusted, &sigma}) {
    std::erase_if(plot->series, [](const Series& series) { return series.points.empty(); });
    plot->x_label = sweep.sweep, plot->log_x = sweep.log;
  }
  return html_plots({wrong, trusted, sigma});
}

/// One line of pictures, from harmless to hopeless; those that are broken have a red edge.
std::string strip(const std::string& name, const FailureSweep& sweep, std::size_t first_broken,
                  const std::function<const std::string&(const FailureStep&)>& uri) {
  std::string html = "<tr><th>" + name + "</th>";
  for (std::size_t i = 0; i < sweep.steps.size(); ++i) {
    html += fmt::format("<td{}><img src=\"{}\" alt=\"{:g}\"></td>", i >= first_broken ? " class=\"broken\"" : "",
                        uri(sweep.steps[i]), sweep.steps[i].value);
  }
  return html + "</tr>\n";
}

std::string id_of(const FailureSweep& sweep, std::size_t method) {
  return escape_name(sweep.name + "-" + sweep.methods[method]);
}

std::string strips(const FailureSweep& sweep) {
  std::string html = "<div class=\"scroll\"><table class=\"strips\"><tr><th>" + escape_html(sweep.sweep) + "</th>";
  for (const FailureStep& step : sweep.steps) html += fmt::format("<th>{:g}</th>", step.value);
  html += "</tr>\n" + strip("left view", sweep, sweep.steps.size(),
                            [](const FailureStep& step) -> const std::string& { return step.view_uri; });
  html += strip("true disparity", sweep, sweep.steps.size(),
                [](const FailureStep& step) -> const std::string& { return step.truth_uri; });
  for (std::size_t m = 0; m < sweep.methods.size(); ++m) {
    html +=
        strip(fmt::format("<span id=\"{}\">{}</span>", id_of(sweep, m), escape_name(sweep.methods[m])), sweep,
              sweep.breaks[m].step, [m](const FailureStep& step) -> const std::string& { return step.found_uris[m]; });
  }
  return html + "</table></div>\n" +
         fmt::format(
             "<p class=\"soft\">Disparity from −{0:.3g} (blue) to {0:.3g} DP px (orange); a red edge: more than a "
             "tenth is wrong.</p>\n",
             sweep.limit_dp_px);
}

std::string figure_table(const FailureSweep& sweep) {
  constexpr struct {
    const char* name;
    Figure figure;
    int decimals;
  } kColumns[] = {{"RMSE, px", &FailureFigures::rmse_dp_px, 3},
                  {"trusted", &FailureFigures::trusted, 3},
                  {"wrong and trusted", &FailureFigures::overconfident, 4},
                  {"sigma, px", &FailureFigures::sigma_dp_px, 3},
                  {"68 % error, px", &FailureFigures::error_68_dp_px, 3},
                  {"within 1 sigma", &FailureFigures::within_one_sigma, 2},
                  {"within 2 sigma", &FailureFigures::within_two_sigma, 2}};
  Table table{{sweep.sweep, "method", "wrong"}, {}};
  for (const auto& column : kColumns) table.header.emplace_back(column.name);
  for (const FailureStep& step : sweep.steps) {
    for (std::size_t m = 0; m < sweep.methods.size(); ++m) {
      std::vector<std::string>& row = table.rows.emplace_back(
          std::vector{fmt::format("{:g}", step.value), sweep.methods[m], cell_of(step.methods[m].wrong, 3)});
      for (const auto& [name, figure, decimals] : kColumns) row.push_back(cell_of(step.methods[m].*figure, decimals));
    }
  }
  return "<details><summary>Figures</summary>" + html_table(table) + "</details>";
}

/// Green where a method holds throughout, red where it never does.
std::string cell(const FailureSweep& sweep, std::size_t method) {
  constexpr std::size_t kShades = 6;
  const BreakingPoint& point = sweep.breaks[method];
  const std::size_t shade = (kShades - 1) * point.step / std::max<std::size_t>(sweep.steps.size(), 1);
  std::string text = sweep.value_at(point.step);
  if (point.low != point.high) {
    text += fmt::format(" <span class=\"soft\">{} … {}</span>", sweep.value_at(point.low), sweep.value_at(point.high));
  }
  const std::optional<double> overconfident = sweep.overconfident(method);
  if (overconfident.value_or(0) > kOverconfident) text += fmt::format("<br>⚠ {:.1f} %", 100 * *overconfident);
  return fmt::format("<td class=\"s{}\"><a href=\"#{}\">{}</a></td>", shade, id_of(sweep, method), text);
}

std::string atlas_table(const std::vector<FailureSweep>& sweeps) {
  std::string html = "<div class=\"scroll\"><table class=\"atlas\"><thead><tr><td>failure</td><td>swept</td>";
  for (const std::string& method : sweeps.front().methods) html += "<td>" + escape_name(method) + "</td>";
  html += "</tr></thead><tbody>\n";
  for (const FailureSweep& sweep : sweeps) {
    html += fmt::format("<tr><td><a href=\"#{}\">{}</a></td><td>{}, {} … {}</td>", escape_name(sweep.name),
                        escape_html(sweep.title), escape_html(sweep.sweep), sweep.value_at(0),
                        sweep.value_at(sweep.steps.size() - 1));
    for (std::size_t m = 0; m < sweep.methods.size(); ++m) html += cell(sweep, m);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

constexpr const char* kIntroduction = R"html(
<h1>How matching two dual-pixel views fails</h1>
<p>Each row makes one thing worse, step by step, until a method breaks: more than a tenth of the pixels err by more than
0.5 DP px, or have no disparity. A cell names the first step at which that is so, from red (at once) to green (never), and
in gray its 95&nbsp;% interval where other parts of the picture would give other steps. ⚠: the share of the picture that
is wrong and yet trusted (a predicted sigma under 0.2 px, or of a method without sigma a confidence of 1/2) at the worst
step, where it exceeds 1&nbsp;%. A click leads to curves and pictures.</p>
)html";

}  // namespace

std::string to_page(const std::vector<FailureSweep>& sweeps, const std::string& camera) {
  std::string body = kIntroduction + ("<p>" + escape_name(camera) + "</p>\n") + atlas_table(sweeps);
  for (const FailureSweep& sweep : sweeps) {
    body += fmt::format("<h2 id=\"{}\">{}</h2>\n<p>{}</p>\n", escape_name(sweep.name), escape_html(sweep.title),
                        escape_html(sweep.note));
    body += strips(sweep) + plots(sweep) + figure_table(sweep);
  }
  return html_page("How matching fails", body, kFailureStyle);
}

}  // namespace dualpixel::evaluation
