#pragma once
#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>
#include <string>

#include "capture/error.h"
#include "tools/cli/file_fault.h"

namespace dualpixel::tools {

/// Parses the command line and works, for a program without subcommands. Returns the exit status: `work`'s own, 2 for
/// bad input, 1 for what went wrong with us; errors are one line on stderr that begins with the program's name.
inline int run_small_program(CLI::App& program, int argc, char** argv, const std::function<int()>& work) {
  const auto report = [&](int status, const std::string& message) {
    std::cerr << program.get_name() << ": " << message << '\n';
    return status;
  };
  try {
    program.parse(argc, argv);
    return work();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help
    return report(2, printable(error.what()));
  } catch (const InputError& error) {
    return report(2, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return report(2, file_fault(error));
  } catch (const std::exception& error) {
    return report(1, printable(error.what()));
  }
}

}  // namespace dualpixel::tools
