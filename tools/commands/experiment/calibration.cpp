#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/experiments/calibration_cost.h"
#include "simulator/lens/lens_file.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_calibration(CLI::App& experiment) {
  struct Options {
    std::string scene, folder;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = experiment.add_subcommand(
      "calibration", "What fewer photographs, noise, another texture or a tilted target cost a calibration");
  command->add_option("camera", options->scene, "Scene file whose camera is calibrated")
      ->required()
      ->type_name("CAMERA.json");
  command
      ->add_option("-o,--output", options->folder,
                   "Folder to write calibration_cost.json and calibration_cost.html into")
      ->required()
      ->type_name("DIR");
  auto overrides = std::make_shared<std::vector<std::string>>();
  add_overrides_option(*command, *overrides, "lens.f_number=2.8");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel experiment calibration build/release/scenes/portrait.json --set "
      "lens.file=../lens_models/phone_aberrated_4.4mm_f1.8.json -o out/calibration_cost");
  command->callback([options, overrides] {
    nlohmann::json json = read_json_file(options->scene);
    simulator::apply_overrides(json, *overrides);
    const simulator::Simulation simulation = simulator::read_simulation(json, options->scene);
    NewFolder out(options->folder, "calibration_cost.json");
    Progress bar("calibration");
    const evaluation::CalibrationCost cost =
        evaluation::measure_calibration_cost(simulation, [&](double fraction) { bar(fraction); });
    write_file(out.path() + "/calibration_cost.html", evaluation::to_page(cost));
    write_file(out.path() + "/calibration_cost.json", evaluation::to_json(cost).dump(2) + "\n");
    out.commit();
    print_written(options->folder + "/calibration_cost.html");
  });
}

}  // namespace dualpixel::tools
