#include <fmt/format.h>

#include "evaluation/experiments/calibration_cost.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {

std::string to_page(const CalibrationCost& cost) {
  Plot plot;
  plot.title = "Photographs against residual";
  plot.x_label = "photographs";
  plot.y_label = "standard deviation over the field, DP px";
  plot.wide = true;
  Table table{{"Changed", "to", "photographs", "residual, DP px", "estimated tilt, degrees", "warning"}, {}};
  for (const CalibrationEffort& e : cost.efforts) {
    if (plot.series.empty() || plot.series.back().name != e.axis) {
      plot.series.push_back({e.axis, {}, false, e.axis != "focus distances" && e.axis != "target distances"});
    }
    plot.series.back().points.emplace_back(e.photographs(), e.residual_dp_px);
    table.rows.push_back({e.axis, e.value, std::to_string(e.photographs()), cell_of(e.residual_dp_px, 4),
                          fmt::format("{:.2f} ± {:.2f}", e.tilt.x_deg, e.tilt.x_error_deg), e.warned ? "tilted" : ""});
  }
  const std::string title = "What a cheaper calibration costs";
  return html_page(
      title,
      fmt::format("<h1>{}</h1>\n<p>{}, focused at {:g} m, where no sweep measured. Planes at {:g}, {:g} and {:g} "
                  "m should have one disparity each; its standard deviation over the inner 90 % of the field is "
                  "{:.3f} DP px before correction. Below, after it; all settings but the one named are those of "
                  "the full sweep of 20 focus and 8 target distances.</p>\n",
                  title, escape_name(cost.lens), kCostFocus_m, kCostDepths_m[0], kCostDepths_m[1], kCostDepths_m[2],
                  cost.uncorrected_dp_px) +
          html_plots({plot}) + html_table(table));
}

}  // namespace dualpixel::evaluation
