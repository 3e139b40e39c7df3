#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/experiments/burst_experiment.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_burst(CLI::App& experiment) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = experiment.add_subcommand(
      "burst",
      "Bursts of 1 to 15 frames at rest, in a shaking hand, of a moving arm and in flickering light: noise, "
      "ghosts, disparity, portrait and time");
  command->add_option("-o,--output", *folder, "Folder to write burst.json and burst.html into")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment burst -o out/burst");
  command->callback([folder] {
    NewFolder out(*folder, "burst.json");
    Progress bar("burst");
    const std::vector<evaluation::BurstSweep> sweeps =
        evaluation::measure_bursts([&](double fraction) { bar(fraction); });
    write_file(out.path() + "/burst.html", evaluation::to_page(sweeps));
    write_file(out.path() + "/burst.json", evaluation::to_json(sweeps).dump(2) + "\n");
    out.commit();
    print_written(*folder + "/burst.html");
  });
}

}  // namespace dualpixel::tools
