#include "simulator/render/truth.h"

#include <tbb/parallel_for.h>

#include <limits>

#include "simulator/lens/disparity_field.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/shading/surface.h"

namespace dualpixel::simulator {

Truth trace_truth(const RenderScene& world, const CameraView& camera) {
  const SensorGrid& sensor = camera.lens.sensor();
  const int width = sensor.width_px;
  const int height = sensor.height_px;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Truth truth;
  truth.depth_m = Image(width, height, 1, kInfinity);
  truth.blur_px = Image(width, height);
  truth.disparity_dp_px = Image(width, height);
  truth.normal = Image(width, height, 3);
  truth.object_id = ImageU32(width, height);
  truth.person_mask = Image(width, height);
  truth.valid = Image(width, height);

  const DisparityField field(camera.lens);
  const glm::mat3 rotation(camera.world_from_camera);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const Ray ray = chief_ray(camera, x, y);
      if (const std::optional<Hit> hit = world.intersector.intersect(ray)) {
        const Mesh& mesh = world.scene.meshes[hit->mesh];
        const glm::vec3 normal = glm::transpose(rotation) * geometric_normal(mesh, *hit, ray.direction);
        truth.depth_m.at(x, y) = hit->t;
        const bool placed = !mesh.placements.empty();
        const bool person = placed ? mesh.placements[hit->placement].person : mesh.person;
        truth.object_id.at(x, y) = placed ? mesh.placements[hit->placement].object_id : mesh.object_id;
        truth.person_mask.at(x, y) = person ? 1.0f : 0.0f;
        truth.valid.at(x, y) = 1;
        for (int c = 0; c < 3; ++c) truth.normal.at(x, y, c) = normal[c];
      }
      const DisparityCoefficients c = field.at(x + 0.5, y + 0.5);
      const double inverse_depth = 1 / static_cast<double>(truth.depth_m.at(x, y));
      truth.blur_px.at(x, y) = static_cast<float>(c.blur_slope_px_m * inverse_depth + c.blur_intercept_px);
      truth.disparity_dp_px.at(x, y) = static_cast<float>(c.slope_dp_px_m * inverse_depth + c.intercept_dp_px);
    }
  });
  return truth;
}

}  // namespace dualpixel::simulator
