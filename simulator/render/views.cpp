#include "simulator/render/views.h"

#include <pmmintrin.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>
#include <xmmintrin.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>

#include "simulator/render/bsdf.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/surface.h"
#include "simulator/sampling/sobol.h"
#include "simulator/sensor/cfa.h"

namespace dualpixel::simulator {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A point to start a new ray from, off the surface by more than the hit's rounding error.
glm::vec3 leave(const Surface& s, float ray_length) {
  const glm::vec3 a = glm::abs(s.position);
  const float size = std::max(std::max(a.x, a.y), std::max(a.z, ray_length));
  return s.position + s.geometric_normal * (1e-5f * size);
}

void set_ray(RTCRay16& rays, int i, glm::vec3 origin, glm::vec3 direction, float tfar) {
  rays.org_x[i] = origin.x, rays.org_y[i] = origin.y, rays.org_z[i] = origin.z;
  rays.dir_x[i] = direction.x, rays.dir_y[i] = direction.y, rays.dir_z[i] = direction.z;
  rays.tnear[i] = 0;
  rays.tfar[i] = tfar;
}

/// Light carried along the sixteen paths of one packet.
struct Paths {
  int active[kPacket];  ///< -1 or 0, as Embree wants it
  glm::vec3 throughput[kPacket];
  glm::vec3 radiance[kPacket];
  float pdf[kPacket];         ///< solid-angle density of the ray's direction; infinite for camera rays
  glm::vec3 normal[kPacket];  ///< of the surface that the ray left; unset for camera rays
};

struct Padded {
  float u[kPacket], v[kPacket];
};

/// How much of light found along a sampled ray counts when the light sampler could have found it too (balance
/// heuristic, Veach 1995).
float mis_weight(float own_pdf, float other_pdf) {
  return own_pdf == kInfinity ? 1.0f : own_pdf / (own_pdf + other_pdf);
}

/// One step of all active paths: emission at the hit, one light sample with its shadow ray, and, where a reflection
/// is still to come, the next ray.
void advance(const RenderScene& world, RTCRayHit16& rays, Paths& paths, const Padded& light, const Padded* reflection,
             bool coherent) {
  const Scene& scene = world.scene;
  world.intersector.intersect(paths.active, rays, coherent);

  alignas(64) RTCRay16 shadow;
  alignas(64) int shadow_active[kPacket];
  glm::vec3 arriving[kPacket];
  bool any_shadow = false;
  for (int i = 0; i < kPacket; ++i) {
    shadow_active[i] = 0;
    if (!paths.active[i]) continue;
    paths.active[i] = 0;
    const glm::vec3 ray_direction(rays.ray.dir_x[i], rays.ray.dir_y[i], rays.ray.dir_z[i]);
    const unsigned mesh_id = rays.hit.geomID[i];
    if (mesh_id == RTC_INVALID_GEOMETRY_ID) {
      if (scene.environment.radiance_nits.empty()) continue;
      const glm::vec3 d = glm::normalize(ray_direction);
      const float weight =
          paths.pdf[i] == kInfinity ? 1 : mis_weight(paths.pdf[i], world.lights.environment_pdf(paths.normal[i], d));
      paths.radiance[i] += paths.throughput[i] * environment_radiance(scene.environment, d) * weight;
      continue;
    }
    const Mesh& mesh = scene.meshes[mesh_id];
    const unsigned triangle = rays.hit.primID[i];
    const Surface s = surface_at(scene, mesh, triangle, rays.hit.u[i], rays.hit.v[i], ray_direction);
    if (s.unlit) {
      paths.radiance[i] += paths.throughput[i] * s.base_color * scene.unlit_white_nits;
      continue;
    }
    const float length = glm::length(ray_direction);
    const glm::vec3 to_eye = ray_direction / -length;
    const float distance = rays.ray.tfar[i] * length;
    if (s.emission_nits != glm::vec3(0)) {
      const float cosine = glm::dot(s.geometric_normal, to_eye);
      const float weight =
          paths.pdf[i] == kInfinity
              ? 1
              : mis_weight(paths.pdf[i], world.lights.triangle_pdf(mesh_id, triangle, distance, cosine));
      paths.radiance[i] += paths.throughput[i] * s.emission_nits * weight;
    }

    const glm::vec3 start = leave(s, distance);
    const LightSample l = world.lights.sample(start, s.normal, light.u[i], light.v[i]);
    const float cosine = glm::dot(s.normal, l.direction);
    if (l.radiance != glm::vec3(0) && cosine > 0 && glm::dot(s.geometric_normal, l.direction) > 0) {
      const float weight = reflection && l.pdf > 0 ? mis_weight(l.pdf, bsdf_pdf(s, to_eye, l.direction)) : 1.0f;
      arriving[i] = paths.throughput[i] * bsdf(s, to_eye, l.direction) * l.radiance * (cosine * weight);
      // stop short of the light's own surface
      set_ray(shadow, i, start, l.direction, l.distance_m * (1 - 1e-4f));
      shadow_active[i] = -1;
      any_shadow = true;
    }

    if (reflection) {
      const glm::vec3 direction = sample_bsdf(s, to_eye, reflection->u[i], reflection->v[i]);
      const float n_l = glm::dot(s.normal, direction);
      const float pdf = bsdf_pdf(s, to_eye, direction);
      if (n_l > 0 && glm::dot(s.geometric_normal, direction) > 0 && pdf > 0) {
        paths.throughput[i] *= bsdf(s, to_eye, direction) * (n_l / pdf);
        paths.pdf[i] = pdf;
        paths.normal[i] = s.normal;
        set_ray(rays.ray, i, start, direction, kInfinity);
        paths.active[i] = -1;
      }
    }
  }

  if (any_shadow) {
    for (int i = 0; i < kPacket; ++i) {
      if (!shadow_active[i]) set_ray(shadow, i, glm::vec3(0), glm::vec3(0, 0, 1), 0);
      shadow.time[i] = 0;
      shadow.mask[i] = ~0u;
      shadow.flags[i] = 0;
    }
    world.intersector.occluded(shadow_active, shadow, coherent);
    for (int i = 0; i < kPacket; ++i) {
      if (shadow_active[i] && shadow.tfar[i] >= 0) paths.radiance[i] += arriving[i];
    }
  }
}

/// All samples of one pixel: sums of radiance over the left and the right half.
void render_pixel(const RenderScene& world, const CameraView& camera, const RenderOptions& options, int x, int y,
                  std::uint64_t pixel_key, float* left, float* right) {
  const auto samples = static_cast<std::uint32_t>(options.samples_per_pixel);
  const std::uint32_t index_mask = std::bit_ceil(std::max(samples, 16u)) - 1;
  alignas(64) float joint[4][kPacket];
  LensPacket packet;
  alignas(64) RTCRayHit16 rays;
  alignas(64) Paths paths;
  alignas(64) Padded light, reflection;
  const int color = camera.lens.has_color() ? cfa_color(x, y) : 1;
  glm::vec3 left_sum(0), right_sum(0);
  for (std::uint32_t first = 0; first < samples; first += kPacket) {
    const int lanes = static_cast<int>(std::min<std::uint32_t>(kPacket, samples - first));
    joint_samples(first, pixel_key, joint);
    if (options.ideal_aperture_scale) {
      camera.lens.sample_ideal(x, y, joint, static_cast<float>(*options.ideal_aperture_scale), packet);
    } else {
      camera.lens.sample(x, y, color, joint, packet);
    }
    to_world(packet, camera.world_from_camera, rays);
    for (int i = 0; i < kPacket; ++i) {
      paths.active[i] = i < lanes && packet.left[i] + packet.right[i] > 0 ? -1 : 0;
      paths.throughput[i] = glm::vec3(1);
      paths.radiance[i] = glm::vec3(0);
      paths.pdf[i] = kInfinity;
    }
    for (int bounce = 0;; ++bounce) {
      const bool last = bounce == options.max_bounces;
      padded_samples(first, index_mask, pixel_key, 2 * bounce, light.u, light.v);
      if (!last) padded_samples(first, index_mask, pixel_key, 2 * bounce + 1, reflection.u, reflection.v);
      if (bounce > 0) reset(rays);
      advance(world, rays, paths, light, last ? nullptr : &reflection, bounce == 0);
      if (last || std::all_of(paths.active, paths.active + kPacket, [](int a) { return a == 0; })) break;
    }
    for (int i = 0; i < lanes; ++i) {
      right_sum += packet.right[i] * paths.radiance[i];
      left_sum += packet.left[i] * paths.radiance[i];
    }
  }
  for (int c = 0; c < 3; ++c) {
    left[c] = left_sum[c] / samples;
    right[c] = right_sum[c] / samples;
  }
}

}  // namespace

