#include "evaluation/methods/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include "capture/error.h"

namespace dualpixel::evaluation {
namespace {

/// What end_child_processes() has to end.
std::mutex running_mutex;
std::set<pid_t> running_groups;
std::set<std::string> scratch_folders;

/// The most memory that one process of a tree has held so far, MB; 0 where all have ended.
double peak_rss_mb_of_tree(const std::string& pid) {
  double most_mb = 0;
  std::ifstream status("/proc/" + pid + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) most_mb = std::strtod(line.c_str() + 6, nullptr) / 1024;
  }
  std::error_code ended;
  std::vector<std::string> children;
  std::filesystem::directory_iterator thread("/proc/" + pid + "/task", ended);
  for (; !ended && thread != std::filesystem::directory_iterator(); thread.increment(ended)) {
    std::ifstream list(thread->path() / "children");
    for (std::string child; list >> child;) children.push_back(child);
  }
  for (const std::string& child : children) most_mb = std::max(most_mb, peak_rss_mb_of_tree(child));
  return most_mb;
}

/// Becomes the shell that runs `command`, with signals and input as if a shell had started it, and leads its group.
[[noreturn]] void become_shell(const std::string& command) {
  setpgid(0, 0);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  signal(SIGXFSZ, SIG_DFL);
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  dup2(STDERR_FILENO, STDOUT_FILENO);
  execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
  _exit(127);
}

/// Starts the shell and returns when it runs the command.
pid_t start_shell(const std::string& command) {
  int started[2];  // closed by exec
  if (pipe2(started, O_CLOEXEC) != 0) throw std::runtime_error("pipe: no process could be started");
  const std::lock_guard lock(running_mutex);  // lest it be started and not yet known when all are ended
  const pid_t child = fork();
  if (child == 0) become_shell(command);
  close(started[1]);
  char nothing;
  while (child > 0 && read(started[0], &nothing, 1) < 0 && errno == EINTR) {
  }
  close(started[0]);
  if (child < 0) throw std::runtime_error("fork: no process could be started");
  running_groups.insert(child);
  return child;
}

/// Waits for the child. Its number is another's as soon as it is reaped, so the group is forgotten before.
rusage wait_for(pid_t child, int& status) {
  siginfo_t ended{};
  while (waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT) < 0 && errno == EINTR) {
  }
  {
    const std::lock_guard lock(running_mutex);
    running_groups.erase(child);
  }
  rusage usage{};
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  return usage;
}

double cpu_seconds(const rusage& usage) {
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * t.tv_usec; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

ScratchFolder::ScratchFolder() : path_((std::filesystem::temp_directory_path() / "dualpixel-method-XXXXXX").string()) {
  const std::lock_guard lock(running_mutex);
  if (!mkdtemp(path_.data())) throw InputError(printable(path_) + ": cannot be made");
  scratch_folders.insert(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  const std::lock_guard lock(running_mutex);
  scratch_folders.erase(path_);
}

std::string shell_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

Ended run_shell(const std::string& command) {
  constexpr std::chrono::milliseconds kLookEvery(10);
  const pid_t child = start_shell(command);
  Ended ended;
  std::promise<void> over;
  std::thread looks([&, is_over = over.get_future()] {
    do {
      ended.peak_rss_mb = std::max(ended.peak_rss_mb, peak_rss_mb_of_tree(std::to_string(child)));
    } while (is_over.wait_for(kLookEvery) == std::future_status::timeout);
  });
  ended.cpu_s = cpu_seconds(wait_for(child, ended.status));
  over.set_value();
  looks.join();
  return ended;
}

void end_child_processes() {
  running_mutex.lock();  // for good: nothing may be started or made any more
  for (const pid_t group : running_groups) kill(-group, SIGKILL);
  std::error_code ignored;
  for (const std::string& folder : scratch_folders) std::filesystem::remove_all(folder, ignored);
}

}  // namespace dualpixel::evaluation
