#include "scenes/framing/seen_surfaces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "capture/error.h"
#include "simulator/render/truth.h"
#include "simulator/simulate.h"

namespace dualpixel::scenes {

Truth seen_surfaces(const simulator::Simulation& s, const simulator::ReadyScene& ready) {
  constexpr int kWidth = 64;
  simulator::SensorGrid grid = simulator::sensor_grid(s.sensor);
  const double reduction = static_cast<double>(grid.width_px) / kWidth;
  const int height = std::max(4, static_cast<int>(std::lround(grid.height_px / reduction)));
  grid = {kWidth, height, grid.pixel_pitch_m * reduction, {0.5 * kWidth, 0.5 * height}};
  simulator::Lens lens;
  lens.thin = s.lens.thin;
  const simulator::CameraView camera{simulator::camera_pose(s, ready.scene), simulator::LensSampler(lens, grid)};
  return simulator::trace_truth(ready.world, camera);
}

double depth_at(const Truth& seen, double x_share, double y_share, const std::string& path, const char* field) {
  const double x = x_share * seen.depth_m.width, y = y_share * seen.depth_m.height;
  double nearest = std::numeric_limits<double>::infinity(), depth = 0;
  for (int py = 0; py < seen.depth_m.height; ++py) {
    for (int px = 0; px < seen.depth_m.width; ++px) {
      const double away = std::hypot(px + 0.5 - x, py + 0.5 - y);
      if (seen.valid.at(px, py) == 0 || away >= nearest) continue;
      nearest = away;
      depth = seen.depth_m.at(px, py);
    }
  }
  if (depth == 0) throw InputError(printable(path) + ": " + field + ": the camera sees no surface");
  return depth;
}

double depth_of_node(const Truth& seen, const std::string& node, const simulator::ReadyScene& ready,
                     const std::string& path, const char* field) {
  const std::vector<std::string>& names = ready.scene.object_names;
  const auto found = std::find(names.begin(), names.end(), node);
  const std::string where = printable(path) + ": " + field + ": " + printable(node) + ": ";
  if (found == names.end()) throw InputError(where + "the glTF file has no such node" + did_you_mean(node, names));
  const auto id = static_cast<std::uint32_t>(found - names.begin() + 1);
  std::vector<float> depths;
  for (std::size_t i = 0; i < seen.object_id.data.size(); ++i) {
    if (seen.object_id.data[i] == id) depths.push_back(seen.depth_m.data[i]);
  }
  if (depths.empty()) throw InputError(where + "the camera sees nothing of it");
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

}  // namespace dualpixel::scenes
