#include "capture/image/display.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/image/image_io.h"
#include "capture/image/rows.h"

namespace dualpixel {

Image encode_for_display(const Image& linear, const DisplayOptions& options) {
  constexpr int kSteps = 4096;
  std::vector<float> table(kSteps + 2, 1.0f);
  for (int i = 0; i <= kSteps; ++i) table[i] = srgb_from_linear(static_cast<float>(i) / kSteps);

  const auto gain = static_cast<float>(std::exp2(options.exposure_ev));
  Image encoded(linear.width, linear.height, linear.channels);
  for_rows(linear.height, [&](int y) {
    for (int i = 0; i < linear.width * linear.channels; ++i) {
      const float value = gain * linear.row(y)[i];
      const float at = value > 0 ? kSteps * std::min(value, 1.0f) : 0.0f;
      const int low = static_cast<int>(at);
      encoded.row(y)[i] = table[low] + (at - static_cast<float>(low)) * (table[low + 1] - table[low]);
    }
  });
  return encoded;
}

}  // namespace dualpixel
