#include <fmt/format.h>

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "datasets/plan/plan.h"
#include "datasets/render/render.h"
#include "datasets/state/merge.h"
#include "datasets/state/state.h"
#include "datasets/state/webdataset.h"
#include "evaluation/report/dataset_page.h"
#include "tools/cli/signals.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kSomeFailed = 5;  // exit status of a batch
constexpr double kReportSeconds = 60;

struct DatasetArguments {
  std::string recipe, folder, shard;
  std::optional<int> count;
  std::optional<std::uint64_t> seed;
  int jobs = 1;
  bool json = false, webdataset = false;
};

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void print_plan(const datasets::Plan& plan, const DatasetArguments& arguments) {
  const double bytes = plan.bytes_per_sample * static_cast<double>(plan.lines.size());
  if (arguments.json) {
    Json out = {{"samples", plan.lines.size()}, {"bytes_per_sample", std::llround(plan.bytes_per_sample)}};
    for (std::size_t i = 0; i < datasets::kSplitCount; ++i) {
      out["splits"][datasets::kSplits[i].name] = {{"samples", plan.samples[i]}, {"scenes", plan.scenes[i]}};
    }
    std::cout << out.dump(2) << '\n';
    return;
  }
  std::cout << fmt::format("{} samples, {:.2f} MB each before compression, {:.2f} GB in all\n", plan.lines.size(),
                           plan.bytes_per_sample / 1e6, bytes / 1e9);
  for (std::size_t i = 0; i < datasets::kSplitCount; ++i) {
    if (plan.samples[i] == 0) continue;
    std::cout << fmt::format("{:<11} {:>8} samples of {} scenes\n", datasets::kSplits[i].name, plan.samples[i],
                             plan.scenes[i]);
  }
}

void run_plan(const DatasetArguments& arguments) {
  nlohmann::json json = read_json_file(arguments.recipe);
  if (json.is_object() && arguments.count) json["count"] = *arguments.count;
  if (json.is_object() && arguments.seed) json["seed"] = *arguments.seed;
  const datasets::Recipe recipe = datasets::read_recipe(json, arguments.recipe);
  const datasets::Plan plan = datasets::make_plan(recipe);
  print_warnings(plan.warnings);
  datasets::write_plan(plan, recipe, arguments.folder);
  print_plan(plan, arguments);
}

/// "12 of 40 samples, 1 failed, about 90 s left"
std::string progress_text(const datasets::RenderCounts& counts, double elapsed_s) {
  const int done = counts.rendered + counts.failed;
  return fmt::format("{} of {} samples{}, about {:.0f} s left\n", counts.there + counts.rendered, counts.planned,
                     counts.failed > 0 ? fmt::format(", {} failed", counts.failed) : "",
                     elapsed_s / std::max(done, 1) * counts.left());
}

void run_render(const DatasetArguments& arguments) {
  datasets::RenderTask task{
      arguments.folder,
      arguments.shard.empty() ? datasets::shard_of_environment() : datasets::parse_shard(arguments.shard),
      arguments.jobs, &note_first_signal()};
  Progress bar("samples");
  const double started_s = seconds_now();
  double reported_s = started_s;
  task.progress = [&](const datasets::RenderCounts& counts) {
    bar(1 - static_cast<double>(counts.left()) / counts.planned);
    if (isatty(STDERR_FILENO) != 0 || seconds_now() - reported_s < kReportSeconds) return;
    reported_s = seconds_now();
    std::cerr << progress_text(counts, reported_s - started_s);
  };
  const datasets::RenderCounts counts = datasets::render_shard(task);
  std::cout << fmt::format("{} samples: {} were there, {} rendered in {:.1f} s, {} failed, {} left\n", counts.planned,
                           counts.there, counts.rendered, seconds_now() - started_s, counts.failed, counts.left());
  if (*task.stopped != 0) throw CLI::RuntimeError(128 + *task.stopped);
  if (counts.failed == 0) return;
  std::cerr << fmt::format("dualpixel: {}/{}: says why {} of them failed\n", printable(arguments.folder),
                           datasets::kFailuresFile, counts.failed);
  throw CLI::RuntimeError(kSomeFailed);
}

void run_status(const DatasetArguments& arguments) {
  const datasets::DatasetState state = datasets::state_of(arguments.folder);
  Json out;
  std::string text;
  const auto add = [&](const char* name, const datasets::DatasetState::Counts& c) {
    const int missing = c.planned - c.there - c.failed;
    out[name] = {{"planned", c.planned}, {"rendered", c.there}, {"failed", c.failed}, {"missing", missing}};
    text += fmt::format("{:<11} {:>8} planned {:>8} rendered {:>6} failed {:>8} missing\n", name, c.planned, c.there,
                        c.failed, missing);
  };
  for (std::size_t i = 0; i < datasets::kSplitCount; ++i) {
    if (state.splits[i].planned > 0) add(datasets::kSplits[i].name, state.splits[i]);
  }
  add("all", state.total());
  for (const auto& [name, reason] : state.reasons) {
    out["failures"][name] = reason;
    text += fmt::format("{}: {}\n", name, printable(reason));
  }
  std::cout << (arguments.json ? out.dump(2) + "\n" : text);
}

