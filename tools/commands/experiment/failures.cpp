#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/experiments/failure_atlas.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

void add_experiment_failures(CLI::App& experiment) {
  auto folder = std::make_shared<std::string>();
  auto programs = std::make_shared<std::vector<std::string>>();
  CLI::App* command = experiment.add_subcommand(
      "failures", "Sweep sixteen ways in which disparity fails: error and confidence of each method");
  command->add_option("-o,--output", *folder, "Folder for failures.json and failures.html")
      ->required()
      ->type_name("DIR");
  add_methods_option(*command, *programs)
      ->description("Another program beside the matchers: NAME=COMMAND; see `dualpixel evaluate --help`");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel experiment failures -o out/failures\n"
      "  dualpixel experiment failures -o out/failures --method 'mine=./prog {left} {right} {out}'");
  command->callback([folder, programs] {
    std::vector<evaluation::DisparityMethod> methods;
    for (const pipeline::Matcher& matcher : pipeline::matchers()) methods.push_back(evaluation::method_of(matcher));
    methods = evaluation::methods_named(*programs, std::move(methods));
    NewFolder out(*folder, "failures.json");
    Progress bar("failures");
    const std::vector<evaluation::FailureSweep> sweeps =
        evaluation::measure_failures(methods, [&](double fraction) { bar(fraction); });
    write_file(out.path() + "/failures.json", evaluation::to_json(sweeps).dump(2) + "\n");
    write_file(out.path() + "/failures.html", evaluation::to_page(sweeps));
    out.commit();
  });
}

}  // namespace dualpixel::tools
