#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "evaluation/benchmarks/defocus_benchmark.h"
#include "evaluation/report/page.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchDefocusOptions {
  std::string scene = "build/release/scenes/portrait.json";
  std::string page;
  bool json = false;
};

std::string to_text(const evaluation::DefocusBenchmark& benchmark) {
  std::string text = fmt::format("{:<34}{:>10}{:>12}\n", "", "ms", "CPU ms");
  for (const evaluation::RendererTime& renderer : benchmark.renderers) {
    text += fmt::format("{:<34}{:>10.0f}{:>12.0f}\n", renderer.name, renderer.ms, renderer.cpu_ms);
  }
  text += fmt::format("\n{:>10}{:>18}{:>18}\n", "r, px", "gradient, CPU ms", "direct, CPU ms");
  for (const evaluation::RadiusTime& row : benchmark.radii) {
    text += fmt::format("{:>10.1f}{:>18.1f}{:>18.1f}\n", row.radius_px, row.gradient_cpu_ms,
                        row.direct_cpu_ms.value_or(std::nan("")));
  }
  return text;
}

void run(const BenchDefocusOptions& options) {
  const evaluation::DefocusBenchmark benchmark = evaluation::measure_defocus_time(options.scene);
  if (!options.page.empty()) evaluation::write_page(options.page, evaluation::to_page(benchmark));
  std::cout << (options.json ? evaluation::to_json(benchmark).dump(2) + "\n" : to_text(benchmark));
}

}  // namespace

void add_bench_defocus(CLI::App& bench) {
  auto options = std::make_shared<BenchDefocusOptions>();
  CLI::App* command =
      bench.add_subcommand("defocus", "Time the renderers of defocus, and their cost against the radius");
  command->add_option("scene", options->scene, "Scene JSON file (default: build/release/scenes/portrait.json)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->page, "Write a page with the chart")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  dualpixel bench defocus -o bench-defocus.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
