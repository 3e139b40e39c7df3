#include "simulator/held_camera.h"

#include <glm/glm.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "simulator/sensor/hand_shake.h"

namespace dualpixel::simulator {

double row_delay_s(const Simulation& s, double row) {
  return 1e-6 * s.sensor.row_time_us * (row - 0.5 * s.sensor.height_px);
}

CameraView held_at(const Simulation& s, CameraView view, double time_s, int first_row) {
  const glm::dmat4 held(view.world_from_camera);
  const auto pose_at = [&](double at_s) { return glm::mat4(held * hand_shake(s.hand_shake_seed, at_s, s.hand_shake)); };
  view.world_from_camera = pose_at(time_s);
  if (s.hand_shake > 0 && s.sensor.row_time_us > 0) {
    std::vector<glm::mat4> poses;
    for (int y = 0; y < view.lens.sensor().height_px; ++y) {
      poses.push_back(pose_at(time_s + row_delay_s(s, first_row + y + 0.5)));
    }
    view.row_poses = std::make_shared<const std::vector<glm::mat4>>(std::move(poses));
  }
  return view;
}

}  // namespace dualpixel::simulator
