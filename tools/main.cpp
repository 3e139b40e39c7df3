#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/error.h"
#include "tools/cli/signals.h"
#include "tools/commands/commands.h"

namespace {

constexpr int kInternalError = 1;
constexpr int kBadInput = 2;

#if defined(__x86_64__) && defined(__AVX2__)
/// Runs before any static initializer, which may already hold an instruction that an older processor lacks.
[[gnu::constructor(101)]] void require_avx2() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) return;
  std::fputs("dualpixel: this build needs a processor with AVX2; build with -DDUALPIXEL_ARCH=x86-64 instead\n", stderr);
  _exit(kInternalError);
}
#endif

int report(int status, const std::string& message) {
  std::cout.flush();
  std::cerr << "dualpixel: " << message << '\n';
  return status;
}

/// `status`, unless what was printed did not reach its reader.
int printed(int status) {
  return std::cout.flush() ? status : report(kInternalError, "standard output cannot be written");
}

/// What to say of the first word that is not a command, at the top or under `experiment` and its like.
std::optional<std::string> unknown_command(const CLI::App& program, int argc, char** argv) {
  const CLI::App* parent = &program;
  for (int i = 1; i < argc && argv[i][0] != '-' && parent->get_require_subcommand_min() > 0; ++i) {
    std::vector<std::string> names;
    const CLI::App* found = nullptr;
    for (const CLI::App* command : parent->get_subcommands({})) {
      names.push_back(command->get_name());
      if (names.back() == argv[i]) found = command;
    }
    if (!found) {
      return fmt::format("'{}' is not a command{}; there are {}", dualpixel::printable(argv[i]),
                         dualpixel::did_you_mean(argv[i], names), fmt::join(names, ", "));
    }
    parent = found;
  }
  return {};
}

/// What to say of the first word that looks like a long option and is none of the command's.
std::optional<std::string> unknown_option(const CLI::App& program, int argc, char** argv) {
  const CLI::App* command = &program;
  std::string see = "dualpixel ";
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    see += command->get_name() + " ";
  }
  std::vector<std::string> names;
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string word(argv[i]), name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || std::find(names.begin(), names.end(), name) != names.end()) continue;
    return fmt::format("{}: no such option{} (see '{}--help')", dualpixel::printable(name),
                       dualpixel::did_you_mean(name, names), see);
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Dual-pixel camera simulator and portrait pipeline.", "dualpixel");
  program.set_version_flag("--version", "dualpixel " DUALPIXEL_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Example:\n  dualpixel simulate build/release/scenes/portrait.json -o out/capture\n  dualpixel portrait "
      "out/capture -o out/dp");
  dualpixel::tools::add_simulate(program);
  dualpixel::tools::add_calibrate(program);
  dualpixel::tools::add_portrait(program);
  dualpixel::tools::add_score(program);
  dualpixel::tools::add_evaluate(program);
  dualpixel::tools::add_report(program);
  dualpixel::tools::add_info(program);
  dualpixel::tools::add_lens(program);
  dualpixel::tools::add_fit_camera(program);
  dualpixel::tools::add_plan(program);
  dualpixel::tools::add_chart(program);
  dualpixel::tools::add_bench(program);
  dualpixel::tools::add_experiment(program);
  dualpixel::tools::add_export(program);
  dualpixel::tools::add_people(program);
  dualpixel::tools::add_scene(program);
  dualpixel::tools::add_dataset(program);

  try {
    dualpixel::tools::end_cleanly_on_signals();
    program.parse(argc, argv);
    return printed(0);
  } catch (const CLI::RuntimeError& status) {
    return status.get_exit_code();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return printed(program.exit(error));  // --help, --version
    const auto chosen = program.get_subcommands();
    for (const auto& explain : {unknown_command, unknown_option}) {
      if (const auto unknown = explain(program, argc, argv)) return report(kBadInput, *unknown);
    }
    return report(kBadInput, fmt::format("{} (see 'dualpixel {}--help')", dualpixel::printable(error.what()),
                                         chosen.empty() ? "" : chosen.front()->get_name() + " "));
  } catch (const dualpixel::InputError& error) {
    return report(kBadInput, error.what());
  } catch (const std::bad_alloc&) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    return report(kBadInput,
                  dualpixel::printable(fmt::format("{}: there is not enough memory for this", fmt::join(words, " "))));
  } catch (const std::exception& error) {
    return report(kInternalError, dualpixel::printable(error.what()));
  }
}
