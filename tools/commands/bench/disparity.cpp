#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "evaluation/benchmarks/disparity_benchmark.h"
#include "evaluation/report/page.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchDisparityOptions {
  std::vector<std::string> scenes = {"build/release/scenes/portrait.json", "build/release/scenes/slanted_planes.json"};
  std::string page;
  bool json = false;
};

void run(const BenchDisparityOptions& options) {
  const evaluation::DisparityBenchmark benchmark = evaluation::measure_disparity(options.scenes);
  if (!options.page.empty()) evaluation::write_page(options.page, evaluation::to_page(benchmark));
  if (options.json) {
    std::cout << evaluation::to_json(benchmark).dump(2) << '\n';
    return;
  }
  std::cout << fmt::format("copying one view of 1344 x 1008: {:.2f} ms\n", benchmark.copy_ms);
  for (const auto& scene : benchmark.scenes) {
    std::cout << fmt::format("{}\n{:<20}{:>8}{:>8}{:>14}{:>12}{:>10}\n", printable(scene.scene), "method", "ms",
                             "copies", "RMSE, DP px", "> 0.5 px", "answered");
    for (const evaluation::MatcherBenchmark& m : scene.methods) {
      std::cout << fmt::format("{:<20}{:>8.1f}{:>8.0f}{:>14.3f}{:>12.3f}{:>10.3f}\n", m.method, m.ms,
                               m.ms / benchmark.copy_ms, m.rmse_dp_px, m.wrong_share, m.answered_share);
    }
  }
}

}  // namespace

void add_bench_disparity(CLI::App& bench) {
  auto options = std::make_shared<BenchDisparityOptions>();
  CLI::App* command = bench.add_subcommand(
      "disparity", "Time and error of every matcher, and of OpenCV's where built in, on rendered pairs");
  command->add_option("scene", options->scenes, "Scene JSON files (default: the portrait and the slanted planes)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->page, "Write a page with the chart")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  dualpixel bench disparity build/release/scenes/portrait.json -o bench-disparity.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
