#include "simulator/render/pixel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "simulator/lens/lens_packet.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/shading/bsdf.h"
#include "simulator/render/shading/surface.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void set_ray(RayPacket& rays, int i, glm::vec3 origin, glm::vec3 direction, float far) {
  rays.origin_x[i] = origin.x, rays.origin_y[i] = origin.y, rays.origin_z[i] = origin.z;
  rays.direction_x[i] = direction.x, rays.direction_y[i] = direction.y, rays.direction_z[i] = direction.z;
  rays.far[i] = far;
  rays.mesh[i] = kNoMesh;
}

/// Light carried along the sixteen paths of one packet.
struct Paths {
  alignas(64) int active[kPacket];  ///< -1 or 0, as Embree wants it
  Vec3Packet throughput, radiance;
  alignas(64) float pdf[kPacket];  ///< solid-angle density of the ray's direction; infinite for camera rays
  Vec3Packet normal;               ///< of the surface that the ray left; unset for camera rays
};

/// Which of a pixel's samples a packet holds: `first` of each half packet.
struct SampleIndices {
  std::uint32_t first, index_mask;
  std::uint64_t pixel_key;
};

void random_samples(const SampleIndices& indices, std::uint32_t stream, float out[kPacket]) {
  for (int i = 0; i < kPacket; ++i) {
    out[i] = unit_float(static_cast<std::uint32_t>(hash(indices.pixel_key, 2 * indices.first + i, stream) >> 32));
  }
}

/// The four coordinates on pixel and pupil.
void camera_samples(Sampling sampling, const SampleIndices& indices, float out[4][kPacket]) {
  constexpr std::uint32_t kPixelStream = 0x1000, kPupilStream = 0x1001;  // beyond those of bounces
  switch (sampling) {
    case Sampling::random:
      for (int d = 0; d < 4; ++d) random_samples(indices, d, out[d]);
      return;
    case Sampling::padded:
      padded_samples(indices.first, indices.index_mask, indices.pixel_key, kPixelStream, out[0], out[1]);
      padded_samples(indices.first, indices.index_mask, indices.pixel_key, kPupilStream, out[2], out[3]);
      return;
    case Sampling::joint:
      joint_samples(2 * indices.first, indices.pixel_key, out);
      return;
    case Sampling::mirrored:
      // Pairs integrate a texture that slopes across the blur exactly: a fifth of the error at 32 samples.
      mirrored_samples(indices.first, indices.pixel_key, out);
      return;
  }
}

struct Padded {
  alignas(64) float u[kPacket], v[kPacket];
};

/// Numbers for the decision `stream` of each path. Each of a mirrored pair has its own: with one light sample for both,
/// the views would share their noise, and noise at the same position in both pulls disparity to 0.
void path_samples(Sampling sampling, const SampleIndices& indices, std::uint32_t stream, Padded& out) {
  if (sampling == Sampling::random) {
    random_samples(indices, 4 + 2 * stream, out.u);
    random_samples(indices, 5 + 2 * stream, out.v);
  } else {
    padded_samples(indices.first, indices.index_mask, indices.pixel_key, stream, out.u, out.v);
  }
}

void write_down(RayLog& log, const int active[kPacket], const RayPacket& rays, bool shadow, bool coherent) {
  LoggedRays& packet = log.emplace_back(LoggedRays{rays, {}, shadow, coherent});
  std::copy_n(active, kPacket, packet.active);
}

/// Rays towards the lights, and what each adds to its path if nothing is in its way.
struct ShadowRays {
  alignas(64) int active[kPacket];
  RayPacket rays;
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
/// heuristic, Veach 1995). Both finite.
float mis_weight(float own_pdf, float other_pdf) { return own_pdf / (own_pdf + other_pdf); }

void add_light(Paths& paths, int i, glm::vec3 light) {
  paths.radiance.set(i, paths.radiance.at(i) + paths.throughput.at(i) * light);
}

void see_environment(const RenderScene& world, const RayPacket& rays, Paths& paths, int i) {
  const Environment& environment = world.scene.environment;
  if (environment.radiance_nits.empty()) return;
  const glm::vec3 d = glm::normalize(glm::vec3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]));
  const float weight =
      paths.pdf[i] == kInfinity ? 1 : mis_weight(paths.pdf[i], world.lights.environment_pdf(paths.normal.at(i), d));
  add_light(paths, i, environment_radiance(environment, d) * weight);
}

