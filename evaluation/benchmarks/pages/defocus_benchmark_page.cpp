#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/benchmarks/defocus_benchmark.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

Plot radius_plot(const std::vector<RadiusTime>& radii) {
  Plot plot;
  plot.title = "Cost of a blur";
  plot.x_label = "radius, full-resolution px";
  plot.y_label = "CPU ms";
  plot.log_x = plot.log_y = true;
  plot.series = {
      {"gradients at disc edges", {}, false, false}, {"brute force", {}, false, false}, {"r", {}, true, false}};
  const double unit = radii.back().gradient_cpu_ms / radii.back().radius_px;
  for (const RadiusTime& row : radii) {
    plot.series[0].points.emplace_back(row.radius_px, row.gradient_cpu_ms);
    if (row.direct_cpu_ms) plot.series[1].points.emplace_back(row.radius_px, *row.direct_cpu_ms);
    plot.series[2].points.emplace_back(row.radius_px, unit * row.radius_px);
  }
  return plot;
}

}  // namespace

std::string to_page(const DefocusBenchmark& benchmark) {
  Table total{{"", "ms", "CPU ms"}, {}};
  for (const RendererTime& renderer : benchmark.renderers) {
    std::string words = renderer.name;
    std::replace(words.begin(), words.end(), '_', ' ');
    total.rows.push_back({words, cell_of(renderer.ms, 0), cell_of(renderer.cpu_ms, 0)});
  }
  return html_page("Defocus: time", "<h1>Defocus: time</h1><p>A burst at full size, all cores; the best of five.</p>" +
                                        html_table(total) + html_plots({radius_plot(benchmark.radii)}));
}

}  // namespace dualpixel::evaluation
