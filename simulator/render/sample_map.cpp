#include "simulator/render/sample_map.h"

namespace dualpixel::simulator {

double SampleMap::total_samples() const {
  double sum = 0;
  for (int i = 0; i < columns() * rows(); ++i) {
    const Tile t = tile_at(*this, i);
    sum += static_cast<double>(t.samples) * (t.x1 - t.x0) * (t.y1 - t.y0);
  }
  return sum;
}

SampleMap uniform_map(int width_px, int height_px, std::uint32_t samples) {
  SampleMap map{width_px, height_px, {}, {}};
  map.samples.assign(static_cast<std::size_t>(map.columns()) * map.rows(), samples);
  return map;
}

}  // namespace dualpixel::simulator
