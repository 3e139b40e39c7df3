#include "simulator/render/pixel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "simulator/render/bsdf.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/surface.h"
#include "simulator/sampling/sobol.h"
#include "simulator/sensor/cfa.h"

namespace dualpixel::simulator {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void set_ray(RTCRay16& rays, int i, glm::vec3 origin, glm::vec3 direction, float tfar) {
  rays.org_x[i] = origin.x, rays.org_y[i] = origin.y, rays.org_z[i] = origin.z;
  rays.dir_x[i] = direction.x, rays.dir_y[i] = direction.y, rays.dir_z[i] = direction.z;
  rays.tnear[i] = 0;
  rays.tfar[i] = tfar;
}

/// Light carried along the sixteen paths of one packet.
struct Paths {
  alignas(64) int active[kPacket];  ///< -1 or 0, as Embree wants it
  Vec3Packet throughput, radiance;
  alignas(64) float pdf[kPacket];  ///< solid-angle density of the ray's direction; infinite for camera rays
  Vec3Packet normal;               ///< of the surface that the ray left; unset for camera rays
};

/// Which of a pixel's samples a packet holds.
struct SamplePlace {
  std::uint32_t first, index_mask;
  std::uint64_t pixel_key;
};

struct Padded {
  alignas(64) float u[kPacket], v[kPacket];
};

/// Rays towards the lights, and what each adds to its path if nothing is in its way.
struct ShadowRays {
  alignas(64) int active[kPacket];
  RTCRay16 rays;
  Vec3Packet arriving;
};

/// kPacket where there is none.
int first_set(const int lanes[kPacket]) {
  int any = 0;
  for (int i = 0; i < kPacket; ++i) any |= lanes[i];
  if (!any) return kPacket;
  int first = 0;
  while (!lanes[first]) ++first;
  return first;
}

/// How much of light found along a sampled ray counts when the light sampler could have found it too (balance
/// heuristic, Veach 1995).
float mis_weight(float own_pdf, float other_pdf) {
  return own_pdf == kInfinity ? 1.0f : own_pdf / (own_pdf + other_pdf);
}

void add_light(Paths& paths, int i, glm::vec3 light) {
  paths.radiance.set(i, paths.radiance.at(i) + paths.throughput.at(i) * light);
}

void see_environment(const RenderScene& world, const RTCRayHit16& rays, Paths& paths, int i) {
  const Environment& environment = world.scene.environment;
  if (environment.radiance_nits.empty()) return;
  const glm::vec3 d = glm::normalize(glm::vec3(rays.ray.dir_x[i], rays.ray.dir_y[i], rays.ray.dir_z[i]));
  const float weight =
      paths.pdf[i] == kInfinity ? 1 : mis_weight(paths.pdf[i], world.lights.environment_pdf(paths.normal.at(i), d));
  add_light(paths, i, environment_radiance(environment, d) * weight);
}

void see_unlit(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RTCRayHit16& rays, Paths& paths) {
  Vec3Packet color;
  base_colors_at(scene, mesh, lanes, rays, color);
  Vec3Packet& r = paths.radiance;
  const Vec3Packet& t = paths.throughput;
  const float white_nits = scene.unlit_white_nits;
#pragma GCC ivdep
  for (int i = 0; i < kPacket; ++i) {
    const float white = lanes[i] ? white_nits : 0.0f;
    r.x[i] += t.x[i] * color.x[i] * white;
    r.y[i] += t.y[i] * color.y[i] * white;
    r.z[i] += t.z[i] * color.z[i] * white;
  }
}

/// The paths of `lanes`, all at one mesh: emission at the hit, a light sample, and, where a reflection is still to
/// come, the next ray.
void scatter(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], RTCRayHit16& rays, Paths& paths,
             const Padded& light, const Padded* reflection, ShadowRays& shadow) {
  SurfacePacket surface;
  surfaces_at(world.scene, world.scene.meshes[mesh_id], lanes, rays, surface);
  Vec3Packet to_eye, start;  // `start`: off the surface by more than the hit's rounding error
  alignas(64) float distance[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const float dx = rays.ray.dir_x[i], dy = rays.ray.dir_y[i], dz = rays.ray.dir_z[i];
    const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
    to_eye.x[i] = -dx / length, to_eye.y[i] = -dy / length, to_eye.z[i] = -dz / length;
    distance[i] = rays.ray.tfar[i] * length;
    const float px = surface.position.x[i], py = surface.position.y[i], pz = surface.position.z[i];
    const float off = 1e-5f * std::max(std::max(std::abs(px), std::abs(py)), std::max(std::abs(pz), distance[i]));
    start.x[i] = px + off * surface.geometric_normal.x[i];
    start.y[i] = py + off * surface.geometric_normal.y[i];
    start.z[i] = pz + off * surface.geometric_normal.z[i];
  }
  if (surface.emits) {
    for (int i = 0; i < kPacket; ++i) {
      if (!lanes[i]) continue;
      const float cosine = glm::dot(surface.geometric_normal.at(i), to_eye.at(i));
      const float weight =
          paths.pdf[i] == kInfinity
              ? 1
              : mis_weight(paths.pdf[i], world.lights.triangle_pdf(paths.normal.at(i), mesh_id, rays.hit.primID[i],
                                                                   distance[i], cosine));
      add_light(paths, i, surface.emission_nits.at(i) * weight);
    }
  }

  LightPacket l;
  world.lights.sample(lanes, start, surface.normal, light.u, light.v, l);
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const glm::vec3 direction = l.direction.at(i), radiance = l.radiance.at(i);
    const float cosine = glm::dot(surface.normal.at(i), direction);
    if (radiance != glm::vec3(0) && cosine > 0 && glm::dot(surface.geometric_normal.at(i), direction) > 0) {
      const Surface s = surface.at(i);
      const float weight = reflection && l.pdf[i] > 0 ? mis_weight(l.pdf[i], bsdf_pdf(s, to_eye.at(i), direction)) : 1;
      shadow.arriving.set(i, paths.throughput.at(i) * bsdf(s, to_eye.at(i), direction) * radiance * (cosine * weight));
      // stop short of the light's own surface
      set_ray(shadow.rays, i, start.at(i), direction, l.distance_m[i] * (1 - 1e-4f));
      shadow.active[i] = -1;
    }
  }

  for (int i = 0; reflection && i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const Surface s = surface.at(i);
    const glm::vec3 direction = sample_bsdf(s, to_eye.at(i), reflection->u[i], reflection->v[i]);
    const float n_l = glm::dot(s.normal, direction);
    const float pdf = bsdf_pdf(s, to_eye.at(i), direction);
    if (n_l > 0 && glm::dot(s.geometric_normal, direction) > 0 && pdf > 0) {
      paths.throughput.set(i, paths.throughput.at(i) * bsdf(s, to_eye.at(i), direction) * (n_l / pdf));
      paths.pdf[i] = pdf;
      paths.normal.set(i, s.normal);
      set_ray(rays.ray, i, start.at(i), direction, kInfinity);
      paths.active[i] = -1;
    }
  }
}

