#include <fmt/format.h>

#include "evaluation/benchmarks/smoothing_benchmark.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

constexpr struct {
  const char* name;
  SmoothingRun SmoothingComparison::*run;
} kTargets[] = {{"matched", &SmoothingComparison::matched}, {"known", &SmoothingComparison::known}};

constexpr struct {
  double SmoothingErrors::*error;
  const char* label;
} kAxes[] = {{&SmoothingErrors::rmse_dp_px, "RMSE, DP px"},
             {&SmoothingErrors::edge_mae_dp_px, "MAE within 3 px of depth edges, DP px"},
             {&SmoothingErrors::thin_mae_dp_px, "MAE on thin structures, DP px"}};

std::vector<Plot> plots(const std::vector<SmoothingComparison>& methods) {
  std::vector<Plot> all;
  for (const auto& [target, run] : kTargets) {
    for (const auto& [error, label] : kAxes) {
      Plot& plot = all.emplace_back();
      plot.title = fmt::format("{}: {}", target, label);
      plot.x_label = "CPU ms, encoding the guide included";
      plot.y_label = label;
      plot.log_x = true;
      for (const SmoothingComparison& method : methods) {
        if (plot.series.empty() || plot.series.back().name != method.family) {
          plot.series.push_back({method.family, {}, false, true});
        }
        plot.series.back().points.emplace_back((method.*run).cpu_ms, (method.*run).errors.*error);
      }
    }
  }
  return all;
}

Table method_table(const std::vector<SmoothingComparison>& methods) {
  Table table{{"family", "variant", "target", "ms, with guide", "CPU ms, with guide", "RMSE", "MAE", "RMSE at edges",
               "MAE at edges", "10-90 % width, px", "MAE, thin"},
              {}};
  for (const SmoothingComparison& method : methods) {
    for (const auto& [target, run] : kTargets) {
      const SmoothingErrors& e = (method.*run).errors;
      table.rows.push_back({method.family, method.name, target, cell_of((method.*run).ms, 1),
                            cell_of((method.*run).cpu_ms, 1), cell_of(e.rmse_dp_px, 4), cell_of(e.mae_dp_px, 4),
                            cell_of(e.edge_rmse_dp_px, 4), cell_of(e.edge_mae_dp_px, 4), cell_of(e.edge_width_px, 1),
                            cell_of(e.thin_mae_dp_px, 4)});
    }
  }
  return table;
}

}  // namespace

std::string to_page(const SmoothingBenchmark& benchmark) {
  Table failures{{"case", "figure, 0 is perfect", "ours", "OpenCV's"}, {}};
  for (const SolverFailure& f : benchmark.failures) {
    failures.rows.push_back(
        {f.failure, f.figure, fmt::format("{:.4g}", f.ours), f.opencv ? fmt::format("{:.4g}", *f.opencv) : ""});
  }
  const std::string title = "Edge-aware smoothing: error against time";
  return html_page(
      title, "<h1>" + title + "</h1><p>Capture: " + escape_name(benchmark.capture) +
                 ". Disparity smoothed (at a quarter of the capture's size unless stated), median, joint upsampling; "
                 "times include all of these and encoding the full-size guide, but not reducing guide and map. "
                 "Matched: the paper's matches, fitted to the truth. Known: the truth with "
                 "noise of 0.15 DP px, 5 % outliers, and no data within 16 px of depth edges.</p>" +
                 html_plots(plots(benchmark.methods)) + html_table(method_table(benchmark.methods)) +
                 "<h2>Where solvers fail</h2>" + html_table(failures));
}

}  // namespace dualpixel::evaluation
