#include "scenes/drawn/face_box.h"

#include <cmath>

namespace dualpixel::scenes {

using glm::vec3;

namespace {

float px_per_slope(const simulator::Simulation& s) {
  return static_cast<float>(s.lens.thin.image_distance_m() / (1e-6 * s.sensor.pixel_pitch_um));
}

glm::vec2 picture_size(const simulator::Simulation& s) {
  return {static_cast<float>(s.sensor.width_px), static_cast<float>(s.sensor.height_px)};
}

nlohmann::json box_of(glm::vec2 low, glm::vec2 high, glm::vec2 size) {
  if (low.x < 0 || low.y < 0 || high.x > size.x || high.y > size.y) return nullptr;
  return {std::floor(low.x), std::floor(low.y), std::ceil(high.x - low.x), std::ceil(high.y - low.y)};
}

}  // namespace

nlohmann::json face_box(const std::vector<vec3>& outline, vec3 eye, vec3 forward,
                        const simulator::Simulation& simulation) {
  const glm::vec2 size = picture_size(simulation);
  const vec3 right = glm::normalize(glm::cross(forward, vec3(0, 1, 0))), down = glm::cross(forward, right);
  glm::vec2 low(1e9f), high(-1e9f);
  for (const vec3& p : outline) {
    const vec3 q = p - eye;
    const float z = glm::dot(q, forward);
    if (z < 0.05f) return nullptr;
    const glm::vec2 slope(glm::dot(q, right) / z, glm::dot(q, down) / z);
    const glm::vec2 at = 0.5f * size + px_per_slope(simulation) * slope;
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  return box_of(low, high, size);
}

nlohmann::json face_box_after(const simulator::Simulation& before, const simulator::Simulation& after) {
  const bool stays =
      before.pose == after.pose && before.camera_node == after.camera_node && before.model_size_m == after.model_size_m;
  if (!before.face_px || !stays) return nullptr;
  const auto [x, y, width, height] = *before.face_px;
  const float scale = px_per_slope(after) / px_per_slope(before);
  const glm::vec2 size = picture_size(after), half = 0.5f * picture_size(before);
  const auto moved = [&](double px, double py) {
    return 0.5f * size + scale * (glm::vec2(static_cast<float>(px), static_cast<float>(py)) - half);
  };
  return box_of(moved(x, y), moved(x + width, y + height), size);
}

}  // namespace dualpixel::scenes
