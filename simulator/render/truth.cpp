#include "simulator/render/truth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "simulator/lens/disparity_field.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/glass_paths.h"
#include "simulator/render/shading/surface.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

/// Bits of what the ray through a photosite's middle meets.
enum Met : std::uint8_t { kPerson = 1, kHair = 2 };

std::uint8_t person_met(const Scene& scene, const Hit& hit) {
  const Mesh& mesh = scene.meshes[hit.mesh];
  const bool person = mesh.placements.empty() ? mesh.person : mesh.placements[hit.placement].person;
  if (!person) return 0;
  return mesh.is_hair() ? kPerson | kHair : kPerson;
}

/// The share of photosite (x, y) in which a person is seen through the middle of the pupil. Sixteen rays, of which no
/// two share a column or a row: an edge along either is off by at most 1/32.
float person_share(const RenderScene& world, const CameraView& camera, int x, int y) {
  constexpr int kRays = 16;
  const glm::mat4& pose = camera.pose(y);
  int met = 0;
  for (std::uint32_t i = 0; i < kRays; ++i) {
    const double dx = (i + 0.5) / kRays - 0.5, dy = ((reverse_bits(i) >> 28) + 0.5) / kRays - 0.5;
    const glm::dvec2 at = camera.lens.sensor().middle_m(x + dx, y + dy);
    const Ray ray{glm::vec3(pose[3]), glm::mat3(pose) * glm::vec3(camera.lens.chief_slope(at.x, at.y), 1)};
    const std::optional<Hit> hit = seen_surface(world, ray);
    met += hit && person_met(world.scene, *hit) != 0 ? 1 : 0;
  }
  return static_cast<float>(met) / kRays;
}

constexpr int kReach_px = 2;

/// What the middles of photosites meet, from row `first_row` on.
struct Meetings {
  int first_row, end_row, width;
  std::vector<std::uint8_t> met{};

  std::uint8_t& at(int x, int y) { return met[static_cast<std::size_t>(y - first_row) * width + x]; }
  std::uint8_t at(int x, int y) const { return met[static_cast<std::size_t>(y - first_row) * width + x]; }
};

/// Person masks of rows [first_row, end_row): 0 or 1 by what the middles of photosites meet, and shares within reach of
/// an outline or of hair, whose strands are narrower than a photosite.
void fill_person_mask(const RenderScene& world, const CameraView& camera, int first_row, int end_row,
                      const Meetings& met, Image& mask) {
  const int width = mask.width;
  const auto is_mixed = [&](int x, int y) {
    std::uint8_t any = 0, all = kPerson;
    for (int v = std::max(y - kReach_px, met.first_row); v <= std::min(y + kReach_px, met.end_row - 1); ++v) {
      for (int u = std::max(x - kReach_px, 0); u <= std::min(x + kReach_px, width - 1); ++u) {
        const std::uint8_t here = met.at(u, v);
        any |= here;
        all &= here;
      }
    }
    return (any & kHair) != 0 || (any & kPerson) != all;
  };
  tbb::parallel_for(first_row, end_row, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const bool person = (met.at(x, y) & kPerson) != 0;
      mask.at(x, y) = is_mixed(x, y) ? person_share(world, camera, x, y) : person ? 1.0f : 0.0f;
    }
  });
}

}  // namespace

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
  const int width = truth.depth_m.width;
  // an outline may lie in the rows beside, which another scene may fill
  Meetings met{std::max(first_row - kReach_px, 0), std::min(end_row + kReach_px, truth.depth_m.height), width};
  met.met.resize(static_cast<std::size_t>(met.end_row - met.first_row) * width);
  tbb::parallel_for(met.first_row, met.end_row, [&](int y) {
    if (y >= first_row && y < end_row) return;
    for (int x = 0; x < width; ++x) {
      const std::optional<Hit> hit = seen_surface(world, chief_ray(camera, x, y));
      if (hit) met.at(x, y) = person_met(world.scene, *hit);
    }
  });
  tbb::parallel_for(first_row, end_row, [&](int y) {
    const glm::mat3 rotation(camera.pose(y));
    for (int x = 0; x < width; ++x) {
      const Ray ray = chief_ray(camera, x, y);
      if (const std::optional<Hit> hit = seen_surface(world, ray)) {
        const Mesh& mesh = world.scene.meshes[hit->mesh];
        const glm::vec3 normal = glm::transpose(rotation) * geometric_normal(mesh, *hit, ray.direction);
        truth.depth_m.at(x, y) = hit->t;
        const bool placed = !mesh.placements.empty();
        truth.object_id.at(x, y) = placed ? mesh.placements[hit->placement].object_id : mesh.object_id;
        met.at(x, y) = person_met(world.scene, *hit);
        truth.valid.at(x, y) = 1;
        for (int c = 0; c < 3; ++c) truth.normal.at(x, y, c) = normal[c];
      }
      const DisparityCoefficients c = field.at(x + 0.5, y + 0.5);
      const double inverse_depth = 1 / static_cast<double>(truth.depth_m.at(x, y));
      truth.blur_px.at(x, y) = static_cast<float>(c.blur_slope_px_m * inverse_depth + c.blur_intercept_px);
      truth.disparity_dp_px.at(x, y) = static_cast<float>(c.slope_dp_px_m * inverse_depth + c.intercept_dp_px);
    }
  });
  fill_person_mask(world, camera, first_row, end_row, met, truth.person_mask);
}

}  // namespace dualpixel::simulator
