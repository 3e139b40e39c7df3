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

/// CPU time of all threads of this process so far, seconds.
inline double cpu_clock_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// CPU time of all threads of this process during the work: affected little by other load.
template <class Work>
double cpu_seconds(const Work& work) {
  const double start = cpu_clock_s();
  work();
  return cpu_clock_s() - start;
}

struct Times {
  std::vector<double> ms;
  std::vector<double> cpu_ms;  ///< of all threads together: affected least by other load
};

/// Best times of several pieces of work, measured in turn so that other load affects all of them alike.
Times times(const std::vector<std::function<void()>>& work, int repeats);

/// Peak memory of the process during the work above that before it, MB; 0 where the system does not report it.
double peak_mb(const std::function<void()>& work);

}  // namespace dualpixel
