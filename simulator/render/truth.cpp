#include "simulator/render/truth.h"

#include <tbb/parallel_for.h>

#include <limits>

#include "simulator/lens/disparity_field.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/glass_paths.h"
#include "simulator/render/shading/surface.h"

namespace dualpixel::simulator {

Truth trace_truth(const RenderScene& world, const CameraView& camera) {
  Truth truth = empty_truth(camera.lens.sensor());
  trace_truth_rows(world, camera, 0, truth.depth_m.height, truth);
  return truth;
}

Truth empty_truth(const SensorGrid& sensor) {
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
  return truth;
}

void trace_truth_rows(const RenderScene& world, const CameraView& camera, int first_row, int end_row, Truth& truth) {
  const DisparityField field(camera.lens);
  tbb::parallel_for(first_row, end_row, [&](int y) {
    const glm::mat3 rotation(camera.pose(y));
    for (int x = 0; x < truth.depth_m.width; ++x) {
      const Ray ray = chief_ray(camera, x, y);
      if (const std::optional<Hit> hit = seen_surface(world, ray)) {
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
}

}  // namespace dualpixel::simulator
