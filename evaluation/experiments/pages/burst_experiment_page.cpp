#include <fmt/format.h>

#include "evaluation/experiments/burst_experiment.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"

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
  const auto kept = [](const BurstPoint& point) { return point.merge.views_kept; };
  const auto six = [](const BurstPoint& point) { return point.six_channels.views_kept; };
  const auto mosaic = [](const BurstPoint& point) { return point.merge.mosaic_kept; };
  const auto six_mosaic = [](const BurstPoint& point) { return point.six_channels.mosaic_kept; };
  const char* const over_first = "over the first frame's";
  std::vector<Plot> plots = {
      over_frames("Error of the merged views against the clean ones", over_first, true, kept),
      over_frames("Error of the merged views, six channels by one weight", over_first, true, six),
      over_frames("Error of the merged mosaic against the clean one", over_first, true, mosaic),
      over_frames("Error of the merged mosaic, six channels by one weight", over_first, true, six_mosaic),
      over_frames("Ghosts", "share of squares", false,
                  [](const BurstPoint& point) { return point.merge.ghost_share; })};
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
    body += fmt::format("<h2>{:g} lux</h2>", sweep.lux) + html_plots(plots_of(sweeps, sweep.lux));
  }
  return html_page(title, body);
}

}  // namespace dualpixel::evaluation
