#include <algorithm>

#include "evaluation/benchmarks/lens_benchmark.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {

std::string to_page(const std::vector<LensBenchmark>& lenses, const std::string& scene_file) {
  Plot plot;
  plot.title = "Cost and error of lens models";
  plot.x_label = "time of a sample over the thin lens's";
  plot.y_label = "disparity error, DP px RMS";
  plot.log_y = true;
  Table table{{"lens", "model", "ready, s", "M samples/core-s", "time/thin", "disparity error, DP px"}, {}};
  for (const LensBenchmark& lens : lenses) {
    Series line{lens.lens, {}, true, false};
    for (const LensModelCost& m : lens.models) {
      // the exact trace is the reference: its error of 0 is drawn at the bottom of the logarithmic axis
      line.points.emplace_back(m.time_over_thin, std::max(m.disparity_error_dp_px, 1e-4));
      table.rows.push_back({lens.lens, m.model, cell_of(m.ready_s, 2), cell_of(m.samples_per_core_s / 1e6, 2),
                            cell_of(m.time_over_thin, 2), cell_of(m.disparity_error_dp_px, 4)});
    }
    plot.series.push_back(line);
  }
  const std::string title = "Lens models: time against error";
  return html_page(title, "<h1>" + title +
                              "</h1><p>From left to right along each line: thin lens, aberrated twin, fitted "
                              "polynomials, exact trace (the reference, drawn at 0.0001). Scene: " +
                              escape_name(scene_file) + ", one thread, 16 samples a photosite.</p>" +
                              html_plots({plot}) + html_table(table));
}

}  // namespace dualpixel::evaluation
