#include <iostream>
#include <memory>

#include "capture/files.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/plan_text.h"
#include "simulator/simulate.h"
#include "tools/cli/number_range.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct PlanCommandOptions {
  std::string scene;
  std::string output;
  std::vector<std::string> overrides;
  double tolerance_dp_px = 0.02;
  std::uint64_t seed = 1;
  bool json = false;
};

void run(const PlanCommandOptions& options) {
  nlohmann::json json = read_json_file(options.scene);
  simulator::apply_overrides(json, options.overrides);
  const simulator::Simulation simulation = simulator::read_simulation(json, options.scene);
  print_warnings(simulation.warnings);
  const simulator::Scene scene = simulator::load_scene(simulation);
  const simulator::Plan result =
      simulator::plan(simulation, scene, options.tolerance_dp_px, options.seed, Progress("plan"));
  const std::string as_json = simulator::plan_json(result, true).dump(2) + '\n';
  if (!options.output.empty()) replace_file(options.output, as_json);
  std::cout << (options.json ? as_json : simulator::plan_text(result));
}

}  // namespace

void add_plan(CLI::App& program) {
  auto options = std::make_shared<PlanCommandOptions>();
  CLI::App* command = program.add_subcommand(
      "plan",
      "Find the lens model, bounces, light, effects and samples that a scene needs, and the error of cheaper ones");
  command->add_option("scene", options->scene, "Scene JSON file")->required()->type_name("SCENE.json");
  add_tolerance_option(*command, options->tolerance_dp_px);
  add_overrides_option(*command, options->overrides, "camera.focus_distance_m=0.9");
  command->add_option("--seed", options->seed, "Seed of the pilot renders and of their positions")
      ->check(any_seed())
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print JSON");
  command->add_option("-o,--output", options->output, "Also write that JSON to a file")->type_name("OUT.json");
  add_threads_option(*command);
  command->footer(
      "Renders parts of the scene. This takes seconds if its surfaces are unlit, minutes if light falls on them.\n\n"
      "Example:\n  dualpixel plan build/release/scenes/portrait.json --tolerance-px 0.02");
  command->callback([options] { run(*options); });
}

CLI::Option* add_tolerance_option(CLI::App& command, double& tolerance_dp_px) {
  return command.add_option("--tolerance-px", tolerance_dp_px, "Largest disparity error allowed, RMS in DP pixels")
      ->check(number_range(1e-4, 10.0))
      ->type_name("DP_PX")
      ->capture_default_str();
}

}  // namespace dualpixel::tools