Views render_views(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
                   const ProgressCallback& progress) {
  const int width = camera.lens.sensor().width_px, height = camera.lens.sensor().height_px;
  Views views{Image(width, height, 3), Image(width, height, 3)};
  std::atomic<std::size_t> pixels_done = 0;
  std::mutex progress_mutex;
  constexpr int kTile = 16;  // pixels a side: neighbours share the part of the scene that caches hold
  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, height, kTile, 0, width, kTile),
      [&](const tbb::blocked_range2d<int>& tile) {
        // Embree's advice: denormals cost time and carry no light.
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
        for (int y = tile.rows().begin(); y < tile.rows().end(); ++y) {
          for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) {
            const std::uint64_t key =
                hash(options.seed, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x));
            render_pixel(world, camera, options, x, y, key, &views.left.at(x, y), &views.right.at(x, y));
          }
        }
        pixels_done += tile.rows().size() * tile.cols().size();
        if (progress && progress_mutex.try_lock()) {
          progress(static_cast<double>(pixels_done) / views.left.pixel_count());
          progress_mutex.unlock();
        }
      },
      tbb::simple_partitioner());
  return views;
}

Image undivided(Views views) {
  for (std::size_t i = 0; i < views.left.data.size(); ++i) views.left.data[i] += views.right.data[i];
  return std::move(views.left);
}

}  // namespace dualpixel::simulator
