#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/experiments/burst_experiment.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

/// One line a condition: value(point) over number(point).
template <typename Number, typename Value>
Plot plot_of(const std::vector<BurstSweep>& sweeps, double lux, Plot plot, Number number, Value value) {
  for (const BurstSweep& sweep : sweeps) {
    if (sweep.lux != lux) continue;
    Series& series = plot.series.emplace_back();
    series.name = sweep.condition;
    for (const BurstPoint& point : sweep.points) series.points.emplace_back(number(point), value(point));
  }
  return plot;
}

std::vector<Plot> plots_of(const std::vector<BurstSweep>& sweeps, double lux) {
  const auto frames = [](const BurstPoint& point) { return static_cast<double>(point.frames); };
  const auto over_frames = [&](const char* title, const char* unit, bool log_y, const auto& value) {
    Plot plot;
    plot.title = title, plot.y_label = unit, plot.x_label = "frames", plot.log_x = true, plot.log_y = log_y;
    return plot_of(sweeps, lux, plot, frames, value);
  };
  // the pipeline's merge and, dashed, six channels by one weight
  const auto both = [&](const char* title, const char* unit, bool log_y, double MergeError::*figure) {
    Plot plot = over_frames(title, unit, log_y, [&](const BurstPoint& point) { return point.merge.*figure; });
    const Plot six =
        over_frames(title, unit, log_y, [&](const BurstPoint& point) { return point.six_channels.*figure; });
    for (Series series : six.series) {
      series.name += ", six channels", series.dashed = true;
      plot.series.push_back(std::move(series));
    }
    return plot;
  };
  const auto kept = [](const BurstPoint& point) { return point.merge.views_kept; };
  const char* const over_first = "over the first frame's";
  std::vector<Plot> plots = {
      both("Error of the merged views against the clean ones", over_first, true, &MergeError::views_kept),
      both("Error of the merged mosaic against the clean one", over_first, true, &MergeError::mosaic_kept),
      both("Ghosts", "share of squares", false, &MergeError::ghost_share)};
  for (std::size_t m = 0; m < sweeps.front().points.front().disparity.size(); ++m) {
    const std::string matcher = sweeps.front().points.front().disparity[m].matcher;
    plots.push_back(over_frames(("Disparity, matcher " + matcher).c_str(), "68 % of errors under, DP px", true,
                                [&](const BurstPoint& point) { return point.disparity[m].error_68_dp_px; }));
  }
  plots.push_back(over_frames("Portrait against that of 15 frames at rest", "PSNR, dB", false,
                              [](const BurstPoint& point) { return point.portrait_db.value_or(NAN); }));
  Plot time;
  time.title = "Error over time", time.x_label = "CPU time of aligning and merging, s";
  time.y_label = "error over the first frame's", time.log_y = true;
  plots.push_back(plot_of(
      sweeps, lux, time, [](const BurstPoint& point) { return point.merge.cpu_s; }, kept));
  return plots;
}

/// Of ten frames, or as many as there are.
Table table_of(const std::vector<BurstSweep>& sweeps, double lux) {
  const auto& matchers = sweeps.front().points.front().disparity;
  Table table{{"condition", "frames", "error kept: views", "six channels", "mosaic", "six channels", "ghosts, %",
               "six channels", "portrait, dB", "merging, CPU s", "six channels"},
              {}};
  for (const BurstPoint::Disparity& d : matchers) table.header.push_back(d.matcher + ", DP px");
  for (const BurstSweep& sweep : sweeps) {
    if (sweep.lux != lux) continue;
    const auto ten = std::find_if(sweep.points.begin(), sweep.points.end(),
                                  [](const BurstPoint& point) { return point.frames == 10; });
    const BurstPoint& point = ten == sweep.points.end() ? sweep.points.back() : *ten;
    const MergeError &ours = point.merge, &six = point.six_channels;
    std::vector<std::string>& row = table.rows.emplace_back();
    row = {sweep.condition,
           std::to_string(point.frames),
           cell_of(ours.views_kept, 3),
           cell_of(six.views_kept, 3),
           cell_of(ours.mosaic_kept, 3),
           cell_of(six.mosaic_kept, 3),
           cell_of(100 * ours.ghost_share, 2),
           cell_of(100 * six.ghost_share, 2),
           cell_of(point.portrait_db, 1),
           cell_of(ours.cpu_s, 2),
           cell_of(six.cpu_s, 2)};
    for (const BurstPoint::Disparity& d : point.disparity) row.push_back(cell_of(d.error_68_dp_px, 3));
  }
  return table;
}

}  // namespace

std::string to_page(const std::vector<BurstSweep>& sweeps) {
  const std::string title = "Bursts from end to end";
  std::string body = fmt::format(
      "<h1>{}</h1>\n<p>A card before a wall, one of them on each side of the focus, taken as 15 frames: at rest, by a "
      "hand that shakes as measured, with the card moving by 4 DP px a frame, and in light that flickers by a tenth. "
      "The first 1 to 15 frames are aligned to the first one and merged. Six channels by one weight: the merge as the "
      "paper describes it, without our test of whole tiles.</p>",
      title);
  std::vector<double> lights;
  for (const BurstSweep& sweep : sweeps) {
    if (!lights.empty() && lights.back() == sweep.lux) continue;
    lights.push_back(sweep.lux);
    body += fmt::format("<h2>{:g} lux</h2>", sweep.lux) + html_table(table_of(sweeps, sweep.lux)) +
            html_plots(plots_of(sweeps, sweep.lux));
  }
  return html_page(title, body);
}

}  // namespace dualpixel::evaluation