void see_unlit(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays, Paths& paths) {
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

/// The sixteen hits of one packet, seen from where their rays came from.
struct Hits {
  SurfacePacket surface;
  Vec3Packet to_eye, start;  ///< `start`: off the surface by more than the hit's rounding error
  alignas(64) float distance[kPacket];
};

void hits_at(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], const RayPacket& rays, Hits& hits) {
  const SurfacePacket& surface = hits.surface;
  surfaces_at(world.scene, world.scene.meshes[mesh_id], lanes, rays, hits.surface);
  for (int i = 0; i < kPacket; ++i) {
    const float dx = rays.direction_x[i], dy = rays.direction_y[i], dz = rays.direction_z[i];
    const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
    hits.to_eye.x[i] = -dx / length, hits.to_eye.y[i] = -dy / length, hits.to_eye.z[i] = -dz / length;
    hits.distance[i] = rays.far[i] * length;
    const float px = surface.position.x[i], py = surface.position.y[i], pz = surface.position.z[i];
    const float off = 1e-5f * std::max(surface.magnitude[i], hits.distance[i]);
    hits.start.x[i] = px + off * surface.geometric_normal.x[i];
    hits.start.y[i] = py + off * surface.geometric_normal.y[i];
    hits.start.z[i] = pz + off * surface.geometric_normal.z[i];
  }
}

/// Light that the surface itself emits.
void add_emission(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], const RayPacket& rays,
                  const Hits& hits, Paths& paths) {
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const float cosine = glm::dot(hits.surface.geometric_normal.at(i), hits.to_eye.at(i));
    const float weight =
        paths.pdf[i] == kInfinity
            ? 1
            : mis_weight(paths.pdf[i], world.lights.triangle_pdf(paths.normal.at(i), mesh_id, rays.triangle[i],
                                                                 hits.distance[i], cosine));
    add_light(paths, i, hits.surface.emission_nits.at(i) * weight);
  }
}

/// One shadow ray from each hit to a sampled point of a light; `weighed` where a reflection could find the light too.
void sample_lights(const RenderScene& world, const int lanes[kPacket], const Hits& hits, const Padded& light,
                   bool weighed, const Paths& paths, ShadowRays& shadow) {
  LightPacket l;
  world.lights.sample(lanes, hits.start, hits.surface.normal, light.u, light.v, l);
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const glm::vec3 direction = l.direction.at(i), radiance = l.radiance.at(i), to_eye = hits.to_eye.at(i);
    const float cosine = glm::dot(hits.surface.normal.at(i), direction);
    if (radiance != glm::vec3(0) && cosine > 0 && glm::dot(hits.surface.geometric_normal.at(i), direction) > 0) {
      const Surface s = hits.surface.at(i);
      const float weight = weighed && l.pdf[i] > 0 ? mis_weight(l.pdf[i], bsdf_pdf(s, to_eye, direction)) : 1;
      shadow.arriving.set(i, paths.throughput.at(i) * bsdf(s, to_eye, direction) * radiance * (cosine * weight));
      // stop short of the light's own surface
      set_ray(shadow.rays, i, hits.start.at(i), direction, l.distance_m[i] * (1 - 1e-4f));
      shadow.active[i] = -1;
    }
  }
}

/// The next ray of each path.
void sample_reflections(const int lanes[kPacket], const Hits& hits, const Padded& reflection, RayPacket& rays,
                        Paths& paths) {
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const Surface s = hits.surface.at(i);
    const glm::vec3 to_eye = hits.to_eye.at(i);
    const glm::vec3 direction = sample_bsdf(s, to_eye, reflection.u[i], reflection.v[i]);
    const float n_l = glm::dot(s.normal, direction);
    const float pdf = bsdf_pdf(s, to_eye, direction);
    if (n_l > 0 && glm::dot(s.geometric_normal, direction) > 0 && pdf > 0) {
      paths.throughput.set(i, paths.throughput.at(i) * bsdf(s, to_eye, direction) * (n_l / pdf));
      paths.pdf[i] = pdf;
      paths.normal.set(i, s.normal);
      set_ray(rays, i, hits.start.at(i), direction, kInfinity);
      paths.active[i] = -1;
    }
  }
}

/// The paths of `lanes`, all at one mesh: emission at the hit, a light sample, and, where a reflection is still to
/// come, the next ray.
void scatter(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], RayPacket& rays, Paths& paths,
             const Padded& light, const Padded* reflection, ShadowRays& shadow) {
  Hits hits;
  hits_at(world, mesh_id, lanes, rays, hits);
  if (hits.surface.emits) add_emission(world, mesh_id, lanes, rays, hits, paths);
  sample_lights(world, lanes, hits, light, reflection != nullptr, paths, shadow);
  if (reflection) sample_reflections(lanes, hits, *reflection, rays, paths);
}

