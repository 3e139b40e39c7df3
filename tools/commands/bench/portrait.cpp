#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/names.h"
#include "evaluation/benchmarks/portrait_benchmark.h"
#include "pipeline/disparity/matchers.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_bench_portrait(CLI::App& bench) {
  struct BenchPortraitOptions {
    std::vector<std::string> captures;
    std::string matcher = "paper";
    bool json = false;
  };
  auto options = std::make_shared<BenchPortraitOptions>();
  CLI::App* command = bench.add_subcommand(
      "portrait", "Time the whole portrait on captures by stage and mode, people found, beside the paper's Table 4");
  command->add_option("capture", options->captures, "Captures with views and a mosaic")
      ->required()
      ->type_name("CAPTURE");
  command->add_option("--matcher", options->matcher, "Matches the views")
      ->check(CLI::IsMember(names_of(pipeline::matchers())))
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Examples: a burst of 5.4 megapixels, as the paper's, and the 24 small scenes of `experiment methods`\n  "
      "dualpixel "
      "bench portrait out/capture\n  dualpixel bench portrait out/methods/captures/*");
  command->callback([options] {
    Progress bar("bench portrait");
    const evaluation::PortraitBenchmark benchmark =
        evaluation::measure_portraits(options->captures, options->matcher, [&](double fraction) { bar(fraction); });
    std::cout << (options->json ? evaluation::to_json(benchmark).dump(2) + "\n" : evaluation::to_text(benchmark));
  });
}

}  // namespace dualpixel::tools
