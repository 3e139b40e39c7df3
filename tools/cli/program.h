#pragma once

namespace dualpixel::tools {

/// Exit statuses, beside 0 and 128 + a signal's number.
constexpr int kInternalError = 1;
constexpr int kBadInput = 2;

/// The whole program: parses the arguments of `main`, runs the subcommand, reports on stderr what went wrong, and
/// returns the exit status.
int program_main(int argc, char** argv);

}  // namespace dualpixel::tools
