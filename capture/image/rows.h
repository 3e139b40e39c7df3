#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace dualpixel {

/// Calls f(y) for every row, in parallel. Rows must not depend on each other.
template <typename F>
void for_rows(int height, const F& f) {
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) f(y);
  });
}

}  // namespace dualpixel
