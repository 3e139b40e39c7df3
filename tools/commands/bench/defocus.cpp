#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "capture/timing.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/render.h"
#include "pipeline/defocus/scatter.h"
#include "pipeline/portrait/run_portrait.h"
#include "simulator/simulate.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchDefocusOptions {
  std::string scene = "build/release/scenes/portrait.json";
  std::string page;
  bool json = false;
};

using pipeline::Mode;

/// Rows of the paper's Table 4, milliseconds on a phone with eight cores, with the stages here that do the same.
struct PaperRow {
  std::string name;
  double paper_ms = 0;
  Mode mode = Mode::dp;
  std::vector<std::string> stages;
};

const std::vector<PaperRow>& paper_rows() {
  static const std::vector<PaperRow> rows = {
      {"burst", 190, Mode::dp, {"merge"}},
      {"disparity", 817, Mode::dp, {"disparity", "smooth", "upsample"}},
      {"depth renderer", 1241, Mode::dp, {"blur", "noise"}},
      {"mask filtering", 1048, Mode::seg, {"mask"}},
      {"mask renderer", 546, Mode::seg, {"blur", "noise"}},
      {"what the paper does not count", std::numeric_limits<double>::quiet_NaN(), Mode::dp, {"demosaic", "display"}}};
  return rows;
}

/// A burst at the scene's full size. Enough samples that its noise is a camera's: grain from rendering would fill the
/// bilateral grid with colours that no picture has, and smoothing would take three times as long.
Capture render_burst(const std::string& scene_file) {
  nlohmann::json document = read_json_file(scene_file);
  for (const char* assignment : {"render.samples_per_pixel=32", "render.photograph_samples_per_pixel=1",
                                 "render.all_in_focus_samples_per_pixel=1"}) {
    apply_override(document, assignment);
  }
  const simulator::Simulation s = simulator::read_simulation(document, scene_file);
  return simulator::simulate(s, simulator::load_scene(s));
}

/// Best wall time of each stage, and of the whole with its CPU time.
nlohmann::ordered_json time_mode(const Capture& capture, Mode mode, const std::optional<Image>& mask) {
  pipeline::PortraitOptions options;
  options.mode = mode;
  pipeline::PortraitResult best;
  double wall_ms = std::numeric_limits<double>::infinity(), cpu_ms = wall_ms;
  for (int repeat = 0; repeat < 5; ++repeat) {
    pipeline::PortraitResult result;
    const std::clock_t start = std::clock();
    const double ms = 1e3 * seconds([&] { result = pipeline::run_portrait(capture, options, mask); });
    cpu_ms = std::min(cpu_ms, 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    if (ms < wall_ms) best = std::move(result);
    wall_ms = std::min(wall_ms, ms);
  }
  nlohmann::ordered_json stages;
  for (const pipeline::StageTime& stage : best.stages) stages[stage.name] = stage.ms;
  return {{"ms", wall_ms}, {"cpu_ms", cpu_ms}, {"stages_ms", stages}};
}

/// Both scatters of the working resolution's whole picture by one radius, r in pixels of the full one.
nlohmann::ordered_json time_radii(int width, int height) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const double radius_px : {3.0, 4.0, 5.5, 8.0, 11.0, 15.0, 20.0, 30.0, 40.0, 60.0}) {
    const pipeline::Layer layer{Image(width / 2, height / 2, 4, 0.5f),
                                Image(width / 2, height / 2, 1, static_cast<float>(radius_px / 2))};
    Image behind(width / 2, height / 2, 4);
    const bool direct = radius_px <= 20;
    std::vector<std::function<void()>> work = {[&] { scatter_gradient(layer, behind); }};
    if (direct) work.emplace_back([&] { scatter_direct(layer, behind); });
    const Times best = times(work, 3);
    nlohmann::ordered_json row = {
        {"radius_px", radius_px}, {"gradient_ms", best.ms[0]}, {"gradient_cpu_ms", best.cpu_ms[0]}};
    if (direct) row.update({{"direct_ms", best.ms[1]}, {"direct_cpu_ms", best.cpu_ms[1]}});
    rows.push_back(row);
  }
  return rows;
}

/// The renderers by themselves, on the pictures of a run, and with the largest radius everywhere.
nlohmann::ordered_json time_renderers(const Capture& capture, const Image& mask) {
  const pipeline::PortraitResult result = pipeline::run_portrait(capture);
  const int width = result.input.width, height = result.input.height;
  const pipeline::BlurMapping mapping =
      pipeline::make_blur_mapping(capture.camera.focus_distance_m, result.focus_disparity_dp_px, width, false);
  // a wall far behind, blurred by 30 px wherever one looks
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
  nlohmann::ordered_json json;
  for (std::size_t i = 0; i < std::size(names); ++i) json[names[i]] = {{"ms", best.ms[i]}, {"cpu_ms", best.cpu_ms[i]}};
  return json;
}

double stage_sum(const nlohmann::ordered_json& results, const PaperRow& row) {
  const auto& stages = results["modes"][row.mode == Mode::dp ? "dp" : "seg"]["stages_ms"];
  double sum = 0;
  for (const std::string& stage : row.stages) sum += stages[stage].get<double>();
  return sum;
}

