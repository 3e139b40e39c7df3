#pragma once

namespace dualpixel::tools {

/// The whole program: parses the arguments of `main`, runs the subcommand, reports on stderr what went wrong, and
/// returns the exit status.
int program_main(int argc, char** argv);

}  // namespace dualpixel::tools
