#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/error.h"
#include "evaluation/benchmarks/pipeline_benchmark.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchOptions {
  std::string scene = "build/release/scenes/portrait.json";
  bool json = false;
};

void run(const BenchOptions& options) {
  const evaluation::PipelineTime time = evaluation::measure_pipeline_time(options.scene);
  if (options.json) {
    std::cout << nlohmann::json{{"pipeline", to_json(time)}}.dump(2) << '\n';
    return;
  }
  std::cout << fmt::format("pipeline  {:6.0f} ms (dp); copying the burst {:6.1f} ms; ratio {:.0f}\n", time.dp_ms,
                           time.burst_copy_ms, time.dp_ms / time.burst_copy_ms);
  for (const pipeline::StageTime& stage : time.stages) {
    std::cout << fmt::format("  {:<12}{:8.0f} ms\n", stage.name, stage.ms);
  }
}

}  // namespace

void add_bench(CLI::App& program) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = program.add_subcommand(
      "bench", "Time the pipeline against a copy of its input, or one of its parts against accuracy");
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
  add_bench_portrait(*command);
  add_bench_render(*command);
  add_threads_option(*command);
  for (CLI::App* subcommand : command->get_subcommands({})) add_threads_option(*subcommand);
  command->callback([options, command] {
    if (!command->get_subcommands().empty()) return;
    std::vector<std::string> names;
    for (const CLI::App* benchmark : command->get_subcommands({})) names.push_back(benchmark->get_name());
    const std::string meant = did_you_mean(options->scene, names);
    if (!meant.empty() && !std::filesystem::exists(options->scene)) {
      throw InputError(fmt::format("bench {}: is no scene and no benchmark{}", printable(options->scene), meant));
    }
    run(*options);
  });
}

}  // namespace dualpixel::tools
