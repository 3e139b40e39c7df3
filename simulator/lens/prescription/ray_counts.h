#pragma once
#include <cstdint>

namespace dualpixel::simulator {

template <class Real, int N>
struct RayBatch;

/// How many rays ended in each way: see RayEnd in ray_trace.h.
struct RayCounts {
  std::uint64_t through = 0, clipped = 0, missed = 0, reflected = 0;
  template <class Real, int N>
  void add(const RayBatch<Real, N>& rays) {
    for (int i = 0; i < N; ++i) {
      const int end = static_cast<int>(rays.end[i]);
      ++(end == 0 ? through : end == 1 ? clipped : end == 2 ? missed : reflected);
    }
  }
};

}  // namespace dualpixel::simulator
