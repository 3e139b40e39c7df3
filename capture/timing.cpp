#include "capture/timing.h"

#include <malloc.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <limits>
#include <string>

namespace dualpixel {

Times times(const std::vector<std::function<void()>>& work, int repeats) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  Times best{std::vector<double>(work.size(), kInfinite), std::vector<double>(work.size(), kInfinite)};
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (std::size_t i = 0; i < work.size(); ++i) {
      const std::clock_t start = std::clock();
      best.ms[i] = std::min(best.ms[i], 1e3 * seconds(work[i]));
      best.cpu_ms[i] = std::min(best.cpu_ms[i], 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
  }
  return best;
}

double peak_mb(const std::function<void()>& work) {
  const auto status_kb = [](const std::string& field) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind(field, 0) == 0) return std::stod(line.substr(field.size() + 1));
    }
    return 0.0;
  };
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak starts from here
  const double before = status_kb("VmRSS");
  work();
  return std::max(status_kb("VmHWM") - before, 0.0) / 1024;
}

}  // namespace dualpixel
