#include "scenes/people/photo/render.h"

#include <algorithm>

#include "scenes/people/photo/lighting_model.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/render/camera_rays.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::scenes {
namespace {

using simulator::kPacket;

}  // namespace

Rendering render(const RayTracer& tracer, const simulator::CameraView& camera, int people, std::uint64_t seed) {
  const SceneModel& scene = tracer.scene();
  const int width = camera.lens.sensor().width_px, height = camera.lens.sensor().height_px;
  Rendering out{Image(width, height, 3), Image(width, height, 3), Image(width, height, std::max(people, 1))};
  alignas(64) float samples[4][kPacket];
  alignas(64) float u[kPacket], v[kPacket];
  simulator::LensPacket packet;
  alignas(64) simulator::RayPacket rays;
  alignas(64) simulator::RayPacket shadow;
  alignas(64) int active[kPacket], hidden[kPacket];
  LightSample lit[kPacket];
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint64_t key = simulator::hash(seed, static_cast<std::uint64_t>(y) * width + x);
      simulator::joint_samples(0, key, samples);
      simulator::padded_samples(0, kPacket / 2 - 1, key, 1, u, v);
      camera.lens.sample_ideal(x, y, samples, 1, packet);
      simulator::to_world(packet, camera.world_from_camera, rays);
      std::fill_n(active, kPacket, -1);
      tracer.intersector().intersect(active, rays, true);
      for (int i = 0; i < kPacket; ++i) {
        active[i] = 0;
        const vec3 direction = glm::normalize(vec3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]));
        if (rays.mesh[i] == simulator::kNoMesh) {
          lit[i].seen = background_radiance(scene.dome, direction);
          continue;
        }
        const SceneObject& object = scene.objects[rays.mesh[i]];
        lit[i] = sample_light(scene, object, object.triangles[rays.triangle[i]], rays.u[i], rays.v[i], direction,
                              i % 2 == 0, u[i], v[i]);
        if (lit[i].reach_m <= 0) continue;
        active[i] = -1;
        shadow.origin_x[i] = lit[i].origin.x, shadow.origin_y[i] = lit[i].origin.y,
        shadow.origin_z[i] = lit[i].origin.z;
        shadow.direction_x[i] = lit[i].towards.x, shadow.direction_y[i] = lit[i].towards.y,
        shadow.direction_z[i] = lit[i].towards.z;
        shadow.far[i] = lit[i].reach_m;
      }
      tracer.intersector().occluded(active, shadow, false, hidden);
      vec3 all(0), of_people(0);
      for (int i = 0; i < kPacket; ++i) {
        const vec3 light = (active[i] && hidden[i] ? lit[i].hidden : lit[i].seen) / static_cast<float>(kPacket);
        all += light;
        const int person = rays.mesh[i] == simulator::kNoMesh ? -1 : scene.objects[rays.mesh[i]].person;
        if (person < 0) continue;
        of_people += light;
        out.coverage.at(x, y, person) += 1.0f / kPacket;
      }
      for (int c = 0; c < 3; ++c) {
        out.light.at(x, y, c) = all[c];
        out.people_light.at(x, y, c) = of_people[c];
      }
    }
  }
  return out;
}

}  // namespace dualpixel::scenes
