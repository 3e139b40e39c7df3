#include "simulator/sensor/motion.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

#include "capture/error.h"
#include "simulator/render/camera_rays.h"

namespace dualpixel::simulator {
namespace {

/// The place on the sensor, metres, whose chief ray has `slope`: Newton's method from a place nearby. Chief rays are
/// nearly linear in the place, so that three steps leave less than float's rounding.
glm::dvec2 place_of(const LensSampler& lens, glm::dvec2 slope, glm::dvec2 start_m) {
  const double step_m = lens.sensor().pixel_pitch_m;
  glm::dvec2 at = start_m;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec2 here = lens.chief_slope(at.x, at.y);
    const glm::dmat2 jacobian((lens.chief_slope(at.x + step_m, at.y) - here) / step_m,
                              (lens.chief_slope(at.x, at.y + step_m) - here) / step_m);
    at += glm::inverse(jacobian) * (slope - here);
  }
  return at;
}

void require_same_triangles(const Scene& a, const Scene& b) {
  bool same = a.meshes.size() == b.meshes.size();
  for (std::size_t i = 0; same && i < a.meshes.size(); ++i) {
    same = a.meshes[i].triangles == b.meshes[i].triangles;
  }
  if (!same) throw InputError("burst: the animation must not let triangles appear or vanish (a scale of 0?)");
}

}  // namespace

Image trace_motion(const RenderScene& first_world, const CameraView& first, const Scene& later_scene,
                   const CameraView& later) {
  require_same_triangles(first_world.scene, later_scene);
  const SensorGrid& sensor = first.lens.sensor();
  const glm::dmat4 later_from_world = glm::inverse(glm::dmat4(later.world_from_camera));
  Image motion(sensor.width_px, sensor.height_px, 2, std::numeric_limits<float>::infinity());
  tbb::parallel_for(0, motion.height, [&](int y) {
    for (int x = 0; x < motion.width; ++x) {
      RTCRayHit ray = chief_ray(first, x, y);
      glm::dvec4 point(ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z, 0);
      first_world.intersector.intersect(ray);
      if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        const Mesh& mesh = later_scene.meshes[ray.hit.geomID];
        const glm::uvec3 corner = mesh.triangles[ray.hit.primID];
        const double u = ray.hit.u, v = ray.hit.v;
        point = glm::dvec4((1 - u - v) * glm::dvec3(mesh.positions[corner.x]) +
                               u * glm::dvec3(mesh.positions[corner.y]) + v * glm::dvec3(mesh.positions[corner.z]),
                           1);
      }
      const glm::dvec3 seen = later_from_world * point;
      const glm::dvec2 start_m = sensor.middle_m(x, y);
      const glm::dvec2 moved_px =
          (place_of(later.lens, glm::dvec2(seen) / seen.z, start_m) - start_m) / sensor.pixel_pitch_m;
      if (!(seen.z > 0) || !std::isfinite(moved_px.x + moved_px.y)) continue;
      motion.at(x, y, 0) = static_cast<float>(moved_px.x);
      motion.at(x, y, 1) = static_cast<float>(moved_px.y);
    }
  });
  return motion;
}

}  // namespace dualpixel::simulator
