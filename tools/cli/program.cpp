#include "tools/cli/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "capture/error.h"
#include "tools/cli/exit_status.h"
#include "tools/cli/file_fault.h"
#include "tools/cli/signals.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

int report(int status, const std::string& message) {
  std::cout.flush();
  std::cerr << "dualpixel: " << message << '\n';
  return status;
}

int report_no_memory(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  return report(kBadInput,
                printable(fmt::format("{}", fmt::join(words, " "))) + ": there is not enough memory for this");
}

/// `status`, unless what was printed did not reach its reader.
int printed(int status) {
  const bool whole = std::cout.flush() && std::ferror(stdout) == 0;
  return whole ? status : report(kInternalError, "standard output cannot be written");
}

/// What to say of the first word that is not a command, at the top or under `experiment` and its like.
std::optional<std::string> unknown_command(const CLI::App& program, int argc, char** argv) {
  const CLI::App* parent = &program;
  int first = 1;
  while (first < argc && std::string_view(argv[first]).starts_with("--max-")) {
    first += std::string_view(argv[first]).find('=') == std::string_view::npos ? 2 : 1;
  }
  for (int i = first; i < argc && argv[i][0] != '-' && parent->get_require_subcommand_min() > 0; ++i) {
    std::vector<std::string> names;
    const CLI::App* found = nullptr;
    for (const CLI::App* command : parent->get_subcommands({})) {
      names.push_back(command->get_name());
      if (names.back() == argv[i]) found = command;
    }
    if (!found) {
      return fmt::format("'{}' is not a command{}; there are {}", printable(argv[i]), did_you_mean(argv[i], names),
                         fmt::join(names, ", "));
    }
    parent = found;
  }
  return {};
}

struct Chosen {
  const CLI::App* command;
  std::string words;  ///< that call it, each with a space after it
};

Chosen chosen_command(const CLI::App& program) {
  Chosen chosen{&program, "dualpixel "};
  while (!chosen.command->get_subcommands().empty()) {
    chosen.command = chosen.command->get_subcommands().front();
    chosen.words += chosen.command->get_name() + " ";
  }
  return chosen;
}

/// What to say of the first word that looks like a long option and is none of the command's or the program's.
std::optional<std::string> unknown_option(const CLI::App& program, int argc, char** argv) {
  const auto [command, see] = chosen_command(program);
  std::vector<std::string> names;
  for (const CLI::App* each : {command, &program}) {
    for (const CLI::Option* option : each->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  }
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string word(argv[i]), name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || std::find(names.begin(), names.end(), name) != names.end()) continue;
    return fmt::format("{}: no such option{} (see '{}--help')", printable(name), did_you_mean(name, names), see);
  }
  return {};
}

/// Of address space, in pages: the first number of statm. Read without a stream, whose buffer may be more than is left.
std::uint64_t pages_taken() {
  char text[32] = {};
  const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t length = read(file, text, sizeof text - 1);
  close(file);
  return length > 0 ? std::strtoull(text, nullptr, 10) : 0;
}

/// Throws where memory is limited (--max-memory, ulimit -v) to less than what the program and its libraries take and a
/// little to work with: libraries would end it without a word.
void require_room() {
  constexpr std::uint64_t kLeastMore_mb = 64;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  const std::uint64_t pages = pages_taken();
  if (pages == 0) return;
  const std::uint64_t least_mb = (pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) >> 20) + kLeastMore_mb;
  const std::uint64_t limit_mb = limit.rlim_cur >> 20;
  if (limit_mb >= least_mb) return;
  throw InputError(
      fmt::format("memory is limited to {} MB (--max-memory or ulimit -v): must be at least {} MB, which the "
                  "program itself takes",
                  limit_mb, least_mb));
}

/// Where standard streams are closed, what is opened first would take their numbers, and be written to as they are.
/// What is written to these fails, as it does where they are closed.
void occupy_closed_streams() {
  int descriptor = 0;
  do descriptor = open("/dev/null", O_RDONLY);
  while (descriptor >= 0 && descriptor <= STDERR_FILENO);
  if (descriptor >= 0) close(descriptor);
}

/// Before the command or among its options, as they hold for all of it.
void add_limits(CLI::App& program) {
  program
      .add_option_function<std::uint64_t>(
          "--max-memory",
          [](std::uint64_t megabytes) {
            rlimit limit{};
            bool done = getrlimit(RLIMIT_AS, &limit) == 0;
            limit.rlim_cur = std::min<rlim_t>(megabytes << 20, limit.rlim_cur);
            done = done && setrlimit(RLIMIT_AS, &limit) == 0;
            if (!done) throw InputError("--max-memory: this system does not let memory be limited");
            require_room();
          },
          "Refuse what needs more memory than MB: that of addresses, as with ulimit -v")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40))
      ->type_name("MB");
  program
      .add_option_function<std::int64_t>(
          "--max-time", [](std::int64_t seconds) { end_after(std::chrono::seconds(seconds)); },
          "End with status 2 after so many seconds; nothing half written is left")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}))
      ->type_name("S");
}

/// As a shell's variable that is not set leaves it; it would count as not given.
void refuse_empty_values(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_expected_max() == 0) continue;  // a flag
    option->check([](const std::string& value) { return std::string(value.empty() ? "must not be empty" : ""); }, "");
  }
  for (CLI::App* command : app.get_subcommands({})) refuse_empty_values(*command);
}

}  // namespace

int program_main(int argc, char** argv) {
  occupy_closed_streams();
  CLI::App program("Dual-pixel camera simulator and portrait pipeline.", "dualpixel");
  program.set_version_flag("--version", "dualpixel " DUALPIXEL_VERSION);
  program.require_subcommand(1);
  add_limits(program);
  program.fallthrough();
  program.footer(
      "Example:\n  dualpixel simulate build/release/scenes/portrait.json -o out/capture\n  dualpixel portrait "
      "out/capture -o out/dp");
  add_simulate(program);
  add_calibrate(program);
  add_portrait(program);
  add_score(program);
  add_evaluate(program);
  add_report(program);
  add_info(program);
  add_lens(program);
  add_fit_camera(program);
  add_plan(program);
  add_chart(program);
  add_bench(program);
  add_experiment(program);
  add_export(program);
  add_people(program);
  add_scene(program);
  add_dataset(program);
  refuse_empty_values(program);

  try {
    require_room();
    end_cleanly_on_signals();
    program.parse(argc, argv);
    return printed(0);
  } catch (const CLI::RuntimeError& status) {
    return printed(status.get_exit_code());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return printed(program.exit(error));  // --help, --version
    for (const auto& explain : {unknown_command, unknown_option}) {
      if (const auto unknown = explain(program, argc, argv)) return report(kBadInput, *unknown);
    }
    return report(kBadInput,
                  fmt::format("{} (see '{}--help')", printable(error.what()), chosen_command(program).words));
  } catch (const InputError& error) {
    return report(kBadInput, error.what());
  } catch (const std::bad_alloc&) {
    return report_no_memory(argc, argv);
  } catch (const std::filesystem::filesystem_error& error) {
    return report(kBadInput, file_fault(error));
  } catch (const std::system_error& error) {  // a thread that has no room for its stack
    if (error.code() == std::errc::resource_unavailable_try_again) return report_no_memory(argc, argv);
    if (std::ferror(stdout) != 0) return printed(kInternalError);  // what fmt::print() throws
    return report(kInternalError, printable(error.what()));
  } catch (const std::exception& error) {
    return report(kInternalError, printable(error.what()));
  }
}

}  // namespace dualpixel::tools
