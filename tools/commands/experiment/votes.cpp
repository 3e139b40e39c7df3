#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/study/study.h"
#include "evaluation/study/votes.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct StudyCommand {
  std::vector<std::string> portraits, votes;
  std::string output, study;
  std::uint64_t seed = 1;
  bool json = false;
};

void make_study(const StudyCommand& command) {
  std::vector<evaluation::MethodFolder> methods;
  for (const std::string& given : command.portraits) {
    const std::size_t equals = given.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == given.size()) {
      throw InputError(fmt::format("--portraits: {}: must be NAME=DIR", printable(given)));
    }
    methods.emplace_back(given.substr(0, equals), given.substr(equals + 1));
  }
  if (std::filesystem::exists(command.output + "/study.json")) {
    throw InputError(printable(command.output) +
                     ": holds a study, and perhaps votes that belong to it: give another folder by -o");
  }
  NewFolder out(command.output, "study.json");
  const evaluation::StudyFiles files = evaluation::make_study(methods, command.seed);
  write_file(out.path() + "/study.html", files.page_html);
  write_file(out.path() + "/study.json", to_json(files.study).dump(2) + "\n");
  out.commit();
  print_written(command.output + "/study.html");
}

void count_study(const StudyCommand& command) {
  if (command.votes.empty()) throw InputError("experiment votes: --study needs files of votes");
  const evaluation::Study study = evaluation::read_study(command.study + "/study.json");
  std::vector<evaluation::Votes> votes;
  std::map<std::string, std::string> file_of;
  for (const std::string& path : command.votes) {
    votes.push_back(evaluation::read_votes(path, study));
    const auto [other, is_new] = file_of.emplace(votes.back().participant, path);
    if (!is_new) {
      throw InputError(fmt::format("{}: /participant: \"{}\": must be another than that of {}", printable(path),
                                   printable(votes.back().participant), printable(other->second)));
    }
  }
  const evaluation::VoteTable table = evaluation::count_votes(study, votes);
  std::cout << (command.json ? to_json(table).dump(2) + "\n" : to_text(table));
}

}  // namespace

void add_experiment_votes(CLI::App& experiment) {
  auto command = std::make_shared<StudyCommand>();
  CLI::App* sub = experiment.add_subcommand(
      "votes",
      "A user study: a page that shows portraits of several methods in pairs, blind, and the count of its votes");
  CLI::Option* const output =
      sub->add_option("-o,--output", command->output,
                      "Folder for study.html, which participants open, and study.json, which says whose picture is "
                      "whose: keep it from them")
          ->type_name("DIR");
  CLI::Option* const portraits =
      sub->add_option("--portraits", command->portraits,
                      "A method and the folder of its portrait results, one subfolder a scene; twice or more")
          ->type_name("NAME=DIR")
          ->needs(output)
          ->take_all()
          ->expected(1)
          ->allow_extra_args(false);
  output->needs(portraits);
  sub->add_option("--seed", command->seed, "Decides the order of the pictures in the page")
      ->check(any_seed())
      ->capture_default_str()
      ->needs(portraits);
  CLI::Option* const study = sub->add_option("--study", command->study, "The folder of a study, to count its votes")
                                 ->excludes(portraits)
                                 ->type_name("DIR");
  sub->add_option("votes", command->votes, "The files that participants saved")->type_name("FILE")->needs(study);
  sub->add_flag("--json", command->json, "Print the count as JSON")->needs(study);
  sub->footer(
      "Example:\n  dualpixel experiment votes --portraits ours=out/dp_seg --portraits depth=out/dp -o out/study\n"
      "  dualpixel experiment votes --study out/study votes_A.json votes_B.json");
  sub->callback([command] {
    if (command->output.empty() == command->study.empty()) {
      throw InputError("experiment votes: needs --portraits and -o to make a study, or --study to count its votes");
    }
    command->study.empty() ? make_study(*command) : count_study(*command);
  });
}

}  // namespace dualpixel::tools
