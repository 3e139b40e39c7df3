#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/methods/set_evaluation.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct EvaluateOptions {
  std::string set;
  std::string split;
  std::string output;
  std::vector<std::string> methods;
};

void run(const EvaluateOptions& options) {
  const std::vector<evaluation::DisparityMethod> methods = evaluation::methods_named(options.methods);
  const std::vector<std::string> folders = evaluation::sample_folders(options.set, options.split);
  NewFolder out(options.output, "evaluation.json");
  Progress bar("evaluate");
  const std::vector<evaluation::SetScore> scores =
      evaluation::evaluate_set(folders, methods, [&](double fraction) { bar(fraction); });
  write_file(out.path() + "/evaluation.json", evaluation::to_json(scores, folders.size()).dump(2) + "\n");
  write_file(out.path() + "/evaluation.html", evaluation::to_page(scores, folders.size()));
  out.commit();
  std::cout << evaluation::to_text(scores);
}

}  // namespace

CLI::Option* add_methods_option(CLI::App& command, std::vector<std::string>& methods) {
  return command.add_option("--method", methods)->type_name("METHOD")->take_all()->expected(1)->allow_extra_args(false);
}

void add_evaluate(CLI::App& program) {
  auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command = program.add_subcommand(
      "evaluate", "Compare ways of finding disparity, of the pipeline or of any program, over a set of captures");
  command->add_option("set", options->set, "Data set of `dualpixel dataset`, or a folder of captures with truth")
      ->required()
      ->type_name("SET");
  command->add_option("-o,--output", options->output, "Folder for evaluation.json and evaluation.html")
      ->required()
      ->type_name("DIR");
  add_methods_option(*command, options->methods)
      ->required()
      ->description(
          "A matcher (paper, likelihood, split); the same with other options, as in split:split_match.window_px=9 "
          "(`dualpixel "
          "portrait --options` lists them; commas between several); or another program: NAME=COMMAND, run by the shell "
          "for each pair. "
          "{left} and {right} in it become 16-bit PNG files of the linear views, white where they clip, {left.npy} "
          "and {right.npy} float32 arrays; {out}, and where it has them {sigma} and {confidence}, are the files that "
          "it writes: NPY, PFM or EXR, DP px, right(x + d) = left(x); '.npy', '.pfm' or '.exr' may follow a name, as "
          "in {out}.npy. "
          "Paths are "
          "quoted: put no quotes around them. Repeat for several");
  command->add_option("--split", options->split, "Of a data set, this split alone")
      ->check(CLI::IsMember({"train", "validation", "test"}))
      ->type_name("SPLIT");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel evaluate out/set -o out/compared --method likelihood "
      "--method 'mine=./match {left} {right} {out}'\n"
      "  dualpixel evaluate out/set -o out/windows --method split --method split:split_match.window_px=9");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
