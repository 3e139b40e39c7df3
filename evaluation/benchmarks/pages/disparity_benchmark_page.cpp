#include "evaluation/benchmarks/disparity_benchmark.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {

std::string to_page(const DisparityBenchmark& benchmark) {
  Plot plot;
  plot.title = "Error against time";
  plot.x_label = "ms at 1344 x 1008";
  plot.y_label = "RMSE, DP px";
  Table table{{"scene", "method", "ms", "RMSE, DP px", "wrong by > 0.5 px", "answered"}, {}};
  for (const DisparityBenchmark::Scene& scene : benchmark.scenes) {
    for (std::size_t i = 0; i < scene.methods.size(); ++i) {
      const MatcherBenchmark& m = scene.methods[i];
      if (plot.series.size() <= i) plot.series.push_back({m.method, {}, false, true});
      plot.series[i].points.emplace_back(m.ms, m.rmse_dp_px);
      table.rows.push_back({scene.scene, m.method, cell_of(m.ms, 1), cell_of(m.rmse_dp_px, 3),
                            cell_of(m.wrong_share, 3), cell_of(m.answered_share, 3)});
    }
  }
  return html_page("Disparity: error against time",
                   "<h1>Disparity: error against time</h1><p>One dot per scene. Pairs rendered at 672 x 252 DP pixels, "
                   "one frame with its noise; errors against the true disparity of every pixel for which the method "
                   "gives one. Times are those of the same pair enlarged to 1344 x 1008, all threads, normalization "
                   "and upsampling included.</p>" +
                       html_plots({plot}) + html_table(table));
}

}  // namespace dualpixel::evaluation
