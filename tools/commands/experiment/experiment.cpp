#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment(CLI::App& program) {
  CLI::App* experiment = program.add_subcommand(
      "experiment", "Measure what the simulator and the pipeline do, over a sweep: charts and JSON");
  experiment->require_subcommand(1);
  experiment->footer("Example:\n  dualpixel experiment failures -o out/failures");
  add_experiment_aberrations(*experiment);
  add_experiment_burst(*experiment);
  add_experiment_calibration(*experiment);
  add_experiment_defocus(*experiment);
  add_experiment_failures(*experiment);
  add_experiment_figures(*experiment);
  add_experiment_methods(*experiment);
  add_experiment_noise(*experiment);
  add_experiment_scenes(*experiment);
  add_experiment_segmentation(*experiment);
  add_experiment_stages(*experiment);
  add_experiment_votes(*experiment);
}

}  // namespace dualpixel::tools
