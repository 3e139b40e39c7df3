#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <utility>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "scenes/framing/resolve_scene.h"
#include "scenes/framing/scene_document.h"
#include "simulator/jobs_file.h"
#include "simulator/journal.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/plan_text.h"
#include "simulator/ready_scene.h"
#include "simulator/simulate.h"
#include "tools/cli/number_range.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct SimulateOptions {
  std::vector<std::string> scenes;
  std::string jobs;
  std::string output;
  std::vector<std::string> overrides;
  std::optional<std::uint64_t> seed;
  bool automatic = false;
  double tolerance_dp_px = 0.02;
  bool dry_run = false;
  bool resume = false;
};

/// The journal lies beside the capture's folder, not in it, because the folder is replaced as a whole.
std::string journal_beside(std::string folder) {
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  return folder + ".resume";
}

/// Noise that the sensor does not have is taken for texture by whatever is judged or trained on the capture.
void warn_of_render_noise(const std::string& scene, const std::string& job, std::optional<double> noise_fraction) {
  constexpr double kHardToSee = 0.25, kFall = 0.55;  // error falls as samples^-kFall (docs/rendering.md)
  if (noise_fraction.value_or(0) <= kHardToSee) return;
  const double times = std::pow(*noise_fraction / kHardToSee, 1 / kFall);
  std::cerr << fmt::format(
      "dualpixel: warning: {}: {}rendering noise is {:.2f} times the sensor's; --noise-fraction {} would take about "
      "{:.{}f} times as long\n",
      printable(scene), job.empty() ? "" : job + ": ", *noise_fraction, kHardToSee, times, times < 10 ? 1 : 0);
}

/// The jobs of the file, or a single one without a name. What the program chose for a glTF file goes to stdout.
std::vector<simulator::SimulationJob> jobs_of(const SimulateOptions& options, const std::string& scene,
                                              std::unique_ptr<simulator::ReadyScene>& ready) {
  nlohmann::json json = scenes::read_scene_document(scene);
  simulator::apply_overrides(json, options.overrides);
  if (options.seed) apply_override(json, fmt::format("render.seed={}", *options.seed));
  const auto resolve = [&](const std::string& job, nlohmann::json document) {
    std::vector<std::string> warnings;
    document = scenes::resolve_scene(std::move(document), scene, ready, warnings);
    print_warnings(warnings, job);
    return document;
  };
  std::vector<simulator::SimulationJob> jobs;
  if (options.jobs.empty()) {
    json = resolve("", std::move(json));
    if (scenes::is_gltf(scene)) std::cout << json.dump(2) << '\n';
    jobs.push_back({"", simulator::read_simulation(json, scene)});
  } else {
    jobs = simulator::read_jobs(options.jobs, json, scene, resolve);
  }
  for (const simulator::SimulationJob& job : jobs) {
    if (!options.resume || !job.simulation.time_budget_s || options.automatic) continue;
    throw InputError(
        fmt::format("{}: /render/time_budget_s: {} cannot be combined with --resume, whose bytes must not depend on "
                    "the clock; leave either out",
                    printable(scene), *job.simulation.time_budget_s));
  }
  return jobs;
}

void print_dry_run(const std::string& scene, const simulator::Simulation& simulation) {
  const bool by_error = simulation.noise_fraction || simulation.render_error || simulation.time_budget_s;
  std::cout << fmt::format(
      "{}: {} x {} photosites, {}, a burst of {}: can be simulated\n", scene, simulation.sensor.width_px,
      simulation.sensor.height_px,
      by_error ? "samples by error" : fmt::format("{} samples each", simulation.render.samples_per_pixel),
      simulation.burst_frames);
}

/// Folders of several scenes' captures: named as the files, without their endings.
std::vector<std::string> outputs_of(const SimulateOptions& options) {
  if (options.scenes.size() == 1) return {options.output};
  std::vector<std::string> outputs;
  for (const std::string& scene : options.scenes) {
    outputs.push_back(options.output + "/" + std::filesystem::path(scene).stem().string());
    if (std::count(outputs.begin(), outputs.end(), outputs.back()) > 1) {
      throw InputError(printable(scene) + ": another scene has this name, too: their captures would be one folder");
    }
  }
  return outputs;
}

