#include "simulator/render/motion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "simulator/render/camera_rays.h"
#include "simulator/render/glass_paths.h"

namespace dualpixel::simulator {
namespace {

/// The point on the sensor, meters, whose chief ray has `slope`: Newton's method from a point nearby. Chief rays are
/// nearly linear in it, so that three or four steps leave less than float's rounding. Empty where ten do not
/// find it: beyond the widest angle that the lens takes in, or where the distortion's formula turns back.
std::optional<glm::dvec2> place_of(const LensSampler& lens, glm::dvec2 slope, glm::dvec2 start_m) {
  constexpr int kMostSteps = 10;
  constexpr double kCloseEnoughPx = 1e-4;
  const double step_m = lens.sensor().pixel_pitch_m;
  glm::dvec2 at = start_m;
  for (int i = 0; i < kMostSteps; ++i) {
    const glm::dvec2 here = lens.chief_slope(at.x, at.y);
    const glm::dmat2 jacobian((lens.chief_slope(at.x + step_m, at.y) - here) / step_m,
                              (lens.chief_slope(at.x, at.y + step_m) - here) / step_m);
    const glm::dvec2 correction = glm::inverse(jacobian) * (slope - here);
    at += correction;
    if (glm::length(correction) < kCloseEnoughPx * step_m) return at;  // false where it is not a number
  }
  return {};
}

/// What the chief ray of a pixel sees, moved along with its triangle into `later_scene`; w = 0: infinitely far.
glm::dvec4 seen_point(const RenderScene& world, const CameraView& camera, int x, int y, const Scene& later_scene) {
  const Ray ray = chief_ray(camera, x, y);
  const std::optional<Hit> hit = seen_surface(world, ray);
  if (!hit) return glm::dvec4(ray.direction, 0);
  const Mesh& mesh = later_scene.meshes[hit->mesh];
  const glm::uvec3 corner = mesh.triangles[hit->triangle];
  const double u = hit->u, v = hit->v;
  const glm::dvec3 p0 = mesh.positions[corner.x], p1 = mesh.positions[corner.y], p2 = mesh.positions[corner.z];
  const glm::dvec4 seen((1 - u - v) * p0 + u * p1 + v * p2, 1);
  if (mesh.placements.empty()) return seen;
  return glm::dvec4(glm::dmat4x3(mesh.placements[hit->placement].world_from_mesh) * seen, 1);
}

/// From the world to a camera, for each of its rows; one for all where they share a pose.
std::vector<glm::dmat4> inverse_poses(const CameraView& camera) {
  if (!camera.row_poses) return {glm::inverse(glm::dmat4(camera.world_from_camera))};
  std::vector<glm::dmat4> poses;
  for (const glm::mat4& pose : *camera.row_poses) poses.push_back(glm::inverse(glm::dmat4(pose)));
  return poses;
}

/// Where the later camera sees a point, meters on the sensor, from a position nearby. The row where it is seen says
/// when, and thus where from: a few rounds settle it, since a row moves by far less than a row.
std::optional<glm::dvec2> place_in(const CameraView& later, const std::vector<glm::dmat4>& poses, glm::dvec4 point,
                                   glm::dvec2 start_m) {
  constexpr int kRounds = 6;
  const SensorGrid& sensor = later.lens.sensor();
  const int last = static_cast<int>(poses.size()) - 1;
  const auto row_at = [&](double y_m) {
    const double row = std::floor(y_m / sensor.pixel_pitch_m + sensor.principal_point_px.y);
    return static_cast<int>(std::clamp(row, 0.0, static_cast<double>(last)));
  };
  std::optional<glm::dvec2> place;
  for (int row = row_at(start_m.y), round = 0; round < kRounds; ++round) {
    const glm::dvec3 seen = poses[row] * point;
    if (!(seen.z > 0)) return {};
    place = place_of(later.lens, glm::dvec2(seen) / seen.z, start_m);
    if (!place || row_at(place->y) == row) break;
    row = row_at(place->y);
  }
  return place;
}

}  // namespace

Image trace_motion(const RenderScene& first_world, const CameraView& first, const Scene& later_scene,
                   const CameraView& later) {
  return trace_motion_rows(first_world, first, later_scene, later, 0, first.lens.sensor().height_px);
}

Image trace_motion_rows(const RenderScene& first_world, const CameraView& first, const Scene& later_scene,
                        const CameraView& later, int first_row, int end_row) {
  const SensorGrid& sensor = first.lens.sensor();
  const std::vector<glm::dmat4> poses = inverse_poses(later);
  Image motion(sensor.width_px, sensor.height_px, 2, std::numeric_limits<float>::infinity());
  tbb::parallel_for(first_row, end_row, [&](int y) {
    for (int x = 0; x < motion.width; ++x) {
      const glm::dvec2 start_m = sensor.middle_m(x, y);
      const glm::dvec4 point = seen_point(first_world, first, x, y, later_scene);
      const std::optional<glm::dvec2> end_m = place_in(later, poses, point, start_m);
      if (!end_m) continue;
      motion.at(x, y, 0) = static_cast<float>((end_m->x - start_m.x) / sensor.pixel_pitch_m);
      motion.at(x, y, 1) = static_cast<float>((end_m->y - start_m.y) / sensor.pixel_pitch_m);
    }
  });
  return motion;
}

std::optional<std::size_t> mesh_that_differs(const Scene& a, const Scene& b) {
  const std::size_t both = std::min(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < both; ++i) {
    if (a.meshes[i].triangles != b.meshes[i].triangles) return i;
    if (a.meshes[i].placements.size() != b.meshes[i].placements.size()) return i;
  }
  if (a.meshes.size() != b.meshes.size()) return both;
  return {};
}

}  // namespace dualpixel::simulator
