#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/camera_fit/camera_fit.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct FitCameraOptions {
  std::string measurements;
  std::string output;
};

void run(const FitCameraOptions& options) {
  const evaluation::CameraMeasurements measured =
      evaluation::read_camera_measurements(read_json_file(options.measurements), options.measurements);
  print_warnings(measured.warnings);
  require_writable(options.output);
  const evaluation::CameraFit fit = evaluation::fit_camera(measured);
  replace_file(options.output, evaluation::camera_json(measured, fit.lens, options.output).dump(2) + '\n');
  const std::vector<evaluation::FigureScore> scores = evaluation::score_camera(measured, fit.lens);
  std::cout << evaluation::to_text(fit) << evaluation::to_text(scores);
  print_warnings(evaluation::warnings_of(scores), printable(options.measurements));
}

}  // namespace

void add_fit_camera(CLI::App& program) {
  auto options = std::make_shared<FitCameraOptions>();
  CLI::App* command = program.add_subcommand("fit-camera", "Fit a camera to figures measured on a real one");
  command->add_option("measurements", options->measurements, "File that docs/fit_camera.md describes")
      ->required()
      ->type_name("MEASUREMENTS.json");
  command->add_option("-o,--output", options->output, "Camera file, for a scene's camera.file")
      ->required()
      ->type_name("CAMERA.json");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel fit-camera tests/data/camera_fit/full_frame_measurements.json -o camera.json");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
