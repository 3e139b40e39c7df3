#include "evaluation/benchmarks/defocus_benchmark.h"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "capture/timing.h"
#include "evaluation/simulated_scene.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/render.h"
#include "pipeline/defocus/scatter.h"
#include "pipeline/portrait/run_portrait.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kLargestDirectPx = 20;

/// A burst at the scene's full size. Enough samples that its noise is a camera's: grain from rendering would fill the
/// bilateral grid with colors that no picture has, and smoothing would take three times as long.
Capture render_burst(const std::string& scene_file) {
  return simulate_scene(scene_file, {"render.samples_per_pixel=16", "render.photograph_samples_per_pixel=1",
                                     "render.all_in_focus_samples_per_pixel=1"});
}

std::vector<RadiusTime> time_radii(int width, int height) {
  std::vector<RadiusTime> rows;
  for (const double radius_px : {3.0, 4.0, 5.5, 8.0, 11.0, 15.0, 20.0, 30.0, 40.0, 60.0}) {
    const pipeline::Layer layer{Image(width / 2, height / 2, 4, 0.5f),
                                Image(width / 2, height / 2, 1, static_cast<float>(radius_px / 2))};
    Image front(width / 2, height / 2, 4);
    const bool direct = radius_px <= kLargestDirectPx;
    std::vector<std::function<void()>> work = {[&] { scatter_gradient(layer, front); }};
    if (direct) work.emplace_back([&] { scatter_direct(layer, front); });
    const Times best = times(work, 3);
    RadiusTime& row = rows.emplace_back(RadiusTime{radius_px, best.ms[0], best.cpu_ms[0], {}, {}});
    if (direct) row.direct_ms = best.ms[1], row.direct_cpu_ms = best.cpu_ms[1];
  }
  return rows;
}

/// The renderers by themselves, on the pictures of a run, and with the largest radius everywhere.
std::vector<RendererTime> time_renderers(const Capture& capture, const Image& mask) {
  const pipeline::PortraitResult result = pipeline::run_portrait(capture, pipeline::PortraitOptions());
  const int width = result.input.width, height = result.input.height;
  const pipeline::BlurMapping mapping =
      pipeline::make_blur_mapping(capture.camera.focus_distance_m, result.focus_disparity_dp_px, width, false);
  // a wall far behind, blurred by 30 px everywhere
  Image far(width, height, 1, static_cast<float>(mapping.back_dp_px(mapping.r_max_px) + 1));
  const Image largest(width, height, 1, static_cast<float>(mapping.r_max_px));
  far.at(0, 0) += 0.2f;
  const Image from = result.input;
  Image to = from;
  const Times best = times({[&] {
                              render_defocus(result.input, result.disparity_dp_px,
                                             blur_radii(result.disparity_dp_px, mapping), mapping);
                            },
                            [&] { render_defocus(result.input, far, largest, mapping); },
                            [&] { pipeline::blur_background(result.input, mask); },
                            [&] { std::copy(from.data.begin(), from.data.end(), to.data.begin()); }},
                           5);
  const char* const names[] = {"depth_renderer", "depth_renderer_30px_everywhere", "mask_renderer", "copy_of_picture"};
  std::vector<RendererTime> rows;
  for (std::size_t i = 0; i < std::size(names); ++i) rows.push_back({names[i], best.ms[i], best.cpu_ms[i]});
  return rows;
}

}  // namespace

DefocusBenchmark measure_defocus_time(const std::string& scene_file) {
  Capture capture = render_burst(scene_file);
  const Image mask = capture.truth->person_mask;
  capture.truth.reset();
  DefocusBenchmark benchmark;
  benchmark.renderers = time_renderers(capture, mask);
  benchmark.radii = time_radii(capture.camera.width_px, capture.camera.height_px);
  return benchmark;
}

nlohmann::ordered_json to_json(const DefocusBenchmark& benchmark) {
  nlohmann::ordered_json json;
  for (const RendererTime& r : benchmark.renderers) {
    json["renderers"][r.name] = {{"ms", r.ms}, {"cpu_ms", r.cpu_ms}};
  }
  json["radii"] = nlohmann::ordered_json::array();
  for (const RadiusTime& r : benchmark.radii) {
    nlohmann::ordered_json row = {
        {"radius_px", r.radius_px}, {"gradient_ms", r.gradient_ms}, {"gradient_cpu_ms", r.gradient_cpu_ms}};
    if (r.direct_ms) row.update({{"direct_ms", *r.direct_ms}, {"direct_cpu_ms", *r.direct_cpu_ms}});
    json["radii"].push_back(row);
  }
  return json;
}

}  // namespace dualpixel::evaluation
