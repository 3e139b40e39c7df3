#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/experiments/noise_experiment.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_noise(CLI::App& experiment) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = experiment.add_subcommand(
      "noise", "Noise of disparity over light, from one frame and from six, and noise of depth over depth");
  command->add_option("-o,--output", *folder, "Folder to write noise.json and noise.html into")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment noise -o out/noise");
  command->callback([folder] {
    NewFolder out(*folder, "noise.json");
    Progress bar("noise");
    const evaluation::NoiseExperimentOptions options;
    const evaluation::NoiseExperiment measured =
        evaluation::measure_noise(options, [&](double fraction) { bar(fraction); });
    write_file(out.path() + "/noise.html", evaluation::to_page(measured, options));
    write_file(out.path() + "/noise.json", evaluation::to_json(measured, options).dump(2) + "\n");
    out.commit();
    print_written(*folder + "/noise.html");
  });
}

}  // namespace dualpixel::tools
