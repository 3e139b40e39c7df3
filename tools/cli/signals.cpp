#include "tools/cli/signals.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <iostream>
#include <thread>

#include "capture/files.h"
#include "evaluation/methods/child_process.h"
#include "tools/cli/exit_status.h"

namespace dualpixel::tools {
namespace {

std::atomic<bool> first_is_noted = false;
std::atomic<int> noted_signal = 0;

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
  signal(SIGXFSZ, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  for (const int each : {SIGINT, SIGTERM, SIGQUIT, SIGXCPU, SIGUSR1}) sigaddset(&signals, each);
  struct sigaction hangup {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) sigaddset(&signals, SIGHUP);  // nohup has it ignored
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int signal_number = 0;
    sigwait(&signals, &signal_number);
    if (first_is_noted) {
      noted_signal = signal_number;
      say("dualpixel: stopping when what is being made is whole; a second signal ends it at once");
      sigwait(&signals, &signal_number);
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
