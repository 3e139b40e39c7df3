#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/calibration_sweep/calibration_captures.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/calibration_sweep/traced_skew.h"
#include "pipeline/calibration/calibration.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_sampler.h"
#include "tools/cli/number_range.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CalibrateOptions {
  std::string camera;
  std::string captures;
  std::string output;
  std::vector<std::string> overrides;
  evaluation::SweepOptions sweep;
};

/// Everything that the measurements of a sweep depend on; the lens by the disparities that it makes.
Json describe_sweep(const simulator::Simulation& simulation, const evaluation::SweepOptions& options) {
  print_warnings(simulation.warnings);
  const Camera camera = describe_camera(simulation);
  // focused as in the sweep: the scene's own focus does not matter
  const simulator::LensSampler lens = evaluation::focused_lens(simulation, options.nearest_focus_m);
  Json traced = Json::array();
  for (const double position : {0.5, 0.75, 0.95}) {
    const simulator::DisparityCoefficients c = trace_disparity(lens, static_cast<int>(position * camera.width_px),
                                                               static_cast<int>(position * camera.height_px), 1024);
    traced.push_back({c.slope_dp_px_m, c.intercept_dp_px, c.left_light, c.right_light});
  }
  return {{"format", "dualpixel-calibration-sweep"},
          {"version", 2},
          {"program", "dualpixel " DUALPIXEL_VERSION},
          {"camera", camera.name},
          {"size_px", {camera.width_px, camera.height_px}},
          {"dp_downsample", {camera.dp_downsample_x, camera.dp_downsample_y}},
          {"pixel_pitch_um", camera.pixel_pitch_um},
          {"lens_fingerprint", traced},
          {"focuses", options.focuses},
          {"targets", options.targets},
          {"nearest_focus_m", options.nearest_focus_m}};
}

/// Makes the folder of a new sweep, or checks that of one to be resumed.
void open_sweep(const std::string& folder, const Json& description) {
  const std::string file = folder + "/sweep.json";
  std::error_code error;
  if (fs::exists(file, error)) {
    if (nlohmann::json(description) != read_json_file(file)) {
      throw InputError(printable(file) + ": is a sweep of another camera or other settings; remove the folder " +
                       "or choose another one");
    }
  } else if (fs::exists(folder + "/calibration.json", error)) {
    throw InputError(printable(folder) + ": is a calibration that was not made by a sweep; choose a new folder");
  } else if (fs::exists(folder, error) && !holds_nothing(folder)) {
    throw InputError(printable(folder) + ": exists and is not a calibration; choose a new folder");
  }
  fs::create_directories(folder, error);
  if (error) throw InputError(printable(folder) + ": cannot be made: " + error.message());
  // written first: it tells an interrupted sweep from an unrelated folder
  replace_file(file, description.dump(2) + "\n");
  fs::create_directories(folder + "/measurements", error);
  if (error) throw InputError(printable(folder) + "/measurements: cannot be made: " + error.message());
}

void sweep_camera(const CalibrateOptions& options) {
  nlohmann::json json = read_json_file(options.camera);
  simulator::apply_overrides(json, options.overrides);
  const simulator::Simulation simulation = simulator::read_simulation(json, options.camera);
  const Camera camera = describe_camera(simulation);
  evaluation::require_focuses(simulation, options.sweep);
  open_sweep(options.output, describe_sweep(simulation, options.sweep));
  Progress bar("calibrate");
  pipeline::Calibration calibration = pipeline::fit_calibration(
      camera,
      evaluation::run_sweep(simulation, options.sweep, options.output + "/measurements", [&](double f) { bar(f); }));
  evaluation::add_traced_skew(simulation, calibration);
  replace_file(options.output + "/calibration.json", to_json(calibration).dump() + "\n");
  print_warnings(calibration.warnings);
}

void fit_captures(const CalibrateOptions& options) {
  NewFolder out(options.output, "calibration.json");
  Progress bar("calibrate");
  const auto [camera, measurements] =
      evaluation::measure_captures(options.captures, [&](double fraction) { bar(fraction); });
  const pipeline::Calibration calibration = pipeline::fit_calibration(camera, measurements);
  fs::create_directory(out.path() + "/measurements");
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    write_file(fmt::format("{}/measurements/capture_{:04}.json", out.path(), i),
               to_json(measurements[i]).dump() + "\n");
  }
  write_file(out.path() + "/calibration.json", to_json(calibration).dump() + "\n");
  out.commit();
  print_warnings(calibration.warnings);
}

void run(const CalibrateOptions& options) {
  if (options.camera.empty() == options.captures.empty()) {
    throw InputError("calibrate: give a scene file, whose camera is simulated, or --captures DIR");
  }
  if (options.captures.empty()) {
    sweep_camera(options);
  } else {
    fit_captures(options);
  }
}

}  // namespace

void add_calibrate(CLI::App& program) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* command = program.add_subcommand(
      "calibrate",
      "Measure how disparity depends on depth and field position, from a target swept over focus and distance; of a "
      "simulated camera also how both views' kernels skew over the field");
  CLI::Option* camera =
      command->add_option("camera", options->camera, "Scene file whose camera is simulated")->type_name("CAMERA.json");
  CLI::Option* captures =
      command
          ->add_option("--captures", options->captures,
                       "Instead, a folder of captures of a flat, textured target, and distances.json: {\"captures\": "
                       "[{\"capture\": \"FOLDER\", \"target_distance_m\": 0.5}, ...]}")
          ->type_name("DIR");
  captures->excludes(camera);
  command->add_option("-o,--output", options->output, "Folder to write; an interrupted sweep is resumed")
      ->required()
      ->type_name("DIR");
  add_overrides_option(*command, options->overrides, "lens.f_number=2.8");
  command->add_option("--focuses", options->sweep.focuses, "Focus distances, from infinity to the nearest")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  command->add_option("--targets", options->sweep.targets, "Target distances for each")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  command->add_option("--nearest-focus-m", options->sweep.nearest_focus_m, "Nearest focus distance")
      ->check(number_range(0.05, 10.0))
      ->capture_default_str();
  for (const char* of_a_sweep : {"--set", "--focuses", "--targets", "--nearest-focus-m"}) {
    captures->excludes(command->get_option(of_a_sweep));
  }
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel calibrate build/release/scenes/portrait.json -o out/calibration\n"
      "  dualpixel portrait out/capture -o out/portrait --calibration out/calibration");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
