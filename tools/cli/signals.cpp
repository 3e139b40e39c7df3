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

void clean_up() {
  evaluation::end_child_processes();
  remove_unfinished_outputs();
}

}  // namespace

void end_cleanly_on_signals() {
  signal(SIGXFSZ, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  for (const int each : {SIGINT, SIGTERM, SIGUSR1}) sigaddset(&signals, each);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals] {
    int signal_number = 0;
    sigwait(&signals, &signal_number);
    if (first_is_noted) {
      noted_signal = signal_number;
      sigwait(&signals, &signal_number);
    }
    clean_up();
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
    remove_unfinished_outputs();
    std::this_thread::sleep_for(std::chrono::seconds(1));  // a command whose output is whole ends by itself
    evaluation::end_child_processes();
    sigset_t pipe;  // perhaps nobody reads stderr
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
    std::cerr << fmt::format("dualpixel: --max-time: not done after {} s\n", limit.count());
    _exit(kBadInput);
  }).detach();
}

}  // namespace dualpixel::tools
