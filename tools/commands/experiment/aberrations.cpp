#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/experiments/aberrations_experiment.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_aberrations(CLI::App& experiment) {
  struct Options {
    std::vector<std::string> scenes;
    std::string folder;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = experiment.add_subcommand("aberrations",
                                                "The disparity of a plane over the field of each camera, before and "
                                                "after calibration, and what is left by cause");
  command->add_option("cameras", options->scenes, "Scene files whose cameras are shown")
      ->required()
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->folder, "Folder to write aberrations.json and aberrations.html into")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel experiment aberrations build/release/scenes/lenses/phone_*.json -o out/aberrations");
  command->callback([options] {
    std::vector<simulator::Simulation> simulations;
    for (const std::string& scene : options->scenes) {
      simulations.push_back(simulator::read_simulation(read_json_file(scene), scene));
    }
    NewFolder out(options->folder, "aberrations.json");
    Progress bar("aberrations");
    std::vector<evaluation::AberratedField> fields;
    for (const simulator::Simulation& simulation : simulations) {
      evaluation::AberratedField& field = fields.emplace_back(evaluation::measure_aberrated_field(simulation));
      field.remainders = evaluation::measure_remainders(simulation, field.plane_m);
      bar(static_cast<double>(fields.size()) / static_cast<double>(simulations.size()));
    }
    write_file(out.path() + "/aberrations.html", evaluation::to_page(fields));
    write_file(out.path() + "/aberrations.json", to_json(fields).dump(2) + "\n");
    out.commit();
    print_written(options->folder + "/aberrations.html");
  });
}

}  // namespace dualpixel::tools
