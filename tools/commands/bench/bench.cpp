#include <fmt/format.h>

#include <cstring>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/json_fields.h"
#include "capture/timing.h"
#include "pipeline/portrait/run_portrait.h"
#include "simulator/simulate.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchOptions {
  std::string scene = "build/release/scenes/portrait.json";
  bool json = false;
};

/// The pipeline on a capture of this scene, all cores, against copying its nine frames in memory once.
nlohmann::json bench_pipeline(simulator::Simulation s, const simulator::Scene& scene) {
  s.render.samples_per_pixel = s.photograph_samples_per_pixel = s.all_in_focus_samples_per_pixel = 1;
  Capture capture = simulator::simulate(s, scene);
  capture.truth.reset();
  double best_s = 1e30;
  nlohmann::json stages;
  for (int repeat = 0; repeat < 3; ++repeat) {
    pipeline::PortraitResult result;
    const double time_s = seconds([&] { result = pipeline::run_portrait(capture, {}); });
    if (time_s >= best_s) continue;
    best_s = time_s;
    stages = nlohmann::json::object();
    for (const pipeline::StageTime& stage : result.stages) stages[stage.name] = stage.ms;
  }
  std::vector<ImageU16> copies(capture.frames.size());
  for (std::size_t i = 0; i < copies.size(); ++i) copies[i] = capture.frames[i].mosaic;  // touch the pages
  const double copy_s = seconds([&] {
    for (std::size_t i = 0; i < copies.size(); ++i) {
      std::memcpy(copies[i].data.data(), capture.frames[i].mosaic.data.data(), copies[i].data.size() * 2);
    }
  });
  return {{"dp_ms", best_s * 1e3},
          {"burst_copy_ms", copy_s * 1e3},
          {"ratio_to_copy", best_s / copy_s},
          {"stages_ms", stages}};
}

void run(const BenchOptions& options) {
  const simulator::Simulation s = simulator::read_simulation(read_json_file(options.scene), options.scene);
  const nlohmann::json pipeline = bench_pipeline(s, simulator::load_scene(s));
  if (options.json) {
    std::cout << nlohmann::json{{"pipeline", pipeline}}.dump(2) << '\n';
    return;
  }
  std::cout << fmt::format("pipeline  {:6.0f} ms (dp); copying the burst {:6.1f} ms; ratio {:.0f}\n",
                           pipeline["dp_ms"].get<double>(), pipeline["burst_copy_ms"].get<double>(),
                           pipeline["ratio_to_copy"].get<double>());
  for (const auto& [name, ms] : pipeline["stages_ms"].items()) {
    std::cout << fmt::format("  {:<12}{:8.0f} ms\n", name, ms.get<double>());
  }
}

}  // namespace

void add_bench(CLI::App& program) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = program.add_subcommand(
      "bench", "Time the pipeline against a copy of its input; see the subcommands for the rest");
  command->add_option("scene", options->scene, "Scene JSON file (default: build/release/scenes/portrait.json)")
      ->type_name("SCENE.json");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  dualpixel bench build/release/scenes/portrait.json\n  dualpixel bench lens "
      "lens_models/phone_6p_4.2mm_f1.8.json");
  add_bench_lens(*command);
  add_bench_defocus(*command);
  add_bench_disparity(*command);
  add_bench_edges(*command);
  add_bench_render(*command);
  add_threads_option(*command);
  for (CLI::App* subcommand : command->get_subcommands({})) add_threads_option(*subcommand);
  command->callback([options, command] {
    if (command->get_subcommands().empty()) run(*options);
  });
}

}  // namespace dualpixel::tools
