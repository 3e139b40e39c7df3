#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "evaluation/benchmarks/render_benchmark.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"

namespace dualpixel::evaluation {
namespace {

constexpr const char* kEmbreeAlone = "Embree alone";

/// The runs of all curves but Embree's alone that no other run beats in both time and error.
Series pareto_front(const std::vector<RenderCurve>& curves) {
  std::vector<std::pair<double, double>> all;
  for (const RenderCurve& curve : curves) {
    if (curve.name == kEmbreeAlone) continue;
    for (const RenderRun& run : curve.runs) all.emplace_back(run.time_s, run.error);
  }
  std::sort(all.begin(), all.end());
  Series front{"Pareto front", {}, false, true};
  for (const auto& point : all) {
    if (front.points.empty() || point.second < front.points.back().second) front.points.push_back(point);
  }
  return front;
}

Plot saved_plot(const std::vector<TimeSaved>& saved) {
  Plot plot;
  plot.title = "Time of independent samples over that of mirrored pairs";
  plot.x_label = "error over the sensor's noise";
  plot.y_label = "ratio";
  plot.log_x = true;
  Series measured{"measured", {}, false, false},
      extrapolated{"independent samples extrapolated as 1/N", {}, true, false};
  for (const TimeSaved& row : saved) {
    if (!row.extrapolated) measured.points.emplace_back(row.error, row.ratio);
    if (row.extrapolated && extrapolated.points.empty() && !measured.points.empty()) {
      extrapolated.points.push_back(measured.points.back());
    }
    if (row.extrapolated) extrapolated.points.emplace_back(row.error, row.ratio);
  }
  plot.series = {measured, extrapolated};
  return plot;
}

Plot error_plot(const std::vector<RenderCurve>& curves, const char* title, double RenderRun::*error) {
  Plot plot;
  plot.title = title;
  plot.x_label = "CPU time, s";
  plot.y_label = "error over the sensor's noise";
  plot.log_x = plot.log_y = true;
  for (const RenderCurve& curve : curves) {
    Series line{curve.name, {}, curve.name == kEmbreeAlone, false};
    for (const RenderRun& run : curve.runs) line.points.emplace_back(run.time_s, run.*error);
    plot.series.push_back(line);
  }
  return plot;
}

std::string scene_section(const SceneRenderBenchmark& scene) {
  const EmbreeShare& embree = scene.embree;
  Plot views = error_plot(scene.curves, "Left and right", &RenderRun::error);
  views.series.push_back(pareto_front(scene.curves));
  return fmt::format(
             "<h2>{}</h2><p>{:.1f} M samples a core-second with {:.2f} rays each; Embree alone, on the same rays, "
             "{:.1f} "
             "M in packets of 16, {:.1f} M of 8, {:.1f} M one by one: {:.0f} % of the time is Embree's. Both views "
             "take "
             "{:.3f} times as long as a single undivided one.</p>",
             escape_name(scene.scene), embree.samples_per_core_s / 1e6, embree.rays_per_sample,
             embree.embree_samples_per_core_s[2] / 1e6, embree.embree_samples_per_core_s[1] / 1e6,
             embree.embree_samples_per_core_s[0] / 1e6, 100 * embree.share_of_embree, scene.pair_over_undivided) +
         html_plots({views, error_plot(scene.curves, "Left minus right", &RenderRun::left_minus_right),
                     saved_plot(scene.time_saved)});
}

}  // namespace

std::string to_page(const std::vector<SceneRenderBenchmark>& scenes, const RenderScaling& scaling) {
  std::string body =
      "<h1>Rendering: error against time</h1><p>Error: RMS of both views' photosites against a converged reference, "
      "over the noise that the scene's sensor adds to them; of 24 patches spread over the frame. Time: CPU time of all "
      "cores.</p>";
  for (const SceneRenderBenchmark& scene : scenes) body += scene_section(scene);
  return html_page("Rendering: error against time", body + scaling_section(scaling));
}

}  // namespace dualpixel::evaluation
