#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/benchmarks/render_benchmark.h"
#include "tools/cli/number_range.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct BenchRenderOptions {
  std::vector<std::string> scenes = {"build/release/scenes/portrait.json", "build/release/scenes/slanted_planes.json",
                                     "build/release/scenes/occlusion_edges.json",
                                     "build/release/scenes/calibration_target.json"};
  std::string output;
  evaluation::RenderBenchmarkOptions render;
  double most_triangles = 1e7;
};

void run(const BenchRenderOptions& options) {
  NewFolder folder(options.output, "render.json");  // what cannot be written is refused first
  std::vector<evaluation::SceneRenderBenchmark> scenes;
  nlohmann::ordered_json json = {{"scenes", nlohmann::ordered_json::array()}};
  for (const std::string& scene : options.scenes) {
    Progress progress(scene);
    scenes.push_back(
        evaluation::measure_rendering(scene, options.render, [&](double fraction) { progress(fraction); }));
    json["scenes"].push_back(to_json(scenes.back()));
  }
  Progress progress("growth");
  const evaluation::RenderScaling scaling =
      evaluation::measure_scaling(options.most_triangles, [&](double fraction) { progress(fraction); });
  json["growth"] = to_json(scaling);
  write_file(folder.path() + "/render.html", to_page(scenes, scaling));
  write_file(folder.path() + "/render.json", json.dump(2) + "\n");
  folder.commit();
}

}  // namespace

void add_bench_render(CLI::App& bench) {
  auto options = std::make_shared<BenchRenderOptions>();
  CLI::App* command = bench.add_subcommand(
      "render", "Chart the renderer's error against its time and against the time of Embree alone");
  command->add_option("scene", options->scenes, "Scene JSON files (default: the shipped ones)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->output, "Folder for render.json and render.html")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--reference-samples", options->render.reference_samples,
                   "Samples per photosite of each of the reference's two renders")
      ->check(CLI::Range(16, 65536))
      ->capture_default_str();
  command
      ->add_option("--most-samples", options->render.most_samples, "Most samples per photosite of the charted renders")
      ->check(CLI::Range(32, 65536))
      ->capture_default_str();
  command
      ->add_option("--most-triangles", options->most_triangles, "Most triangles in the chart of cost over scene size")
      ->check(number_range(1e4, 1e8))
      ->capture_default_str();
  command->footer("Example:\n  dualpixel bench render build/release/scenes/portrait.json -o bench");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
