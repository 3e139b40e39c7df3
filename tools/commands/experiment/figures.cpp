#include <memory>

#include "capture/names.h"
#include "evaluation/experiments/paper_figures.h"
#include "evaluation/report/calibration_page.h"
#include "evaluation/report/page.h"
#include "pipeline/disparity/matchers.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_figures(CLI::App& experiment) {
  struct FiguresCommand {
    std::string capture, calibration, output;
    evaluation::PaperFigures figures;
  };
  auto command = std::make_shared<FiguresCommand>();
  CLI::App* sub = experiment.add_subcommand(
      "figures",
      "The paper's figures of single steps, of one capture: burst, calibration, sharp range, discs, noise, people");
  sub->add_option("capture", command->capture, "Capture with views and a mosaic, best a burst")
      ->required()
      ->type_name("CAPTURE");
  sub->add_option("--calibration", command->calibration, "Result of `dualpixel calibrate` for this camera: adds Fig. 8")
      ->type_name("DIR");
  sub->add_option("--matcher", command->figures.matcher, "Matches the views")
      ->check(CLI::IsMember(names_of(pipeline::matchers())))
      ->capture_default_str();
  sub->add_option("-o,--output", command->output, "The page to write")->required()->type_name("FILE.html");
  add_threads_option(*sub);
  sub->footer(
      "Example:\n  dualpixel simulate build/release/scenes/portrait.json -o out/capture\n  dualpixel experiment "
      "figures out/capture -o out/figures.html");
  sub->callback([command] {
    evaluation::require_page_path(command->output);
    evaluation::PaperFigures& figures = command->figures;
    figures.capture = read_capture(command->capture, false);
    if (!command->calibration.empty()) {
      figures.calibration = evaluation::read_calibration_folder(command->calibration);
    }
    Progress bar("figures");
    evaluation::write_page(command->output,
                           evaluation::paper_figures_page(figures, [&](double fraction) { bar(fraction); }));
  });
}

}  // namespace dualpixel::tools
