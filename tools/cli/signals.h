#pragma once
#include <atomic>
#include <chrono>

namespace dualpixel::tools {

/// A thread waits for SIGINT, SIGTERM, SIGQUIT, SIGXCPU, SIGUSR1 and, unless it is ignored, SIGHUP; it kills the
/// programs that we run, removes unfinished output and ends the process with 128 + signal. A file that exceeds the
/// shell's size limit is a failed write (EFBIG) like any other, instead of SIGXFSZ.
void end_cleanly_on_signals();

/// From now on the first signal is only noted in what is returned (0: none), with a line on stderr, for work that ends
/// by itself at its next step; the second ends the process as above.
const std::atomic<int>& note_first_signal();

/// Ends the process as a signal does about a second after `limit`, unless it ends by itself, with status 2 and a line
/// on stderr.
void end_after(std::chrono::seconds limit);

}  // namespace dualpixel::tools
