#include "simulator/lens/prescription/beam.h"

#include <array>
#include <vector>

namespace dualpixel::simulator {

BeamTrace trace_beam(const Beam& beam, double cx, double cy, double radius) {
  double x0 = cx - 2 * radius, x1 = cx + 2 * radius, y0 = cy - 2 * radius, y1 = cy + 2 * radius;
  BeamTrace bundle;
  std::vector<std::array<double, 2>> points;
  for (int side : {64, 256}) {
    bundle = {};
    points.clear();
    double low_x = x1, high_x = x0, low_y = y1, high_y = y0;
    const double dx = (x1 - x0) / side, dy = (y1 - y0) / side;
    BeamRays rays;
    for (int first = 0; first < side * side; first += kBeamLanes) {
      for (int i = 0; i < kBeamLanes; ++i) {
        const int cell = first + i;
        beam.launch(rays, i, x0 + (cell % side + 0.5) * dx, y0 + (cell / side + 0.5) * dy);
      }
      beam.trace(rays);
      bundle.counts.add(rays);
      move_to_plane(rays, beam.sensor_z());
      for (int i = 0; i < kBeamLanes; ++i) {
        if (rays.end[i] != 0) continue;
        const int cell = first + i;
        const double px = x0 + (cell % side + 0.5) * dx, py = y0 + (cell / side + 0.5) * dy;
        low_x = std::min(low_x, px), high_x = std::max(high_x, px);
        low_y = std::min(low_y, py), high_y = std::max(high_y, py);
        bundle.spot.add(rays.x[i], rays.y[i]);
        points.push_back({rays.x[i], rays.y[i]});
      }
    }
    bundle.area = bundle.spot.light * dx * dy;
    if (bundle.spot.light == 0) return bundle;
    x0 = low_x - 1.5 * dx, x1 = high_x + 1.5 * dx, y0 = low_y - 1.5 * dy, y1 = high_y + 1.5 * dy;
  }
  for (const auto& [x, y] : points) {
    bundle.radius = std::max(bundle.radius, std::hypot(x - bundle.spot.mean_x(), y - bundle.spot.mean_y()));
  }
  return bundle;
}

}  // namespace dualpixel::simulator
