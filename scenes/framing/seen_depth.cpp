#include "scenes/framing/seen_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "capture/error.h"
#include "simulator/render/truth.h"
#include "simulator/simulate.h"

namespace dualpixel::scenes {

namespace {

/// Through a pinhole, in a picture of 64 columns: enough to focus by.
simulator::CameraView small_picture(const simulator::Simulation& s, const simulator::ReadyScene& ready) {
  constexpr int kWidth = 64;
  simulator::SensorGrid grid = simulator::sensor_grid(s.sensor);
  const double reduction = static_cast<double>(grid.width_px) / kWidth;
  const int height = std::max(4, static_cast<int>(std::lround(grid.height_px / reduction)));
  grid = {kWidth, height, grid.pixel_pitch_m * reduction, {0.5 * kWidth, 0.5 * height}};
  simulator::Lens lens;
  lens.thin = s.lens.thin;
  return {simulator::camera_pose(s, ready.scene), simulator::LensSampler(lens, grid)};
}

/// Rows 0 ... `count` - 1, those nearest to `y` first.
std::vector<int> rows_around(double y, int count) {
  std::vector<int> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), 0);
  std::stable_sort(rows.begin(), rows.end(),
                   [&](int a, int b) { return std::abs(a + 0.5 - y) < std::abs(b + 0.5 - y); });
  return rows;
}

}  // namespace

double seen_depth(const simulator::Simulation& s, const simulator::ReadyScene& ready, double x_share, double y_share,
                  const std::string& path, const char* field) {
  const simulator::CameraView camera = small_picture(s, ready);
  Truth seen = simulator::empty_truth(camera.lens.sensor());
  const double x = x_share * seen.depth_m.width, y = y_share * seen.depth_m.height;
  double nearest = std::numeric_limits<double>::infinity(), depth = 0;
  for (const int py : rows_around(y, seen.depth_m.height)) {
    if (std::abs(py + 0.5 - y) >= nearest) break;  // most often the first row has it
    simulator::trace_truth_rows(ready.world, camera, py, py + 1, seen);
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

double seen_depth_of_node(const simulator::Simulation& s, const simulator::ReadyScene& ready, const std::string& node,
                          const std::string& path, const char* field) {
  const std::vector<std::string>& names = ready.scene.object_names;
  const auto found = std::find(names.begin(), names.end(), node);
  const std::string where = printable(path) + ": " + field + ": " + printable(node) + ": ";
  if (found == names.end()) throw InputError(where + "the glTF file has no such node" + did_you_mean(node, names));
  const auto id = static_cast<std::uint32_t>(found - names.begin() + 1);
  const Truth seen = simulator::trace_truth(ready.world, small_picture(s, ready));
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
