#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/experiments/defocus_experiment.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct ExperimentDefocusOptions {
  std::string folder;
  std::vector<std::string> scenes = {"build/release/scenes/portrait.json", "build/release/scenes/slanted_planes.json",
                                     "build/release/scenes/occlusion_edges.json"};
};

void run(const ExperimentDefocusOptions& options) {
  NewFolder out(options.folder, "defocus.json");
  Progress bar("defocus");
  std::vector<evaluation::SceneDefocus> scenes;
  for (const std::string& file : options.scenes) {
    scenes.push_back(evaluation::measure_scene_defocus(file));
    bar(static_cast<double>(scenes.size()) / static_cast<double>(options.scenes.size() + 1));
  }
  const std::vector<evaluation::HaloStep> halos = evaluation::measure_halo_sweep();
  bar(1);
  write_file(out.path() + "/defocus.json", evaluation::to_json(scenes, halos).dump(2) + "\n");
  write_file(out.path() + "/defocus.html", evaluation::to_page(scenes, halos));
  out.commit();
  print_written(options.folder + "/defocus.html");
}

}  // namespace

void add_experiment_defocus(CLI::App& experiment) {
  auto options = std::make_shared<ExperimentDefocusOptions>();
  CLI::App* command = experiment.add_subcommand(
      "defocus", "Synthetic defocus against the wide lens's photograph: loss by cause, order of methods, halos");
  command->add_option("scene", options->scenes, "Scene JSON files (default: the shipped ones that have depth)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->folder, "Folder to write defocus.json and defocus.html into")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment defocus -o out/defocus");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
