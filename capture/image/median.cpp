#include "capture/image/median.h"

#include <algorithm>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel {
namespace {

float middle(float a, float b, float c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

}  // namespace

Image median_3x3(const Image& image) {
  const int width = image.width, height = image.height;
  Image out(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& lines) {
    // Each column sorted, border columns repeated: the median is that of the largest low, the middle of the middles and
    // the least high.
    std::vector<float> low(width + 2), mid(width + 2), high(width + 2);
    for (int y = lines.begin(); y < lines.end(); ++y) {
      const float* above = image.row(std::max(y - 1, 0));
      const float* here = image.row(y);
      const float* below = image.row(std::min(y + 1, height - 1));
      for (int x = 0; x < width; ++x) {
        const float least = std::min(above[x], here[x]), most = std::max(above[x], here[x]);
        low[x + 1] = std::min(least, below[x]);
        mid[x + 1] = std::max(least, std::min(most, below[x]));
        high[x + 1] = std::max(most, below[x]);
      }
      for (std::vector<float>* row : {&low, &mid, &high}) {
        row->front() = (*row)[1];
        row->back() = (*row)[width];
      }
      const float *l = low.data(), *m = mid.data(), *h = high.data();
      float* to = out.row(y);
      for (int x = 0; x < width; ++x) {
        to[x] = middle(std::max(std::max(l[x], l[x + 1]), l[x + 2]), middle(m[x], m[x + 1], m[x + 2]),
                       std::min(std::min(h[x], h[x + 1]), h[x + 2]));
      }
    }
  });
  return out;
}

}  // namespace dualpixel
