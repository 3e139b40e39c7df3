#include <fmt/format.h>

#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/report/lens_page.h"
#include "simulator/lens/aberrated/aberrated_json.h"
#include "simulator/lens/aberrated/aberrated_twin.h"
#include "simulator/lens/lens_file.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct LensOptions {
  std::string file;
  std::vector<std::string> overrides;
  double focus_distance_m = 1;
  int width_px = 2688;
  int height_px = 2016;
  double pixel_pitch_um = 0;  ///< 0: the sensor fills the lens's picture
  std::string page;
  std::string twin;
  bool json = false;
};

void run(const LensOptions& options) {
  nlohmann::json json = read_json_file(options.file);
  for (const std::string& assignment : options.overrides) apply_override(json, assignment);
  const simulator::Lens lens = simulator::read_lens(json, options.file, "", options.focus_distance_m);
  const simulator::SensorGrid sensor =
      simulator::sensor_for(lens, options.width_px, options.height_px, options.pixel_pitch_um);
  if (!options.twin.empty() && !simulator::prescription_of(lens)) {
    throw InputError(printable(options.file) + ": /model: --twin needs a prescription");
  }
  simulator::LensReport report;
  std::string twin;
  try {
    report = simulator::report_lens(lens, sensor);
    if (!options.twin.empty()) twin = simulator::aberrated_lens_json(simulator::aberrated_twin(lens)).dump(2) + '\n';
  } catch (const InputError& error) {
    throw InputError(printable(options.file) + ": /" + error.what());
  }
  if (!options.twin.empty()) replace_file(options.twin, twin);
  if (!options.page.empty()) replace_file(options.page, evaluation::lens_page(report));
  std::cout << (options.json ? simulator::to_json(report).dump(2) + '\n' : simulator::to_text(report));
}

}  // namespace

void add_lens(CLI::App& program) {
  auto options = std::make_shared<LensOptions>();
  CLI::App* command = program.add_subcommand("lens", "Print and plot what a lens does");
  command->add_option("lens", options->file, "Lens file")->required()->type_name("LENS.json");
  command->add_option("--focus-distance-m", options->focus_distance_m, "From the entrance pupil; inf is allowed")
      ->check(CLI::Range(0.001, std::numeric_limits<double>::infinity()))
      ->capture_default_str();
  add_overrides_option(*command, options->overrides, "f_number=4");
  command->add_option("--sensor-width-px", options->width_px)->check(CLI::Range(2, 32768))->capture_default_str();
  command->add_option("--sensor-height-px", options->height_px)->check(CLI::Range(2, 32768))->capture_default_str();
  command->add_option("--pixel-pitch-um", options->pixel_pitch_um, "Default: the sensor fills the lens's picture")
      ->check(CLI::Range(0.1, 1000.0));
  command->add_option("-o,--output", options->page, "Write a page with all plots")->type_name("PAGE.html");
  command->add_option("--twin", options->twin, "Fit an aberrated lens to a prescription and write it")
      ->type_name("LENS.json");
  command->add_flag("--json", options->json, "Print JSON");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel lens lens_models/phone_6p_4.2mm_f1.8.json --focus-distance-m 0.5 -o lens.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
