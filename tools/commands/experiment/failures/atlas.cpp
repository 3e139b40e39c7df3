#include <memory>

#include "evaluation/failures/run_atlas.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_failures(CLI::App& experiment) {
  auto options = std::make_shared<evaluation::AtlasOptions>();
  auto folder = std::make_shared<std::string>();
  CLI::App* command = experiment.add_subcommand(
      "failures",
      "Sweep each way in which disparity fails, through a camera: where each method breaks, and whether it knows");
  command
      ->add_option("-o,--output", *folder,
                   "Folder for failures.json and failures.html; rows that it holds of the same options are kept")
      ->required()
      ->type_name("DIR");
  command
      ->add_option(
          "--camera", options->camera,
          "thin: the paper's phone; prescription: a six-element phone lens; a camera file (fit-camera) or a lens "
          "file; ideal: closed forms instead of rendering")
      ->capture_default_str()
      ->type_name("CAMERA");
  add_methods_option(*command, options->methods)
      ->description(
          "A matcher's name, with other options where they follow (split:split_match.window_px=9): these alone. "
          "NAME=COMMAND: another program beside them; see `dualpixel evaluate --help`");
  command
      ->add_option("--row", options->rows,
                   "This row alone, by its name; repeat for several. An unknown name lists all names")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->type_name("NAME");
  command->add_option("--draws", options->draws, "Textures and noises that each figure is of")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel experiment failures -o out/failures\n"
      "  dualpixel experiment failures -o out/noise --row noise --row texture --camera scenes/cameras/phone_2019.json\n"
      "  dualpixel experiment failures -o out/failures --method 'mine=./prog {left} {right} {out}'");
  command->callback([options, folder] {
    Progress bar("failures");
    evaluation::run_failure_atlas(*options, *folder, [&](double fraction) { bar(fraction); });
    bar(1);
    print_written(*folder + "/failures.html");
  });
}

}  // namespace dualpixel::tools
