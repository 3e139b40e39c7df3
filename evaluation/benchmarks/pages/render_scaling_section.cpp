#include <fmt/format.h>

#include "evaluation/benchmarks/render_scaling.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"

namespace dualpixel::evaluation {
namespace {

constexpr const char* kSampleTime = "CPU time of a sample, ns";

template <typename Row, typename X, typename Y>
Series series_of(const std::string& name, const std::vector<Row>& rows, const X& x, const Y& y) {
  Series series{name, {}};
  for (const Row& row : rows) series.points.emplace_back(x(row), y(row));
  return series;
}

Plot plot_of(const std::string& title, const char* x_label, const char* y_label, std::vector<Series> series) {
  Plot plot;
  plot.title = title;
  plot.x_label = x_label;
  plot.y_label = y_label;
  plot.log_x = true;
  plot.series = std::move(series);
  return plot;
}

Plot sample_plot(const std::string& title, const char* x_label, const std::vector<SampleCost>& costs) {
  return plot_of(title, x_label, kSampleTime,
                 {series_of(
                     "measured", costs, [](const SampleCost& c) { return c.count; },
                     [](const SampleCost& c) { return c.cpu_ns; })});
}

Plot triangle_plot(const std::string& title, const char* y_label, const std::vector<SceneCost>& costs,
                   double SceneCost::*figure) {
  return plot_of(title, "triangles", y_label,
                 {series_of(
                     "measured", costs, [](const SceneCost& c) { return c.triangles; },
                     [&](const SceneCost& c) { return c.*figure; })});
}

template <typename Row, typename Count>
Plot light_plot(const std::string& title, const char* x_label, const std::vector<Row>& costs, const Count& count) {
  Plot plot = plot_of(title, x_label, "CPU time of points of light, s",
                      {series_of("measured", costs, count, [](const Row& c) { return c.light.cpu_s; })});
  plot.log_y = true;
  return plot;
}

Plot instancing_plot(const std::vector<InstancingCost>& costs) {
  const auto triangles = [](const InstancingCost& c) { return c.placed.triangles; };
  return plot_of("Placements of a tile of 10082 triangles", "triangles", "CPU time of a ray in Embree, ns",
                 {series_of("placed", costs, triangles, [](const InstancingCost& c) { return c.placed.ray_ns; }),
                  series_of("copied", costs, triangles, [](const InstancingCost& c) { return c.copied.ray_ns; })});
}

}  // namespace

std::string scaling_section(const RenderScaling& scaling) {
  const SceneCost& largest = scaling.triangles.back();
  const InstancingCost& instanced = scaling.instancing.back();
  return fmt::format(
             "<h2>Growth</h2><p>On a wall of waves made by code, one shadow ray a sample, CPU time of one thread: the "
             "cost of a sample stays within ±{:.1f} % over the number of samples, ±{:.1f} % over that of photosites. "
             "Two "
             "threads are {:.2f} times as fast as one ({:.2f} of the CPU time). The acceleration structure of {:.1e} "
             "triangles takes {:.0f} bytes each. As {} placements of one tile they take {:.1f} bytes each, and a ray "
             "takes {:.2f} times as long as among copies. A picture of 128 × 96 photosites asks for {:.0f} points of "
             "light on {:.1e} triangles, which take {:.2f} s.</p>",
             100 * relative_spread(scaling.samples), 100 * relative_spread(scaling.photosites), scaling.wall_time_ratio,
             1 / scaling.cpu_time_ratio, largest.triangles, largest.bytes_per_triangle, instanced.placements,
             instanced.placed.bytes_per_triangle, instanced.placed.ray_ns / instanced.copied.ray_ns,
             largest.light.points, largest.triangles, largest.light.cpu_s) +
         html_plots({sample_plot("Samples of a photosite", "samples", scaling.samples),
                     sample_plot("Photosites", "photosites", scaling.photosites),
                     triangle_plot("Triangles", kSampleTime, scaling.triangles, &SceneCost::cpu_ns),
                     triangle_plot("Memory of the acceleration structure", "bytes of a triangle", scaling.triangles,
                                   &SceneCost::bytes_per_triangle),
                     light_plot("Light on surfaces, 128 × 96 photosites", "triangles", scaling.triangles,
                                [](const SceneCost& c) { return c.triangles; }),
                     light_plot("Light on surfaces, 10^5 triangles", "photosites", scaling.photosites,
                                [](const SampleCost& c) { return c.count; }),
                     instancing_plot(scaling.instancing)});
}

}  // namespace dualpixel::evaluation