struct Job {
  std::string name;  ///< empty where it is the scene's only one
  simulator::Simulation simulation;
  simulator::CameraView camera;
  std::string output;
};

/// Adds those of options.scenes[scene], and shows its warnings. Refuses what can be refused once the scene is loaded,
/// but for the output.
void add_jobs(const SimulateOptions& options, std::size_t scene, std::vector<Job>& jobs,
              std::unique_ptr<simulator::ReadyScene>& ready) {
  const std::string folder = outputs_of(options)[scene];
  bool first = true;
  for (simulator::SimulationJob& job : jobs_of(options, options.scenes[scene], ready)) {
    const bool loaded = simulator::make_ready(job.simulation, ready);
    simulator::require_renderable(job.simulation, ready->scene);
    simulator::CameraView camera = simulator::place_camera(job.simulation, ready->scene);
    print_warnings(simulator::warnings_of(job.simulation), job.name);
    jobs.push_back(
        {job.name, std::move(job.simulation), std::move(camera), job.name.empty() ? folder : folder + "/" + job.name});
    if (!std::exchange(first, false) && !loaded) continue;
    print_warnings(ready->scene.warnings);
  }
}

/// Keeps `ready` for the next job.
void run_job(const SimulateOptions& options, Job job, std::unique_ptr<simulator::ReadyScene>& ready) {
  simulator::make_ready(job.simulation, ready);
  const simulator::Scene& scene = ready->scene;
  simulator::Simulation& simulation = job.simulation;
  simulator::CameraView& camera = job.camera;
  std::string plan_of_capture;
  if (options.automatic) {
    const simulator::Plan chosen =
        simulator::plan(simulation, scene, options.tolerance_dp_px, simulation.render.seed, Progress("plan"));
    simulation = simulator::planned(simulation, chosen);
    camera.lens = simulator::prepare_lens(simulation);
    plan_of_capture = simulator::plan_json(chosen, false).dump();
    const std::string text = simulator::plan_text(chosen);
    std::cerr << text.substr(text.rfind('\n', text.size() - 2) + 1);  // its last sentence
  }
  if (options.dry_run && job.name.empty() && scenes::is_gltf(simulation.path)) return;  // stdout has its scene file
  if (options.dry_run) return print_dry_run(simulation.path, simulation);

  const std::string journal_path = journal_beside(job.output);
  std::optional<simulator::Journal> journal;
  if (options.resume) {
    const std::string inputs = fmt::format("{} {} {} {} {} {} {} {}", simulation.json.dump(), simulation.lens.json,
                                           simulation.photograph ? simulation.photograph->json : "", ready->gltf_xxh64,
                                           simulation.render.max_bounces, simulation.light.light_spacing_px,
                                           plan_of_capture, DUALPIXEL_VERSION);
    journal.emplace(journal_path, simulator::fingerprint(scene, camera, inputs));
    simulation.render.store = &*journal;
  }

  std::map<std::string, Progress> bars;
  Capture capture = simulator::simulate(
      simulation, ready->world, camera,
      [&](const std::string& stage, double fraction) { bars.try_emplace(stage, stage).first->second(fraction); });
  capture.provenance.program = "dualpixel " DUALPIXEL_VERSION;
  capture.provenance.scene_file = std::filesystem::path(simulation.path).filename().string();
  capture.provenance.gltf_xxh64 = ready->gltf_xxh64;
  capture.provenance.plan = plan_of_capture;
  write_capture(capture, job.output);
  if (!simulation.noise_fraction)
    warn_of_render_noise(simulation.path, job.name, capture.provenance.noise_fraction_reached);
  std::error_code left_behind;  // the capture is complete: a leftover journal is no failure
  if (options.resume) std::filesystem::remove(journal_path, left_behind);
}