/// One step of all active paths: nearest hits, light found there, shadow rays.
void advance(const RenderScene& world, RTCRayHit16& rays, Paths& paths, const SamplePlace& place, int bounce,
             bool last) {
  const Scene& scene = world.scene;
  const bool coherent = bounce == 0;
  world.intersector.intersect(paths.active, rays, coherent);

  alignas(64) int waiting[kPacket];  // paths that have met a mesh and not been looked at
  bool any_missed = false;
  for (int i = 0; i < kPacket; ++i) {
    waiting[i] = rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? 0 : paths.active[i];
    any_missed |= waiting[i] != paths.active[i];
  }
  for (int i = 0; any_missed && i < kPacket; ++i) {
    if (paths.active[i] && !waiting[i]) see_environment(world, rays, paths, i);
  }
  alignas(64) ShadowRays shadow;
  for (int i = 0; i < kPacket; ++i) paths.active[i] = shadow.active[i] = 0;
  Padded light, reflection;
  bool sampled = false;
  for (int first; (first = first_set(waiting)) < kPacket;) {  // mesh by mesh: most packets see but one
    const unsigned mesh_id = rays.hit.geomID[first];
    alignas(64) int lanes[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      lanes[i] = rays.hit.geomID[i] == mesh_id ? waiting[i] : 0;
      waiting[i] &= ~lanes[i];
    }
    const Mesh& mesh = scene.meshes[mesh_id];
    if (scene.materials[mesh.material].unlit) {
      see_unlit(scene, mesh, lanes, rays, paths);
      continue;
    }
    if (!sampled) {
      padded_samples(place.first, place.index_mask, place.pixel_key, 2 * bounce, light.u, light.v);
      if (!last)
        padded_samples(place.first, place.index_mask, place.pixel_key, 2 * bounce + 1, reflection.u, reflection.v);
      sampled = true;
    }
    scatter(world, mesh_id, lanes, rays, paths, light, last ? nullptr : &reflection, shadow);
  }

  if (first_set(shadow.active) == kPacket) return;
  for (int i = 0; i < kPacket; ++i) {
    if (!shadow.active[i]) set_ray(shadow.rays, i, glm::vec3(0), glm::vec3(0, 0, 1), 0);
    shadow.rays.time[i] = 0;
    shadow.rays.mask[i] = ~0u;
    shadow.rays.flags[i] = 0;
  }
  world.intersector.occluded(shadow.active, shadow.rays, coherent);
  for (int i = 0; i < kPacket; ++i) {
    if (shadow.active[i] && shadow.rays.tfar[i] >= 0)
      paths.radiance.set(i, paths.radiance.at(i) + shadow.arriving.at(i));
  }
}

