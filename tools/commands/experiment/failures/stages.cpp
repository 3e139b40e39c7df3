#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/stage_failures/stage_failures.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_stages(CLI::App& experiment) {
  struct Options {
    std::string folder;
    std::vector<std::string> rows;
    unsigned draws = 3;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = experiment.add_subcommand(
      "stages",
      "Sweep each way in which the other stages fail: burst, calibration, edge-aware smoothing, person mask, defocus");
  command
      ->add_option("-o,--output", options->folder,
                   "Folder to write stages.json and stages.html into; an older result there is replaced")
      ->required()
      ->type_name("DIR");
  command
      ->add_option("--row", options->rows,
                   "This row alone, or all rows of this stage (burst, calibration, edges, people, defocus); repeat for "
                   "several. An unknown name lists all names")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->type_name("NAME");
  command->add_option("--draws", options->draws, "Textures, noises or people that each figure is the mean of")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel experiment stages -o out/stages\n"
      "  dualpixel experiment stages -o out/masks --row people --row wrong_mask --draws 10");
  command->callback([options] {
    const std::vector<evaluation::StageRow> rows = evaluation::stage_rows_named(options->rows);
    NewFolder out(options->folder, "stages.json");
    Progress bar("stages");
    std::vector<evaluation::StageSweep> sweeps;
    for (const evaluation::StageRow& row : rows) {
      const auto done = static_cast<double>(sweeps.size());
      sweeps.push_back(evaluation::measure_stage_row(
          row, options->draws, [&](double fraction) { bar((done + fraction) / static_cast<double>(rows.size())); }));
    }
    write_file(out.path() + "/stages.html", evaluation::to_page(sweeps, options->draws));
    write_file(out.path() + "/stages.json", evaluation::to_json(sweeps, options->draws).dump(2) + "\n");
    out.commit();
    print_written(options->folder + "/stages.html");
  });
}

}  // namespace dualpixel::tools
