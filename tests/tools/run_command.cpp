#include "tests/tools/run_command.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <wordexp.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <vector>

#include "tools/cli/program.h"

#ifdef DUALPIXEL_FINDS_LEAKS
#include <sanitizer/common_interface_defs.h>
#include <sanitizer/lsan_interface.h>
#endif

namespace dualpixel {
namespace {

void send(int pipe, const std::string& text) {
  const std::size_t size = text.size();
  if (write(pipe, &size, sizeof size) != sizeof size) throw std::runtime_error("run_command: its process has ended");
  for (std::size_t sent = 0; sent < size;) {
    const ssize_t count = write(pipe, text.data() + sent, size - sent);
    if (count <= 0) throw std::runtime_error("run_command: its process has ended");
    sent += static_cast<std::size_t>(count);
  }
}

/// False where the other end is closed.
bool receive(int pipe, void* to, std::size_t size) {
  for (std::size_t got = 0; got < size;) {
    const ssize_t count = read(pipe, static_cast<char*>(to) + got, size - got);
    if (count <= 0) return false;
    got += static_cast<std::size_t>(count);
  }
  return true;
}

bool receive(int pipe, std::string& text) {
  std::size_t size = 0;
  if (!receive(pipe, &size, sizeof size)) return false;
  text.resize(size);
  return receive(pipe, text.data(), size);
}

/// In a process of its own: the program, its standard streams in files of `folder`.
[[noreturn]] void run_here(const std::string& arguments, const std::string& folder) {
  constexpr int kMode = 0600;
#ifdef DUALPIXEL_FINDS_LEAKS
  constexpr int kLeaks = 23;  // as LeakSanitizer's own
  // Reports go to the test's stderr: clang 14 warns in every fork that it cannot suspend the thread that forked.
  const std::intptr_t reports = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  __sanitizer_set_report_fd(reinterpret_cast<void*>(reports));
#endif
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  dup2(open((folder + "/out").c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, kMode), STDOUT_FILENO);
  dup2(open((folder + "/err").c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, kMode), STDERR_FILENO);
  wordexp_t words;
  if (wordexp(("dualpixel " + arguments).c_str(), &words, WRDE_NOCMD) != 0) std::abort();
  const int status = tools::program_main(static_cast<int>(words.we_wordc), words.we_wordv);
  std::cout.flush();
  std::fflush(nullptr);
#ifdef DUALPIXEL_FINDS_LEAKS
  if (__lsan_do_recoverable_leak_check() != 0) _exit(kLeaks);  // _exit() would not look
#endif
  _exit(status);  // libraries that end their threads on exit() would wait: a fork has none of them
}

/// The process that forks for each command: reads arguments and a folder, answers with a status of waitpid().
class Forker {
 public:
  Forker() {
    std::array<int, 2> commands{}, answers{};
    if (pipe2(commands.data(), O_CLOEXEC) != 0 || pipe2(answers.data(), O_CLOEXEC) != 0) std::abort();
    const pid_t child = fork();
    if (child == 0) {
      close(commands[1]), close(answers[0]);
      serve(commands[0], answers[1]);
    }
    close(commands[0]), close(answers[1]);
    commands_ = commands[1], answers_ = answers[0];
  }

  int status_of(const std::string& arguments, const std::string& folder) const {
    send(commands_, arguments);
    send(commands_, folder);
    int status = 0;
    if (!receive(answers_, &status, sizeof status)) throw std::runtime_error("run_command: its process has ended");
    return status;
  }

 private:
  [[noreturn]] static void serve(int commands, int answers) {
    std::string arguments, folder;
    while (receive(commands, arguments) && receive(commands, folder)) {
      const pid_t child = fork();
      if (child == 0) {
        close(commands), close(answers);
        run_here(arguments, folder);
      }
      int status = 0;
      waitpid(child, &status, 0);
      if (write(answers, &status, sizeof status) != sizeof status) break;
    }
    _exit(0);
  }

  int commands_, answers_;
};

std::optional<Forker> forker;

/// Starts it when all static objects are there, and before any test starts a thread.
class StartForker : public testing::Environment {
  void SetUp() override { forker.emplace(); }
};
[[maybe_unused]] testing::Environment* const kStartForker = testing::AddGlobalTestEnvironment(new StartForker);

}  // namespace

Outcome run_command(const std::string& arguments) {
  const TemporaryFolder folder;
  const int status = forker->status_of(arguments, folder.path.string());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(folder / "out"), read_bytes(folder / "err")};
}

}  // namespace dualpixel
