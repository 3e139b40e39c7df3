#pragma once
#include <atomic>

namespace dualpixel::tools {

/// A thread waits for SIGINT, SIGTERM and SIGUSR1, kills the programs that we run, removes unfinished output and ends
/// the process with 128 + signal.
/// A file that exceeds the shell's size limit is a failed write (EFBIG) like any other, instead of SIGXFSZ.
/// Call before any other thread starts: threads inherit the signal mask.
void end_cleanly_on_signals();

/// From now on the first signal is only noted in what is returned (0: none), for work that ends by itself at its next
/// step; the second ends the process as above.
const std::atomic<int>& note_first_signal();

}  // namespace dualpixel::tools
