#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "capture/timing.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/lens_candidates.h"
#include "simulator/simulate.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchLensOptions {
  std::vector<std::string> lenses = {"lens_models/phone_6p_4.2mm_f1.8.json", "lens_models/phone_7p_4.9mm_f1.85.json",
                                     "lens_models/full_frame_50mm_f1.8.json"};
  std::string scene = "build/release/scenes/slanted_planes.json";
  std::string page;
  bool json = false;
};

/// RMS over the field and over depths of what `lens` says against what `reference` says, DP px.
double disparity_error(const simulator::LensSampler& lens, const simulator::LensSampler& reference) {
  double sum = 0;
  int count = 0;
  const simulator::SensorGrid& sensor = lens.sensor();
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 12; ++column) {
      const int x = (2 * column + 1) * sensor.width_px / 24, y = (2 * row + 1) * sensor.height_px / 18;
      const simulator::DisparityCoefficients a = trace_disparity(lens, x, y, 2048);
      const simulator::DisparityCoefficients b = trace_disparity(reference, x, y, 2048);
      for (double diopters : {0.0, 0.5, 1.0, 2.0, 4.0}) {
        const double error = (a.slope_dp_px_m - b.slope_dp_px_m) * diopters + a.intercept_dp_px - b.intercept_dp_px;
        sum += error * error;
        ++count;
      }
    }
  }
  return std::sqrt(sum / count);
}

nlohmann::ordered_json bench_one(const std::string& path, const simulator::Simulation& s,
                                 const simulator::RenderScene& world, const glm::mat4& pose) {
  const simulator::Lens lens = simulator::read_lens_file(path, s.lens.thin.focus_distance_m);
  if (simulator::image_radius_mm(lens) == 0)
    throw InputError(printable(path) + ": /model: a thin lens has no image circle to fill");
  const double radius_m = 1e-3 * simulator::image_radius_mm(lens);
  const simulator::SensorGrid sensor{1344, 1008, radius_m * 2 / std::hypot(1344, 1008), {672, 504}};
  const std::vector<simulator::LensCandidate> models = simulator::lens_candidates(lens);
  std::vector<simulator::CameraView> cameras;
  std::vector<double> ready_s, render_s(models.size(), 1e30);
  for (const simulator::LensCandidate& model : models) {
    ready_s.push_back(seconds([&] { cameras.push_back({pose, {model.lens, sensor}}); }));
  }
  // turn by turn, so that a busy machine slows all of them
  constexpr int kSamples = 16;
  for (int repeat = 0; repeat < 3; ++repeat) {
    for (std::size_t i = 0; i < models.size(); ++i) {
      render_s[i] = std::min(render_s[i], seconds([&] {
                               simulator::render_views(world, cameras[i], {kSamples, 0, 1});
                             }));
    }
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const double samples = 1344.0 * 1008.0 * kSamples;
  for (std::size_t i = 0; i < models.size(); ++i) {
    rows.push_back({{"model", models[i].name},
                    {"ready_s", ready_s[i]},
                    {"samples_per_core_s", samples / render_s[i]},
                    {"time_over_thin", render_s[i] / render_s[0]},
                    {"disparity_error_dp_px", disparity_error(cameras[i].lens, cameras.back().lens)}});
  }
  return {{"lens", lens.name}, {"file", path}, {"models", rows}};
}

std::string to_page(const nlohmann::ordered_json& results, const std::string& scene) {
  evaluation::Plot plot;
  plot.title = "What a lens model costs, and what it misses";
  plot.x_label = "time of a sample over the thin lens's";
  plot.y_label = "disparity error, DP px RMS";
  plot.log_y = true;
  std::string rows =
      "<table><tr><th>lens</th><th>model</th><th>ready, s</th><th>M samples/core-s</th><th>time/thin</th>"
      "<th>disparity error, DP px</th></tr>";
  for (const auto& result : results) {
    evaluation::Series line{result["lens"], {}, true, false};
    for (const auto& row : result["models"]) {
      // the exact trace is what the others are held against: it is drawn at the bottom
      const double error = std::max(row["disparity_error_dp_px"].get<double>(), 1e-4);
      line.points.emplace_back(row["time_over_thin"].get<double>(), error);
      rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.4f}</td></tr>",
                          evaluation::escape_html(printable(result["lens"].get<std::string>())),
                          evaluation::escape_html(row["model"].get<std::string>()), row["ready_s"].get<double>(),
                          row["samples_per_core_s"].get<double>() / 1e6, row["time_over_thin"].get<double>(),
                          row["disparity_error_dp_px"].get<double>());
    }
    plot.series.push_back(line);
  }
  const std::string body =
      "<h1>Lens models: time against error</h1><p>From left to right along each line: thin lens, aberrated twin, "
      "fitted "
      "polynomials, exact trace (the reference, drawn at 0.0001). Scene: " +
      evaluation::escape_html(printable(scene)) + ", one thread, 16 samples a photosite.</p><div class=\"plots\">" +
      evaluation::svg_plot(plot) + "</div><div class=\"scroll\">" + rows + "</table></div>";
  return evaluation::html_page("Lens models: time against error",
                               std::string(evaluation::kReportStyle) + evaluation::kPlotStyle, body);
}

void run(const BenchLensOptions& options) {
  const simulator::Simulation s = simulator::read_simulation(read_json_file(options.scene), options.scene);
  const simulator::Scene scene = simulator::load_scene(s);
  const simulator::RenderScene world(scene);
  const glm::mat4 pose = simulator::camera_pose(s, scene);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  for (const std::string& lens : options.lenses) results.push_back(bench_one(lens, s, world, pose));
  if (!options.page.empty()) replace_file(options.page, to_page(results, options.scene));
  if (options.json) {
    std::cout << nlohmann::ordered_json{{"scene", options.scene}, {"lenses", results}}.dump(2) << '\n';
    return;
  }
  for (const auto& result : results) {
    std::cout << fmt::format("{} in {}\n{:<16}{:>10}{:>18}{:>12}{:>26}\n", printable(result["lens"].get<std::string>()),
                             printable(options.scene), "model", "ready, s", "M samples/core-s", "time/thin",
                             "disparity error, DP px");
    for (const auto& row : result["models"]) {
      std::cout << fmt::format("{:<16}{:>10.2f}{:>18.2f}{:>12.2f}{:>26.4f}\n", row["model"].get<std::string>(),
                               row["ready_s"].get<double>(), row["samples_per_core_s"].get<double>() / 1e6,
                               row["time_over_thin"].get<double>(), row["disparity_error_dp_px"].get<double>());
    }
  }
}

}  // namespace

void add_bench_lens(CLI::App& bench) {
  auto options = std::make_shared<BenchLensOptions>();
  CLI::App* command = bench.add_subcommand("lens", "Time each model of a lens, and what it costs in disparity");
  command->add_option("lens", options->lenses, "Lens files (default: two phones' and a full-frame 50 mm)")
      ->type_name("LENS.json");
  command->add_option("--scene", options->scene, "Scene JSON file")->type_name("SCENE.json")->capture_default_str();
  command->add_option("-o,--output", options->page, "Write a page with the chart")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  dualpixel bench lens lens_models/phone_6p_4.2mm_f1.8.json -o bench-lens.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
