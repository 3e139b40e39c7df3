#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// The subcommands of `dualpixel`. Each function adds one to the program; what it does runs as the subcommand's
/// callback. Callbacks throw InputError for whatever the user can mend (exit status 2), anything else is a fault of
/// ours (1). Data goes to stdout, progress and messages to stderr.
namespace dualpixel::tools {

/// For --seed, 0 .. 2^64 - 1: CLI11 by itself takes -1 for the largest.
CLI::Validator any_seed();

/// --threads N (0: all cores), for the subcommands that compute. Limits oneTBB for the life of the process.
void add_threads_option(CLI::App& command);

/// --set FIELD=VALUE, repeatable: fields of the JSON file that is the command's input, for apply_override.
void add_overrides_option(CLI::App& command, std::vector<std::string>& overrides, const std::string& example);

/// A line on stderr for each; `about`: the name of what they are told of, empty where there is but one.
void print_warnings(const std::vector<std::string>& warnings, const std::string& about = "");

/// A line on stderr for a page that is in its place.
void print_written(const std::string& page);

void add_simulate(CLI::App& program);
void add_calibrate(CLI::App& program);
void add_portrait(CLI::App& program);
void add_score(CLI::App& program);
void add_evaluate(CLI::App& program);
/// --method METHOD, repeatable: for evaluation::method_named().
CLI::Option* add_methods_option(CLI::App& command, std::vector<std::string>& methods);
void add_report(CLI::App& program);
void add_info(CLI::App& program);
void add_lens(CLI::App& program);
void add_fit_camera(CLI::App& program);
void add_plan(CLI::App& program);
/// --tolerance-px of `plan` and of `simulate --auto`.
CLI::Option* add_tolerance_option(CLI::App& command, double& tolerance_dp_px);
void add_chart(CLI::App& program);
void add_bench(CLI::App& program);
/// `experiment`, whose subcommands each measure one thing over a sweep, and write JSON and a page of charts.
void add_experiment(CLI::App& program);
void add_experiment_aberrations(CLI::App& experiment);
void add_experiment_burst(CLI::App& experiment);
void add_experiment_calibration(CLI::App& experiment);
void add_experiment_defocus(CLI::App& experiment);
void add_experiment_failures(CLI::App& experiment);
void add_experiment_figures(CLI::App& experiment);
void add_experiment_methods(CLI::App& experiment);
void add_experiment_noise(CLI::App& experiment);
void add_experiment_scenes(CLI::App& experiment);
void add_experiment_segmentation(CLI::App& experiment);
void add_experiment_stages(CLI::App& experiment);
void add_experiment_votes(CLI::App& experiment);
void add_export(CLI::App& program);
void add_people(CLI::App& program);
void add_scene(CLI::App& program);
/// `dataset`, whose subcommands plan, render and check a data set.
void add_dataset(CLI::App& program);
/// Subcommands of `bench`.
void add_bench_defocus(CLI::App& bench);
void add_bench_disparity(CLI::App& bench);
void add_bench_lens(CLI::App& bench);
void add_bench_render(CLI::App& bench);
void add_bench_edges(CLI::App& bench);
void add_bench_portrait(CLI::App& bench);

/// A bar with time left, on stderr, only where stderr is a terminal. Call with the fraction done; 1 ends the line.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  void operator()(double fraction);

 private:
  std::string label_;
  double started_s_ = 0;
  double shown_s_ = 0;
  bool terminal_ = false;
  bool ended_ = false;
};

}  // namespace dualpixel::tools
