#include "scenes/drawn/face_box.h"

#include <cmath>

namespace dualpixel::scenes {

using glm::vec3;

nlohmann::json face_box(const std::vector<vec3>& outline, vec3 eye, vec3 forward,
                        const simulator::Simulation& simulation) {
  const simulator::SensorOptions& sensor = simulation.sensor;
  const auto px_per_slope =
      static_cast<float>(simulation.lens.thin.image_distance_m() / (1e-6 * sensor.pixel_pitch_um));
  const auto width = static_cast<float>(sensor.width_px), height = static_cast<float>(sensor.height_px);
  const vec3 right = glm::normalize(glm::cross(forward, vec3(0, 1, 0))), down = glm::cross(forward, right);
  glm::vec2 low(1e9f), high(-1e9f);
  for (const vec3& p : outline) {
    const vec3 q = p - eye;
    const float z = glm::dot(q, forward);
    if (z < 0.05f) return nullptr;
    const glm::vec2 slope(glm::dot(q, right) / z, glm::dot(q, down) / z);
    const glm::vec2 at = 0.5f * glm::vec2(width, height) + px_per_slope * slope;
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  if (low.x < 0 || low.y < 0 || high.x > width || high.y > height) return nullptr;
  return {std::floor(low.x), std::floor(low.y), std::ceil(high.x - low.x), std::ceil(high.y - low.y)};
}

}  // namespace dualpixel::scenes
