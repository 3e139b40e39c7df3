#pragma once
#include <string>

/// Other programs, started by /bin/sh, and what they work in.
namespace dualpixel::evaluation {

/// A folder among the system's temporary ones, removed with it.
class ScratchFolder {
 public:
  /// Throws InputError where it cannot be made.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// One word for the shell, whatever it holds.
std::string shell_quoted(const std::string& text);

struct Ended {
  int status = 0;  ///< as wait(2) gives it
  double cpu_s = 0, peak_rss_mb = 0;
};

/// Runs a command with an empty standard input, its standard output going to our standard error, in a process group of
/// its own. Memory is looked up every 10 ms: the kernel's own figure of a child begins with what we held when it was
/// forked.
Ended run_shell(const std::string& command);

/// Kills the groups of all commands that run and removes all scratch folders, for a program that a signal ends. No
/// command can be started afterwards.
void end_child_processes();

}  // namespace dualpixel::evaluation
