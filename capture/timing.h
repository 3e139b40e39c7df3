#pragma once
#include <chrono>
#include <ctime>
#include <functional>
#include <vector>

namespace dualpixel {

/// Wall time of a piece of work.
template <class Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// CPU time that all threads of this process spend meanwhile: on a shared machine others count little.
template <class Work>
double cpu_seconds(const Work& work) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

struct Times {
  std::vector<double> ms;
  std::vector<double> cpu_ms;  ///< of all threads together: what a busy machine changes least
};

/// Best times of pieces of work done turn by turn, so that a busy machine slows all of them.
Times times(const std::vector<std::function<void()>>& work, int repeats);

/// How far the process' memory rises above what it held before, MB; 0 where the system doesn't say.
double peak_mb(const std::function<void()>& work);

}  // namespace dualpixel
