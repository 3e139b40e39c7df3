#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/experiments/failure_atlas.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_failures(CLI::App& experiment) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = experiment.add_subcommand(
      "failures", "Sweep sixteen ways in which disparity fails: error and confidence of each matcher");
  command->add_option("-o,--output", *folder, "Folder for failures.json and failures.html")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment failures -o out/failures");
  command->callback([folder] {
    NewFolder out(*folder, "failures.json");
    Progress bar("failures");
    const std::vector<evaluation::FailureSweep> sweeps =
        evaluation::measure_failures([&](double fraction) { bar(fraction); });
    write_file(out.path() + "/failures.json", evaluation::to_json(sweeps).dump(2) + "\n");
    write_file(out.path() + "/failures.html", evaluation::to_page(sweeps));
    out.commit();
  });
}

}  // namespace dualpixel::tools
