#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/report/lens_page.h"
#include "evaluation/report/page.h"
#include "simulator/lens/aberrated/aberrated_json.h"
#include "simulator/lens/aberrated/aberrated_twin.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/lens_report.h"
#include "tools/cli/number_range.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct LensOptions {
  std::string file;
  std::vector<std::string> overrides;
  simulator::LensView view;
  std::string page;
  std::string twin;
  bool json = false;
};

void run(const LensOptions& options) {
  std::error_code error;
  if (std::filesystem::equivalent(options.file, options.twin, error)) {
    throw InputError("--twin " + printable(options.twin) + ": is the lens itself: it will not be overwritten");
  }
  nlohmann::json json = read_json_file(options.file);
  simulator::apply_overrides(json, options.overrides);
  const simulator::LensReport report = simulator::report_lens(json, options.file, options.view);
  std::string twin;
  if (!options.twin.empty()) {
    if (!simulator::prescription_of(report.lens)) {
      throw InputError(printable(options.file) + ": /model: --twin needs a prescription");
    }
    try {
      twin = simulator::aberrated_lens_json(simulator::aberrated_twin(report.lens)).dump(2) + '\n';
    } catch (const InputError& error) {
      throw InputError(printable(options.file) + ": /" + error.what());
    }
  }
  if (!options.twin.empty()) replace_file(options.twin, twin);
  if (!options.page.empty()) evaluation::write_page(options.page, evaluation::lens_page(report));
  std::cout << (options.json ? simulator::to_json(report).dump(2) + '\n' : simulator::to_text(report));
}

}  // namespace

void add_lens(CLI::App& program) {
  auto options = std::make_shared<LensOptions>();
  CLI::App* command = program.add_subcommand("lens", "Print and plot what a lens does");
  command->add_option("lens", options->file, "Lens file, camera file or scene file")
      ->required()
      ->type_name("LENS.json");
  command
      ->add_option("--focus-distance-m", options->view.focus_distance_m,
                   "From the entrance pupil; inf is allowed. Default: the scene's, else 1")
      ->check(number_range(simulator::kNearestLensFocus_m, std::numeric_limits<double>::infinity()));
  add_overrides_option(*command, options->overrides, "f_number=4");
  command->add_option("--sensor-width-px", options->view.width_px, "Default: the file's, else 2688")
      ->check(CLI::Range(simulator::kLensViewSide_px[0], simulator::kLensViewSide_px[1]));
  command->add_option("--sensor-height-px", options->view.height_px, "Default: the file's, else 2016")
      ->check(CLI::Range(simulator::kLensViewSide_px[0], simulator::kLensViewSide_px[1]));
  command
      ->add_option("--pixel-pitch-um", options->view.pixel_pitch_um,
                   "Default: the file's, else the sensor fills the lens's picture")
      ->check(number_range(simulator::kLensViewPitch_um[0], simulator::kLensViewPitch_um[1]));
  command->add_option("-o,--output", options->page, "Write a page with all plots")->type_name("PAGE.html");
  command->add_option("--twin", options->twin, "Fit an aberrated lens to a prescription and write it")
      ->type_name("LENS.json");
  command->add_flag("--json", options->json, "Print JSON");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel lens lens_models/phone_6p_4.2mm_f1.8.json --focus-distance-m 0.5 -o lens.html\n"
      "  dualpixel lens build/release/scenes/cameras/phone_2019.json -o camera.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