glm::vec3 sum_of(const Vec3Packet& lanes) {
  glm::vec3 sum(0);
  for (int i = 0; i < kPacket; ++i) sum += lanes.at(i);
  return sum;
}

}  // namespace

HalfRadiance render_pixel(const RenderScene& world, const CameraView& camera, const PathOptions& options, int x, int y,
                          std::uint32_t samples, std::uint64_t pixel_key) {
  constexpr int kPairs = kPacket / 2;
  const std::uint32_t index_mask = std::bit_ceil(std::max(samples, std::uint32_t{kPacket})) / 2 - 1;
  alignas(64) float joint[4][kPacket];
  LensPacket packet;
  alignas(64) RTCRayHit16 rays;
  alignas(64) Paths paths;
  const int color = camera.lens.has_color() ? cfa_color(x, y) : 1;
  Vec3Packet left_sum{}, right_sum{};
  for (std::uint32_t first = 0; first < samples; first += kPacket) {
    const int lanes = static_cast<int>(std::min<std::uint32_t>(kPacket, samples - first));
    // Pairs integrate a texture that slopes across the blur exactly: a fifth of the error at 32 samples. Each of a pair
    // has a light sample of its own: with one for both, the views would share their noise, and noise that lies at one
    // place in both pulls disparity to 0.
    mirrored_samples(first / 2, pixel_key, joint);
    if (options.ideal_aperture_scale) {
      camera.lens.sample_ideal(x, y, joint, static_cast<float>(*options.ideal_aperture_scale), packet);
    } else {
      camera.lens.sample(x, y, color, joint, packet);
    }
    to_world(packet, camera.world_from_camera, rays);
    for (int i = 0; i < kPacket; ++i) {
      const bool wanted = i < kPairs ? i < (lanes + 1) / 2 : i - kPairs < lanes / 2;
      paths.active[i] = wanted && packet.left[i] + packet.right[i] > 0 ? -1 : 0;
      paths.throughput.set(i, glm::vec3(1));
      paths.radiance.set(i, glm::vec3(0));
      paths.pdf[i] = kInfinity;
    }
    for (int bounce = 0;; ++bounce) {
      const bool last = bounce == options.max_bounces;
      if (bounce > 0) reset(rays);
      advance(world, rays, paths, {first / 2, index_mask, pixel_key}, bounce, last);
      if (last || first_set(paths.active) == kPacket) break;
    }
    for (int i = 0; i < kPacket; ++i) {
      left_sum.x[i] += packet.left[i] * paths.radiance.x[i];
      left_sum.y[i] += packet.left[i] * paths.radiance.y[i];
      left_sum.z[i] += packet.left[i] * paths.radiance.z[i];
      right_sum.x[i] += packet.right[i] * paths.radiance.x[i];
      right_sum.y[i] += packet.right[i] * paths.radiance.y[i];
      right_sum.z[i] += packet.right[i] * paths.radiance.z[i];
    }
  }
  const float scale = 1 / static_cast<float>(samples);
  return {sum_of(left_sum) * scale, sum_of(right_sum) * scale};
}

}  // namespace dualpixel::simulator
