#include "simulator/render/truth.h"

#include <tbb/parallel_for.h>

#include <limits>

#include "simulator/render/surface.h"

namespace dualpixel::simulator {

Truth trace_truth(const RenderScene& world, const CameraView& camera) {
  const int width = camera.width_px;
  const int height = camera.height_px;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Truth truth;
  truth.depth_m = Image(width, height, 1, kInfinity);
  truth.blur_px = Image(width, height);
  truth.disparity_dp_px = Image(width, height);
  truth.normal = Image(width, height, 3);
  truth.object_id = ImageU32(width, height);
  truth.person_mask = Image(width, height);
  truth.valid = Image(width, height);

  const double x_per_px = camera.pixel_pitch_m / camera.lens.image_distance_m();
  const glm::mat3 rotation(camera.world_from_camera);
  const glm::vec3 origin(camera.world_from_camera[3]);
  constexpr int kPhotositesPerDpPixel = 2;  // horizontally
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 direction =
          rotation * glm::vec3((x + 0.5 - camera.principal_point_px.x) * x_per_px,
                               (y + 0.5 - camera.principal_point_px.y) * x_per_px, 1);  // so that t is planar depth
      RTCRayHit ray{};
      ray.ray.org_x = origin.x, ray.ray.org_y = origin.y, ray.ray.org_z = origin.z;
      ray.ray.dir_x = direction.x, ray.ray.dir_y = direction.y, ray.ray.dir_z = direction.z;
      ray.ray.tfar = kInfinity;
      ray.ray.mask = ~0u;
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      world.intersector.intersect(ray);
      if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        const Mesh& mesh = world.scene.meshes[ray.hit.geomID];
        const Surface s = surface_at(world.scene, mesh, ray.hit.primID, ray.hit.u, ray.hit.v, direction);
        const glm::vec3 normal = glm::transpose(rotation) * s.geometric_normal;
        truth.depth_m.at(x, y) = ray.ray.tfar;
        truth.object_id.at(x, y) = mesh.object_id;
        truth.person_mask.at(x, y) = mesh.person ? 1.0f : 0.0f;
        truth.valid.at(x, y) = 1;
        for (int c = 0; c < 3; ++c) truth.normal.at(x, y, c) = normal[c];
      }
      const double blur_px = camera.lens.blur_diameter_m(truth.depth_m.at(x, y)) / camera.pixel_pitch_m;
      truth.blur_px.at(x, y) = static_cast<float>(blur_px);
      truth.disparity_dp_px.at(x, y) = static_cast<float>(camera.split.alpha() * blur_px / kPhotositesPerDpPixel);
    }
  });
  return truth;
}

}  // namespace dualpixel::simulator