void run_verify(const DatasetArguments& arguments) {
  const std::vector<std::string> faults = datasets::faults_of(arguments.folder);
  const int there = datasets::state_of(arguments.folder).total().there;
  std::cout << fmt::format("{} samples are there, {} of them not as they were written\n", there, faults.size());
  for (const std::string& fault : faults) std::cerr << "dualpixel: " << fault << '\n';
  if (!faults.empty()) throw CLI::RuntimeError(kSomeFailed);
}

void run_merge(const DatasetArguments& arguments) {
  const std::vector<nlohmann::json> index = datasets::merge_samples(arguments.folder);
  const std::string page = arguments.folder + "/statistics.html";
  replace_file(page, evaluation::dataset_page(index, arguments.folder));
  std::cout << fmt::format("{} samples: {}/{}, {}\n", index.size(), arguments.folder, datasets::kIndexFile, page);
  if (const std::string warning = datasets::noise_warning(index); !warning.empty()) print_warnings({warning});
  if (!arguments.webdataset) return;
  std::cout << fmt::format("{} tar files in {}/webdataset\n", datasets::write_webdataset(index, arguments.folder),
                           arguments.folder);
}

void run_gc(const DatasetArguments& arguments) {
  const datasets::Cleared cleared = datasets::clear(arguments.folder);
  std::cout << fmt::format("removed {} leftovers of ended programs, {} damaged samples, {} drawn scenes\n",
                           cleared.leftovers, cleared.damaged, cleared.scenes);
}

CLI::App* add_step(CLI::App& dataset, const std::shared_ptr<DatasetArguments>& arguments, const char* name,
                   const char* meaning, void (*run)(const DatasetArguments&)) {
  CLI::App* step = dataset.add_subcommand(name, meaning);
  step->callback([arguments, run] { run(*arguments); });
  return step;
}

}  // namespace

void add_dataset(CLI::App& program) {
  auto arguments = std::make_shared<DatasetArguments>();
  CLI::App* dataset = program.add_subcommand("dataset", "Many samples from one recipe: plan them, render them");
  dataset->require_subcommand(1);
  dataset->footer(  // which its steps inherit
      "Example:\n  dualpixel dataset plan datasets/recipes/phone_matching.json -o out/set\n"
      "  dualpixel dataset render out/set --jobs 2\n  dualpixel dataset status out/set");
  CLI::App* plan = add_step(*dataset, arguments, "plan", "Draw every sample's scene, values and seed", run_plan);
  plan->add_option("recipe", arguments->recipe, "Recipe JSON file")->required()->type_name("RECIPE.json");
  plan->add_option("-o,--output", arguments->folder, "Data set to begin, or to add samples to")
      ->required()
      ->type_name("DIR");
  plan->add_option("--count", arguments->count, "How many samples, instead of the recipe's count")
      ->check(CLI::Range(1, datasets::kMostSamples))
      ->type_name("N");
  plan->add_option("--seed", arguments->seed, "Instead of the recipe's seed")->check(any_seed())->type_name("N");
  CLI::App* render = add_step(*dataset, arguments, "render", "Render the samples that are missing", run_render);
  render
      ->add_option("--shard", arguments->shard,
                   "The part I of N, I from 0; by default what SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX or "
                   "AWS_BATCH_JOB_ARRAY_INDEX says, or all")
      ->type_name("I/N");
  render->add_option("--jobs", arguments->jobs, "Samples at a time, which share the threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->type_name("J");
  render->footer(
      "The first SIGINT, SIGTERM or SIGUSR1 ends it after the sample that is being rendered, the second at once.\n\n" +
      dataset->get_footer());
  CLI::App* status = add_step(*dataset, arguments, "status", "Count what is there, failed and missing", run_status);
  CLI::App* verify = add_step(*dataset, arguments, "verify", "Compare samples with their hashes", run_verify);
  CLI::App* merge =
      add_step(*dataset, arguments, "merge", "Write index.jsonl and statistics.html of what is rendered", run_merge);
  CLI::App* gc = add_step(*dataset, arguments, "gc",
                          "Remove leftovers, damaged samples, and drawn scenes that no sample needs any more", run_gc);
  for (CLI::App* step : {render, status, verify, merge, gc}) {
    step->add_option("folder", arguments->folder, "Data set")->required()->type_name("DIR");
  }
  merge->add_flag("--webdataset", arguments->webdataset, "Also pack the samples into tar files of about 1 GB");
  for (CLI::App* step : {plan, status}) step->add_flag("--json", arguments->json, "Print JSON");
  for (CLI::App* step : {plan, render, verify, gc}) add_threads_option(*step);
}

}  // namespace dualpixel::tools
