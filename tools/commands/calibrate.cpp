#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/report/calibration_page.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/portrait/matchable.h"
#include "simulator/lens/disparity_field.h"
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

/// All that the measurements of a sweep depend on, the lens by what it does.
Json describe_sweep(const simulator::Simulation& simulation, const evaluation::SweepOptions& options) {
  const Camera camera = describe_camera(simulation);
  // as the sweep focuses it: where the scene does, does not matter
  const simulator::LensSampler lens = evaluation::focused_lens(simulation, options.nearest_focus_m);
  Json traced = Json::array();
  for (const double place : {0.5, 0.75, 0.95}) {
    const simulator::DisparityCoefficients c = trace_disparity(lens, static_cast<int>(place * camera.width_px),
                                                               static_cast<int>(place * camera.height_px), 1024);
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

/// The folder of a sweep, new or to be gone on with.
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
  } else if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error))) {
    throw InputError(printable(folder) + ": exists and is no calibration; choose a new folder");
  }
  fs::create_directories(folder, error);
  if (error) throw InputError(printable(folder) + ": cannot be made: " + error.message());
  // before the rest: it is what tells an interrupted sweep from a folder of something else
  replace_file(file, description.dump(2) + "\n");
  fs::create_directories(folder + "/measurements", error);
  if (error) throw InputError(printable(folder) + "/measurements: cannot be made: " + error.message());
}

pipeline::TargetMeasurement measure_capture(const Capture& capture, double target_distance_m, const std::string& path) {
  const pipeline::MergedBurst burst = pipeline::align_and_merge(capture.frames, capture.exposure);
  pipeline::TargetMeasurement measurement =
      pipeline::measure_target(burst.left, burst.right, capture.camera.focus_distance_m, target_distance_m);
  const Image& usable = measurement.usable;
  const auto seen = std::count(usable.data.begin(), usable.data.end(), 1.0f);
  if (2 * static_cast<std::size_t>(seen) < usable.data.size()) {
    throw InputError(
        fmt::format("{}: the views match on only {:.0f} % of the picture; a target must be textured and fill it",
                    printable(path), 100.0 * static_cast<double>(seen) / static_cast<double>(usable.data.size())));
  }
  return measurement;
}

/// `camera` becomes the first capture's.
std::vector<pipeline::TargetMeasurement> measure_captures(const std::string& folder, Camera& camera) {
  const std::string list = folder + "/distances.json";
  const nlohmann::json json = read_json_file(list);
  Fields root(json, list);
  std::vector<pipeline::TargetMeasurement> measurements;
  std::vector<Fields> entries = root.required("captures").objects("captures");
  root.done();
  if (entries.empty()) root.fail("captures", "must name at least three captures");
  Progress bar("calibrate");
  for (Fields& entry : entries) {
    std::string name;
    double distance_m = 0;
    entry.required("capture").text("capture", name);
    entry.required("target_distance_m").number("target_distance_m", distance_m, 0.01, 1000);
    entry.done();
    const std::string path = (fs::path(folder) / name).string();
    const Capture capture = read_capture(path, false);
    pipeline::require_matchable(capture.camera, path, "/camera/dp_downsample_x");
    if (measurements.empty()) camera = capture.camera;
    pipeline::require_same_camera(camera, capture.camera, printable(path));
    measurements.push_back(measure_capture(capture, distance_m, path));
    bar(static_cast<double>(measurements.size()) / static_cast<double>(entries.size()));
  }
  return measurements;
}

void warn(const pipeline::Calibration& calibration) {
  for (const std::string& warning : calibration.warnings) std::cerr << "dualpixel: warning: " << warning << '\n';
}

void sweep_camera(const CalibrateOptions& options) {
  nlohmann::json json = read_json_file(options.camera);
  for (const std::string& assignment : options.overrides) apply_override(json, assignment);
  const simulator::Simulation simulation = simulator::read_simulation(json, options.camera);
  const Camera camera = describe_camera(simulation);
  pipeline::require_matchable(camera, options.camera, "/sensor/dp_downsample_x");
  evaluation::require_focuses(simulation, options.sweep);
  open_sweep(options.output, describe_sweep(simulation, options.sweep));
  Progress bar("calibrate");
  const pipeline::Calibration calibration = pipeline::fit_calibration(
      camera,
      evaluation::run_sweep(simulation, options.sweep, options.output + "/measurements", [&](double f) { bar(f); }));
  replace_file(options.output + "/calibration.json", to_json(calibration).dump() + "\n");
  warn(calibration);
}

void fit_captures(const CalibrateOptions& options) {
  NewFolder out(options.output, "calibration.json");
  Camera camera;
  const std::vector<pipeline::TargetMeasurement> measurements = measure_captures(options.captures, camera);
  const pipeline::Calibration calibration = pipeline::fit_calibration(camera, measurements);
  fs::create_directory(out.path() + "/measurements");
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    write_file(fmt::format("{}/measurements/capture_{:04}.json", out.path(), i),
               to_json(measurements[i]).dump() + "\n");
  }
  write_file(out.path() + "/calibration.json", to_json(calibration).dump() + "\n");
  out.commit();
  warn(calibration);
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
      "calibrate", "Measure how disparity depends on depth and place, from a target swept over focus and distance");
  CLI::Option* camera =
      command->add_option("camera", options->camera, "Scene file whose camera is simulated")->type_name("CAMERA.json");
  CLI::Option* captures =
      command
          ->add_option("--captures", options->captures,
                       "Instead, a folder of captures of a flat, textured target, and distances.json: {\"captures\": "
                       "[{\"capture\": \"FOLDER\", \"target_distance_m\": 0.5}, ...]}")
          ->type_name("DIR");
  captures->excludes(camera);
  command->add_option("-o,--output", options->output, "Folder to write; an interrupted sweep goes on where it was")
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
      ->check(CLI::Range(0.05, 10.0))
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
