#include "pipeline/defocus/enlarge.h"

#include "pipeline/defocus/rgba.h"

namespace dualpixel::pipeline {

RowEnlarger::RowEnlarger(const Image& rgba, int width) : rgba_(rgba), columns_(width) {
  for (int x = 0; x < width; ++x) columns_[x] = linear_tap(x, 2 * rgba.width, rgba.width);
}

void RowEnlarger::operator()(int y, std::vector<float>& mixed, std::vector<float>& out) const {
  const LinearTap line = linear_tap(y, 2 * rgba_.height, rgba_.height);
  const float* low = rgba_.row(line.low);
  const float* high = rgba_.row(line.high);
  mixed.resize(4 * static_cast<std::size_t>(rgba_.width));
  out.resize(4 * columns_.size());
  for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] = low[i] + line.weight_of_high * (high[i] - low[i]);
  for (std::size_t x = 0; x < columns_.size(); ++x) {
    const Rgba a = load_rgba(mixed.data() + 4 * columns_[x].low);
    const Rgba b = load_rgba(mixed.data() + 4 * columns_[x].high);
    store_rgba(a + columns_[x].weight_of_high * (b - a), out.data() + 4 * x);
  }
}

}  // namespace dualpixel::pipeline
