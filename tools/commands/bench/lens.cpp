#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "evaluation/benchmarks/lens_benchmark.h"
#include "evaluation/report/page.h"
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

void run(const BenchLensOptions& options) {
  const std::vector<evaluation::LensBenchmark> lenses = evaluation::measure_lenses(options.lenses, options.scene);
  if (!options.page.empty()) evaluation::write_page(options.page, evaluation::to_page(lenses, options.scene));
  if (options.json) {
    std::cout << evaluation::to_json(lenses, options.scene).dump(2) << '\n';
    return;
  }
  for (const evaluation::LensBenchmark& lens : lenses) {
    std::cout << fmt::format("{} in {}\n{:<16}{:>10}{:>18}{:>12}{:>26}\n", printable(lens.lens),
                             printable(options.scene), "model", "ready, s", "M samples/core-s", "time/thin",
                             "disparity error, DP px");
    for (const evaluation::LensModelCost& m : lens.models) {
      std::cout << fmt::format("{:<16}{:>10.2f}{:>18.2f}{:>12.2f}{:>26.4f}\n", m.model, m.ready_s,
                               m.samples_per_core_s / 1e6, m.time_over_thin, m.disparity_error_dp_px);
    }
  }
}

}  // namespace

void add_bench_lens(CLI::App& bench) {
  auto options = std::make_shared<BenchLensOptions>();
  CLI::App* command = bench.add_subcommand("lens", "Time and disparity error of each model of a lens");
  command->add_option("lens", options->lenses, "Lens files (default: two phones' and a full-frame 50 mm)")
      ->type_name("LENS.json");
  command->add_option("--scene-file", options->scene, "Scene JSON file")
      ->type_name("SCENE.json")
      ->capture_default_str();
  command->add_option("-o,--output", options->page, "Write a page with the chart")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  dualpixel bench lens lens_models/phone_6p_4.2mm_f1.8.json -o bench-lens.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
