#include "tools/cli/signals.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>
#include <system_error>
#include <thread>

#include "capture/files.h"
#include "evaluation/methods/child_process.h"
#include "tools/cli/exit_status.h"

namespace dualpixel::tools {
namespace {

std::atomic<bool> first_is_noted = false;
std::atomic<int> noted_signal = 0;

int signal_pipe[2];

/// Any thread may be the one that a signal interrupts: OpenBLAS, which OpenCV and LAPACK may bring, starts some before
/// main() that block no signal.
void pass_signal_on(int signal_number) {
  const int error = errno;
  const auto byte = static_cast<unsigned char>(signal_number);
  [[maybe_unused]] const ssize_t written = write(signal_pipe[1], &byte, 1);
  errno = error;
}

int next_signal() {
  unsigned char byte = 0;
  while (read(signal_pipe[0], &byte, 1) != 1) {
  }
  return byte;
}

/// Writes a line to stderr, over a progress bar. Where nobody reads it, this thread goes on all the same.
void say(const std::string& line) {
  sigset_t pipe;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
  std::cerr << (isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "") << line << '\n';
}

/// Of the threads that would end the process one goes on; the others wait until it has.
void claim_the_end() {
  static std::atomic_flag claimed;
  while (claimed.test_and_set()) std::this_thread::sleep_for(std::chrono::seconds(1));
}

}  // namespace

void end_cleanly_on_signals() {
  constexpr int kSignals[] = {SIGINT, SIGTERM, SIGQUIT, SIGXCPU, SIGUSR1, SIGHUP};
  if (pipe2(signal_pipe, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  signal(SIGXFSZ, SIG_IGN);
  struct sigaction pass_on {};
  pass_on.sa_handler = pass_signal_on;
  pass_on.sa_flags = SA_RESTART;
  sigset_t handled;
  sigemptyset(&handled);
  for (const int each : kSignals) {
    struct sigaction before {};
    sigaction(each, nullptr, &before);
    const bool under_nohup = each == SIGHUP && before.sa_handler == SIG_IGN;
    if (!under_nohup) sigaction(each, &pass_on, nullptr);
    sigaddset(&handled, each);
  }
  pthread_sigmask(SIG_UNBLOCK, &handled, nullptr);  // who started the program may have blocked them
  std::thread([] {
    int signal_number = next_signal();
    if (first_is_noted) {
      noted_signal = signal_number;
      say("dualpixel: stopping when what is being made is whole; a second signal ends it at once");
      do signal_number = next_signal();
      while (signal_number == noted_signal && (signal_number == SIGXCPU || signal_number == SIGHUP));  // system's own
    }
    claim_the_end();
    evaluation::end_child_processes();
    stop_outputs();
    remove_unfinished_outputs();
    _exit(128 + signal_number);
  }).detach();
}

const std::atomic<int>& note_first_signal() {
  first_is_noted = true;
  return noted_signal;
}

void end_after(std::chrono::seconds limit) {
  std::thread([limit] {
    std::this_thread::sleep_for(limit);
    claim_the_end();
    stop_outputs();
    std::this_thread::sleep_for(std::chrono::seconds(1));  // a command whose output is whole ends by itself
    evaluation::end_child_processes();
    remove_unfinished_outputs();
    say(fmt::format("dualpixel: --max-time: not done after {} s", limit.count()));
    _exit(kBadInput);
  }).detach();
}

}  // namespace dualpixel::tools