std::string to_text(const nlohmann::ordered_json& results) {
  std::string text = fmt::format("{:<34}{:>10}{:>12}{:>12}\n", "", "ms", "CPU ms", "paper ms");
  for (const PaperRow& row : paper_rows()) {
    text += fmt::format("{:<34}{:>10.0f}{:>12}{:>12.0f}\n", row.name, stage_sum(results, row), "", row.paper_ms);
  }
  for (const auto& [name, paper_ms] : {std::pair{"dp", 2134.0}, {"seg", 3343.0}, {"dp+seg", 3854.0}}) {
    const auto& mode = results["modes"][name];
    text += fmt::format("{:<34}{:>10.0f}{:>12.0f}{:>12.0f}   peak {:.0f} MB over the burst's\n",
                        std::string("mode ") + name, mode["ms"].get<double>(), mode["cpu_ms"].get<double>(), paper_ms,
                        mode["peak_mb"].get<double>());
  }
  for (const auto& [name, row] : results["renderers"].items()) {
    text += fmt::format("{:<34}{:>10.0f}{:>12.0f}\n", name, row["ms"].get<double>(), row["cpu_ms"].get<double>());
  }
  text += fmt::format("\n{:>10}{:>18}{:>18}\n", "r, px", "gradient, CPU ms", "direct, CPU ms");
  for (const auto& row : results["radii"]) {
    text += fmt::format("{:>10.1f}{:>18.1f}{:>18.1f}\n", row["radius_px"].get<double>(),
                        row["gradient_cpu_ms"].get<double>(), row.value("direct_cpu_ms", std::nan("")));
  }
  return text;
}

std::string to_page(const nlohmann::ordered_json& results) {
  evaluation::Plot plot;
  plot.title = "Cost of a blur";
  plot.x_label = "radius, full-resolution px";
  plot.y_label = "CPU ms";
  plot.log_x = plot.log_y = true;
  plot.series = {
      {"gradients on the rims", {}, false, false}, {"brute force", {}, false, false}, {"r", {}, true, false}};
  const double unit = results["radii"].back()["gradient_cpu_ms"].get<double>() / 60;
  for (const auto& row : results["radii"]) {
    const double radius = row["radius_px"];
    plot.series[0].points.emplace_back(radius, row["gradient_cpu_ms"].get<double>());
    if (row.contains("direct_cpu_ms")) plot.series[1].points.emplace_back(radius, row["direct_cpu_ms"].get<double>());
    plot.series[2].points.emplace_back(radius, unit * radius);
  }
  std::string body =
      "<h1>Defocus: time</h1><p>A burst at full size, all cores; the best of five. The paper's times are those of its "
      "Table 4, a phone with eight cores; faces and segmentation are not among them.</p><div class=\"scroll\"><table>"
      "<tr><th></th><th>ms</th><th>paper, ms</th></tr>";
  for (const PaperRow& row : paper_rows()) {
    body += fmt::format("<tr><td>{}</td><td>{:.0f}</td><td>{}</td></tr>", row.name, stage_sum(results, row),
                        std::isnan(row.paper_ms) ? "" : fmt::format("{:.0f}", row.paper_ms));
  }
  body += "</table></div><div class=\"scroll\"><table><tr><th></th><th>ms</th><th>CPU ms</th></tr>";
  for (const auto& [name, mode] : results["modes"].items()) {
    body += fmt::format("<tr><td>mode {}</td><td>{:.0f}</td><td>{:.0f}</td></tr>", name, mode["ms"].get<double>(),
                        mode["cpu_ms"].get<double>());
  }
  for (const auto& [name, row] : results["renderers"].items()) {
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    body += fmt::format("<tr><td>{}</td><td>{:.0f}</td><td>{:.0f}</td></tr>", words, row["ms"].get<double>(),
                        row["cpu_ms"].get<double>());
  }
  body += "</table></div><div class=\"plots\">" + evaluation::svg_plot(plot) + "</div>";
  return evaluation::html_page("Defocus: time", std::string(evaluation::kReportStyle) + evaluation::kPlotStyle, body);
}

void run(const BenchDefocusOptions& options) {
  Capture capture = render_burst(options.scene);
  const Image mask = capture.truth->person_mask;
  capture.truth.reset();
  nlohmann::ordered_json results;
  for (const auto& [name, mode] : {std::pair{"dp", Mode::dp}, {"seg", Mode::seg}, {"dp+seg", Mode::dp_seg}}) {
    results["modes"][name] = time_mode(capture, mode, mask);
    pipeline::PortraitOptions portrait;
    portrait.mode = mode;
    results["modes"][name]["peak_mb"] = peak_mb([&] { pipeline::run_portrait(capture, portrait, mask); });
  }
  results["renderers"] = time_renderers(capture, mask);
  results["radii"] = time_radii(capture.camera.width_px, capture.camera.height_px);
  if (!options.page.empty()) replace_file(options.page, to_page(results));
  std::cout << (options.json ? results.dump(2) + "\n" : to_text(results));
}

}  // namespace

void add_bench_defocus(CLI::App& bench) {
  auto options = std::make_shared<BenchDefocusOptions>();
  CLI::App* command = bench.add_subcommand(
      "defocus", "Time the renderers and each stage beside the paper's Table 4; cost against radius; memory");
  command->add_option("scene", options->scene, "Scene JSON file (default: build/release/scenes/portrait.json)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->page, "Write a page with the chart")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  dualpixel bench defocus -o bench-defocus.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