/// One step of all active paths: nearest hits, light found there, shadow rays.
void advance(const RenderScene& world, const PathOptions& options, RayPacket& rays, Paths& paths,
             const SampleIndices& indices, int bounce, bool last) {
  const Scene& scene = world.scene;
  const bool coherent = bounce == 0;
  if (options.log) write_down(*options.log, paths.active, rays, false, coherent);
  world.intersector.intersect(paths.active, rays, coherent);

  alignas(64) int waiting[kPacket];  // paths that have hit a mesh and are still to be shaded
  bool any_missed = false;
  for (int i = 0; i < kPacket; ++i) {
    waiting[i] = rays.mesh[i] == kNoMesh ? 0 : paths.active[i];
    any_missed |= waiting[i] != paths.active[i];
  }
  for (int i = 0; any_missed && i < kPacket; ++i) {
    if (paths.active[i] && !waiting[i]) see_environment(world, rays, paths, i);
  }
  alignas(64) ShadowRays shadow;
  for (int i = 0; i < kPacket; ++i) paths.active[i] = shadow.active[i] = 0;
  Padded light, reflection;
  bool sampled = false;
  for (int first; (first = first_set(waiting)) < kPacket;) {  // mesh by mesh: most packets hit only one
    const unsigned mesh_id = rays.mesh[first];
    alignas(64) int lanes[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      lanes[i] = rays.mesh[i] == mesh_id ? waiting[i] : 0;
      waiting[i] &= ~lanes[i];
    }
    const Mesh& mesh = scene.meshes[mesh_id];
    if (scene.materials[mesh.material].unlit) {
      see_unlit(scene, mesh, lanes, rays, paths);
      continue;
    }
    if (!sampled) {
      path_samples(options.sampling, indices, 2 * bounce, light);
      if (!last) path_samples(options.sampling, indices, 2 * bounce + 1, reflection);
      sampled = true;
    }
    scatter(world, mesh_id, lanes, rays, paths, light, last ? nullptr : &reflection, shadow);
  }

  if (first_set(shadow.active) == kPacket) return;
  if (options.log) write_down(*options.log, shadow.active, shadow.rays, true, false);
  alignas(64) int hidden[kPacket];
  world.intersector.occluded(shadow.active, shadow.rays, false, hidden);
  for (int i = 0; i < kPacket; ++i) {
    if (shadow.active[i] && !hidden[i]) paths.radiance.set(i, paths.radiance.at(i) + shadow.arriving.at(i));
  }
}

/// Camera rays of one packet of samples, in world axes, with their weights in the two views.
void camera_packet(const CameraView& camera, const PathOptions& options, int x, int y, const SampleIndices& indices,
                   LensPacket& packet, RayPacket& rays) {
  alignas(64) float samples[4][kPacket];
  camera_samples(options.sampling, indices, samples);
  if (options.ideal_aperture_scale) {
    camera.lens.sample_ideal(x, y, samples, static_cast<float>(*options.ideal_aperture_scale), packet);
  } else {
    camera.lens.sample(x, y, camera.lens.has_color() ? cfa_color(x, y) : 1, samples, packet);
  }
  to_world(packet, camera.world_from_camera, rays);
}

/// Starts a path for each of `count` samples that the lens lets pass. Half of them lie in each half of the pupil; an
/// odd one in the half that `odd_left` says.
void start_paths(const LensPacket& packet, int count, int odd_left, Paths& paths) {
  constexpr int kPairs = kPacket / 2;
  for (int i = 0; i < kPacket; ++i) {
    const bool wanted = i < kPairs ? i < (count + odd_left) / 2 : i - kPairs < (count + 1 - odd_left) / 2;
    paths.active[i] = wanted && packet.left[i] + packet.right[i] > 0 ? -1 : 0;
    paths.throughput.set(i, glm::vec3(1));
    paths.radiance.set(i, glm::vec3(0));
    paths.pdf[i] = kInfinity;
  }
}

void trace_paths(const RenderScene& world, const PathOptions& options, const SampleIndices& indices, RayPacket& rays,
                 Paths& paths) {
  for (int bounce = 0;; ++bounce) {
    const bool last = bounce == options.max_bounces;
    advance(world, options, rays, paths, indices, bounce, last);
    if (last || first_set(paths.active) == kPacket) break;
  }
}

void add_weighted(const float weight[kPacket], const Vec3Packet& radiance, Vec3Packet& sum) {
  for (int i = 0; i < kPacket; ++i) {
    sum.x[i] += weight[i] * radiance.x[i];
    sum.y[i] += weight[i] * radiance.y[i];
    sum.z[i] += weight[i] * radiance.z[i];
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
  const std::uint32_t index_mask = std::bit_ceil(std::max(samples, std::uint32_t{kPacket})) / 2 - 1;
  const int odd_left = static_cast<int>(hash(pixel_key) >> 63);  // which half of the pupil gets an odd sample
  LensPacket packet;
  alignas(64) RayPacket rays;
  alignas(64) Paths paths;
  Vec3Packet left_sum{}, right_sum{};
  for (std::uint32_t first = 0; first < samples; first += kPacket) {
    const SampleIndices indices{first / 2, index_mask, pixel_key};
    camera_packet(camera, options, x, y, indices, packet, rays);
    start_paths(packet, static_cast<int>(std::min<std::uint32_t>(kPacket, samples - first)), odd_left, paths);
    trace_paths(world, options, indices, rays, paths);
    add_weighted(packet.left, paths.radiance, left_sum);
    // the ideal lens gives both halves the same light: one sum serves both
    if (!options.ideal_aperture_scale) add_weighted(packet.right, paths.radiance, right_sum);
  }
  const float scale = 1 / static_cast<float>(samples);
  const glm::vec3 left = sum_of(left_sum) * scale;
  return {left, options.ideal_aperture_scale ? left : sum_of(right_sum) * scale};
}

}  // namespace dualpixel::simulator
