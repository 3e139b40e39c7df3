#include <fmt/format.h>

#include <algorithm>

#include "evaluation/experiments/failure_atlas.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

/// Adds one line for each method that has the figure; `sigma_figure` gives a second, dashed one for those that predict
/// a sigma.
template <typename Figure>
void add_lines(Plot& plot, const FailureSweep& sweep, const Figure& figure, const std::string& sigma_name,
               double SigmaFigures::*sigma_figure) {
  for (std::size_t i = 0; i < sweep.methods.size(); ++i) {
    const std::string& name = sweep.methods[i];
    Series line{name, {}, false, false}, dashed{name + ", " + sigma_name, {}, true, false};
    for (const FailureStep& step : sweep.steps) {
      const FailureFigures& figures = step.methods[i];
      if (const std::optional<double> value = figure(figures)) line.points.emplace_back(step.value, *value);
      if (figures.sigma) dashed.points.emplace_back(step.value, (*figures.sigma).*sigma_figure);
    }
    if (!line.points.empty()) plot.series.push_back(line);
    if (!dashed.points.empty()) plot.series.push_back(dashed);
  }
}

std::string plots(const FailureSweep& sweep) {
  Plot error, belief;
  error.title = sweep.row.title + ": wrong by > 0.5 px";
  belief.title = sweep.row.title + ": confidence";
  error.x_label = belief.x_label = sweep.row.sweep;
  error.log_x = belief.log_x = sweep.row.log;
  error.y_label = "share of pixels";
  belief.y_label = "mean confidence, or share";
  add_lines(
      error, sweep, [](const FailureFigures& f) { return std::optional(f.wrong); }, "and confident",
      &SigmaFigures::overconfident_errors);
  add_lines(
      belief, sweep, [](const FailureFigures& f) { return f.confidence; }, "share with sigma < 0.2 px",
      &SigmaFigures::confident);
  return html_plots({error, belief});
}

std::string figure_table(const FailureSweep& sweep) {
  Table table{{sweep.row.sweep}, {}};
  for (const std::string& name : sweep.methods) {
    for (const char* column : {" RMSE, px", " wrong", " confidence", " median sigma, px", " wrong and confident",
                               " within 1 sigma", " within 2 sigma"}) {
      table.header.push_back(name + column);
    }
  }
  for (const FailureStep& step : sweep.steps) {
    std::vector<std::string>& row = table.rows.emplace_back(1, fmt::format("{:g}", step.value));
    for (const FailureFigures& f : step.methods) {
      for (const std::optional<double> figure : {f.rmse_dp_px, std::optional(f.wrong), f.confidence}) {
        row.push_back(cell_of(figure, 3));
      }
      const auto of_sigma = [&](double SigmaFigures::*figure, int decimals) {
        row.push_back(cell_of(f.sigma ? std::optional((*f.sigma).*figure) : std::nullopt, decimals));
      };
      of_sigma(&SigmaFigures::median_sigma_dp_px, 3);
      of_sigma(&SigmaFigures::overconfident_errors, 4);
      of_sigma(&SigmaFigures::within_one_sigma, 2);
      of_sigma(&SigmaFigures::within_two_sigma, 2);
    }
  }
  return "<details><summary>Figures</summary>" + html_table(table) + "</details>";
}

/// Where each method breaks, and the largest share of overconfident errors of any step.
Table summary_table(const std::vector<FailureSweep>& sweeps) {
  Table table{{"failure", "swept"}, {}};
  for (const std::string& name : sweeps.front().methods) table.header.push_back(name + " breaks at");
  table.header.emplace_back("most wrong and confident");
  for (const FailureSweep& sweep : sweeps) {
    std::vector<std::string>& row = table.rows.emplace_back(std::vector{sweep.row.title, sweep.row.sweep});
    double most = 0;
    for (std::size_t i = 0; i < sweep.methods.size(); ++i) {
      const std::optional<double> value = sweep.breaks_at(i);
      row.push_back(value ? fmt::format("{:g}", *value) : "never");
      for (const FailureStep& step : sweep.steps) {
        if (step.methods[i].sigma) most = std::max(most, step.methods[i].sigma->overconfident_errors);
      }
    }
    row.push_back(fmt::format("{:.2f} %", 100 * most));
  }
  return table;
}

constexpr const char* kAtlasIntroduction = R"html(
<h1>How matching two dual-pixel views fails</h1>
<p>Each row sweeps one cause of failure until a method breaks. The views are made in closed form: textures with as much
contrast in every octave (20 % of a mean of 811 electrons, 100 lux, unless swept), seen through mirrored halves of the
pupil; the truth is the disparity of the kernels' centroids, and is left out where a pixel sees more than one surface.
A pixel is wrong where it errs by more than 0.5 DP px, and confident where a sigma under 0.2 px was predicted: wrong and
confident, an overconfident error, must not happen in over 1 % of a picture. Disparities are those of the pixels, after
upsampling from tiles.</p>
<p>A wrong focus distance in the metadata changes no matcher's disparity: they don't read it. A depth derived from a
disparity d by 1/D = 1/z - d / (alpha L f) is then wrong by the difference of 1/z, the same everywhere.</p>
)html";

}  // namespace

std::string to_page(const std::vector<FailureSweep>& sweeps) {
  std::string body = kAtlasIntroduction + html_table(summary_table(sweeps)) +
                     "<p class=\"soft\">Broken: more than a tenth of the pixels are wrong.</p>";
  for (const FailureSweep& sweep : sweeps) {
    body += "<h2>" + escape_html(sweep.row.title) + "</h2>" + plots(sweep) + figure_table(sweep);
  }
  return html_page("How matching fails", body);
}

}  // namespace dualpixel::evaluation
