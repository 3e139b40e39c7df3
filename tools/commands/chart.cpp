#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/chart/cycles_stage.h"
#include "evaluation/chart/stages.h"
#include "evaluation/report/page.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

namespace fs = std::filesystem;

struct ChartOptions {
  std::string page, older;
  std::string scenes = "build/release/scenes", lenses = "lens_models";
  std::string cycles_script;
  bool quick = false;
};

/// Processor and threads.
std::string machine() {
  std::ifstream cpus("/proc/cpuinfo");
  std::string name = "unknown processor";
  for (std::string line; std::getline(cpus, line);) {
    if (line.starts_with("model name")) {
      name = line.substr(line.find(':') + 2);
      break;
    }
  }
  return fmt::format("{}, {} threads", name, std::thread::hardware_concurrency());
}

/// The sections that an interrupted run of the same kind has left in `file`.
evaluation::Chart interrupted(const std::string& file, const evaluation::Chart& fresh) {
  if (!fs::exists(file)) return fresh;
  const nlohmann::json json = read_json_file(file);
  if (evaluation::is_of_other_version(json)) return fresh;
  evaluation::Chart chart = evaluation::read_chart(json, file);
  const bool same = !chart.complete && chart.quick == fresh.quick && chart.version == fresh.version &&
                    chart.libraries == fresh.libraries && chart.machine == fresh.machine;
  return same ? chart : fresh;
}

/// The chart to compare with; throws InputError where it was measured on pictures of another size.
std::optional<evaluation::Chart> older_chart(const ChartOptions& options) {
  if (options.older.empty()) return std::nullopt;
  evaluation::Chart older = evaluation::read_chart(read_json_file(options.older), options.older);
  if (older.quick != options.quick) {
    throw InputError(fmt::format("--compare: {}: was measured {} --quick: must be measured as this one is",
                                 printable(options.older), older.quick ? "with" : "without"));
  }
  if (older.machine != machine()) {
    std::cerr << fmt::format(
        "dualpixel: warning: {}: was measured on another machine ({}): times differ by that, too\n",
        printable(options.older), printable(older.machine));
  }
  return older;
}

void run(const ChartOptions& options) {
  if (!options.cycles_script.empty() && !evaluation::has_blender()) {
    throw InputError("--cycles: needs Blender (package blender): there is no command 'blender'");
  }
  const std::optional<evaluation::Chart> older = older_chart(options);
  const std::string json_file = fs::path(options.page).replace_extension(".json").string();
  if (json_file == options.page) throw InputError(printable(options.page) + ": must not end in .json");
  evaluation::require_page_path(options.page);  // before the work, not after it
  require_writable(json_file);
  const NewFolder scratch(options.page + ".captures", "capture");  // never made: it goes when the page is there
  const evaluation::ChartInput input{
      options.quick,        options.scenes, options.lenses, scratch.path(), fmt::format("/proc/{}/exe", getpid()),
      options.cycles_script};
  evaluation::Chart chart = interrupted(json_file, {options.quick,
                                                    DUALPIXEL_VERSION,
                                                    DUALPIXEL_LIBRARIES,
                                                    machine(),
                                                    {},
                                                    evaluation::chart_left_out(options.quick)});
  const auto write = [&](const std::optional<evaluation::ChartComparison>& since = {}) {
    evaluation::write_page(options.page, to_page(chart, since));
    replace_file(json_file, to_json(chart).dump(2) + "\n");
  };
  Progress progress("chart");
  std::size_t done = 0;
  for (const evaluation::ChartStage& stage : evaluation::chart_stages()) {
    progress(static_cast<double>(done++) / static_cast<double>(evaluation::chart_stages().size()));
    if (options.quick && !stage.in_quick) continue;
    if (has_stage(chart, stage.name)) continue;
    add(chart, stage.measure(input), stage.name);
    write();
  }
  progress(1);
  chart.complete = true;
  std::optional<evaluation::ChartComparison> since;
  if (older) since = compare(*older, chart);
  write(since);
  print_written(options.page);
  if (since) std::cout << to_text(*since);
}

}  // namespace

void add_chart(CLI::App& program) {
  auto options = std::make_shared<ChartOptions>();
  CLI::App* command = program.add_subcommand("chart", "Chart speed against accuracy of the stages, on one page");
  command->add_option("-o,--output", options->page, "Page to write; its figures go into a .json file beside it")
      ->required()
      ->type_name("PAGE.html");
  CLI::Option* const quick = command->add_flag("--quick", options->quick, "Small pictures, few repetitions: minutes");
  command->add_option("--compare", options->older, "Say what differs from an older chart by more than noise")
      ->type_name("OLD.json");
  command->add_option("--scenes", options->scenes, "Folder of the shipped scenes")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--lenses", options->lenses, "Folder of lens files")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR")
      ->capture_default_str();
  command
      ->add_option("--cycles", options->cycles_script,
                   "Measure Blender's Cycles beside the renderer, by this script (some minutes more): "
                   "tools/compare_cycles.py of the sources, which is run by `blender`")
      ->check(CLI::ExistingFile)
      ->excludes(quick)
      ->type_name("SCRIPT");
  add_threads_option(*command);
  command->footer(
      "An interrupted run goes on with the first stage that it had not finished.\nExample:\n  dualpixel chart --quick "
      "-o out/chart.html\n"
      "  dualpixel chart --quick -o out/new.html --compare out/chart.json");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
