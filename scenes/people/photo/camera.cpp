#include "scenes/people/photo/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dualpixel::scenes {

simulator::CameraView make_camera(const CameraSetup& plan) {
  const vec3 forward = glm::normalize(plan.target - plan.eye);
  const vec3 level = glm::normalize(glm::cross(forward, vec3(0, 1, 0)));
  const vec3 level_down = glm::cross(forward, level);
  const vec3 right = std::cos(plan.roll) * level + std::sin(plan.roll) * level_down;
  const vec3 down = glm::cross(forward, right);
  simulator::Lens lens;
  lens.thin.focal_length_m = 0.05;  // nominal: with `power` only the field of view and the pupil matter
  lens.thin.f_number = lens.thin.focal_length_m / plan.aperture_m;
  lens.thin.focus_distance_m = std::max(plan.focus_m, 0.1f);
  lens.thin.focusing = simulator::ThinLens::Focusing::power;
  simulator::SensorGrid sensor;
  sensor.width_px = plan.width_px;
  sensor.height_px = plan.height_px;
  sensor.pixel_pitch_m =
      lens.thin.focal_length_m * plan.height_m / glm::distance(plan.eye, plan.target) / plan.height_px;
  sensor.principal_point_px = {0.5 * plan.width_px, 0.5 * plan.height_px};
  const glm::mat4 pose(glm::vec4(right, 0), glm::vec4(down, 0), glm::vec4(forward, 0), glm::vec4(plan.eye, 1));
  return {pose, simulator::LensSampler(lens, sensor)};
}

vec3 project(const simulator::CameraView& camera, vec3 point) {
  const vec3 local = (point - vec3(camera.world_from_camera[3])) * mat3(camera.world_from_camera);
  const auto& sensor = camera.lens.sensor();
  const auto scale = static_cast<float>(camera.lens.lens().thin.image_distance_m() / sensor.pixel_pitch_m);
  const float z = std::max(local.z, 1e-3f);
  return {static_cast<float>(sensor.principal_point_px.x) + scale * local.x / z,
          static_cast<float>(sensor.principal_point_px.y) + scale * local.y / z, local.z};
}

vec3 direction_of(const simulator::CameraView& camera, vec2 at) {
  const auto& sensor = camera.lens.sensor();
  const auto scale = static_cast<float>(sensor.pixel_pitch_m / camera.lens.lens().thin.image_distance_m());
  const vec2 middle(sensor.principal_point_px.x, sensor.principal_point_px.y);
  return glm::normalize(mat3(camera.world_from_camera) * vec3(scale * (at - middle), 1));
}

float lowest_visible_m(const simulator::CameraView& camera, float reach_m) {
  const auto& sensor = camera.lens.sensor();
  const vec3 eye(camera.world_from_camera[3]);
  float lowest = eye.y;
  for (const int x : {0, sensor.width_px}) {
    const vec3 d = direction_of(camera, vec2(x, sensor.height_px));
    for (const float z : {-reach_m, reach_m}) {
      if (d.z > -1e-3f) return std::numeric_limits<float>::lowest();  // straight down, or back
      lowest = std::min(lowest, eye.y + d.y * std::max((z - eye.z) / d.z, 0.0f));
    }
  }
  return lowest;
}

}  // namespace dualpixel::scenes
