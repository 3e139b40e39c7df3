#pragma once
#include <string>

#include "tests/run_program.h"

namespace dualpixel {

/// What `dualpixel ARGUMENTS` does, without the third of a second that a new program takes to load its libraries: a
/// process that was forked before this one had a thread forks again for each command and calls program_main() there.
/// Quotes are the shell's; nothing else of a shell works.
Outcome run_command(const std::string& arguments);

}  // namespace dualpixel
