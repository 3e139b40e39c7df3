#pragma once
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "tests/temporary_folder.h"

namespace dualpixel {

struct Outcome {
  int status = 0;
  std::string out;
  std::string err;
};

/// Runs `dualpixel ARGUMENTS` in a shell.
inline Outcome run_program(const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string command =
      "'" DUALPIXEL_PROGRAM "' " + arguments + " >'" + (folder / "out") + "' 2>'" + (folder / "err") + "' </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(folder / "out"), read_bytes(folder / "err")};
}

/// Exit status 2, nothing on stdout, one line on stderr.
inline void expect_one_line_refusal(const Outcome& outcome) {
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(outcome.err.starts_with("dualpixel: ")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

}  // namespace dualpixel
