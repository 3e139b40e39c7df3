#include "simulator/lens/lens_shading.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_sampler.h"

namespace dualpixel::simulator {

Image relative_light(const LensSampler& lens) {
  constexpr int kColumns = 17, kRows = 13, kRays = 16384;
  constexpr float kEven = 0.001f;
  const auto is_even = [](float l) { return std::abs(l - 1) < kEven; };
  const auto light_at = [&](int x, int y) {
    const DisparityCoefficients at = trace_disparity(lens, x, y, kRays);
    return static_cast<float>(at.left_light + at.right_light);
  };
  // Every sample of a data set needs this; tracing 221 places took longer than the rest of a small sample.
  if (same_everywhere(lens.lens()) && is_even(light_at(0, 0))) return {};
  const SensorGrid& sensor = lens.sensor();
  Image light(std::clamp(sensor.width_px, 2, kColumns), std::clamp(sensor.height_px, 2, kRows));
  tbb::parallel_for(0, light.width * light.height, [&](int i) {
    const int column = i % light.width, row = i / light.width;
    const double x = column * (sensor.width_px - 1.0) / (light.width - 1);
    const double y = row * (sensor.height_px - 1.0) / (light.height - 1);
    light.at(column, row) = light_at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
  });
  return std::all_of(light.data.begin(), light.data.end(), is_even) ? Image() : light;
}

}  // namespace dualpixel::simulator
