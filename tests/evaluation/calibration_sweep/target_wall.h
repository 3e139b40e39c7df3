#pragma once
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "evaluation/calibration_sweep/calibration_target.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::evaluation {

/// The calibration target as a scene for the renderer: a wall that shines by itself, for a camera at the origin.
inline simulator::Scene target_wall(const CalibrationTarget& target, const TargetPrint& print) {
  const int size = print.texture.width;
  simulator::Texture texture{size, size};
  for (const float value : print.texture.data) {
    const auto level = static_cast<std::uint8_t>(std::lround(255 * value));
    texture.rgba.insert(texture.rgba.end(), {level, level, level, 255});
  }
  simulator::Scene scene = simulator::testing::shining_picture(std::move(texture), 500);
  // twice the print's size: it repeats
  const auto half = static_cast<float>(size * print.texel_m);
  const auto tangent = static_cast<float>(std::tan(target.tilt_x_deg * std::numbers::pi / 180));
  simulator::Mesh mesh;
  for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
    // y down here, up in the scene; a texel's value is that at its center
    const float own = 0.5f + 0.5f / static_cast<float>(size);
    mesh.positions.push_back({x * half, -y * half, -static_cast<float>(target.distance_m) - tangent * x * half});
    mesh.uv0.push_back({x + own, y + own});
  }
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};
  mesh.object_id = 1;
  scene.meshes = {mesh};
  return scene;
}

}  // namespace dualpixel::evaluation