/// All is checked before the first is rendered: a fault in the last is not met after hours.
void run(const SimulateOptions& options) {
  std::unique_ptr<simulator::ReadyScene> ready;
  std::vector<Job> jobs;
  for (std::size_t scene = 0; scene < options.scenes.size(); ++scene) add_jobs(options, scene, jobs, ready);
  for (const Job& job : jobs) {
    if (options.dry_run) {
      require_replaceable(job.output, "capture.json");
    } else {
      const NewFolder writable(job.output, "capture.json");
    }
  }
  for (Job& job : jobs) run_job(options, std::move(job), ready);
}

}  // namespace

void add_simulate(CLI::App& program) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = program.add_subcommand("simulate", "Render a scene into a dual-pixel capture with its truth");
  command
      ->add_option("scenes", options->scenes,
                   "Scene JSON file, or a glTF file, for which camera, focus, light and exposure are chosen and the "
                   "scene file is printed; several: each has a folder in DIR")
      ->required()
      ->type_name("SCENE");
  command
      ->add_option("-o,--output", options->output,
                   "Capture folder to write; with --jobs or several scenes, where their folders go")
      ->required()
      ->type_name("DIR");
  command
      ->add_option(
          "--jobs", options->jobs,
          "Several captures of the scene, which is loaded once: a file with a line such as {\"name\": \"near\", "
          "\"set\": {\"camera.focus_distance_m\": 0.5}} for each; written to DIR/NAME")
      ->type_name("JOBS.jsonl");
  add_overrides_option(*command, options->overrides, "camera.focus_distance_m=0.9");
  command->add_option("--seed", options->seed, "Seed of rendering and noise (render.seed)")
      ->check(any_seed())
      ->type_name("N");
  CLI::Option* automatic = command->add_flag(
      "--auto", options->automatic,
      "Lens model, bounces, light, effects and samples by 'dualpixel plan' instead of the scene file's");
  add_tolerance_option(*command, options->tolerance_dp_px)->needs(automatic);
  const auto sampling_option = [&](const std::string& name, const std::string& field, const std::string& meaning,
                                   const CLI::Validator& range, const std::string& unit) {
    return command
        ->add_option_function<double>(
            name, [options, field](double to) { options->overrides.push_back(fmt::format("render.{}={}", field, to)); },
            meaning)
        ->check(range)
        ->type_name(unit)
        ->excludes(automatic);
  };
  const CLI::Validator shares = number_range(1e-4, 100.0);
  CLI::Option* by_noise = sampling_option(
      "--noise-fraction", "noise_fraction",
      "Sample each picture until its error is this share of the sensor's noise, RMS; 0.25 is hard to see", shares,
      "SHARE");
  CLI::Option* by_error =
      sampling_option("--error", "error",
                      "Sample each picture until its error is this share of the white level's signal", shares, "SHARE");
  CLI::Option* by_time = sampling_option("--time-budget", "time_budget_s", "Sample the views for about so many seconds",
                                         number_range(0.0, 1e7), "S");
  by_error->excludes(by_noise);
  by_time->excludes(by_noise)->excludes(by_error);
  command
      ->add_flag("--resume", options->resume,
                 "Keep finished tiles in DIR.resume and continue from them after an interruption, with the same bytes "
                 "as without one. Tiles of another scene or of other options are refused")
      ->excludes(by_time);
  command->add_flag("--dry-run", options->dry_run, "Check scene and options, render nothing");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel simulate build/release/scenes/portrait.json -o out/capture --set "
      "camera.focus_distance_m=0.9 --seed 7\n"
      "  dualpixel simulate build/release/scenes/occlusion_edges.json -o out/edges --auto --tolerance-px 0.05\n"
      "  dualpixel simulate build/release/scenes/portrait.json --jobs jobs.jsonl -o out/captures\n"
      "  dualpixel simulate model.glb -o out/model --set camera.focus_node=Head > model.json");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
