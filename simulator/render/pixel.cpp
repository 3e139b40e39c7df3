#include "simulator/render/pixel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "simulator/lens/lens_packet.h"
#include "simulator/render/camera_rays.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

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

/// Camera rays of one packet of samples, in world axes, with their weights in the two views.
void camera_packet(const CameraView& camera, const PathOptions& options, int x, int y, const SampleIndices& indices,
                   LensPacket& packet, RayPacket& rays) {
  alignas(64) float samples[4][kPacket];
  camera_samples(options.sampling, indices, samples);
  if (options.ideal_aperture_scale) {
    camera.lens.sample_ideal(x, y, samples, static_cast<float>(*options.ideal_aperture_scale), packet);
  } else {
    const int color = options.color.value_or(cfa_color(x, y));
    // packets take the wavelengths of the filter's band by turns, and photosites begin anywhere
    const std::uint32_t draw = indices.first / (kPacket / 2) + static_cast<std::uint32_t>(indices.pixel_key >> 40);
    camera.lens.sample(x, y, camera.lens.has_color() ? color : 1, samples, packet, draw);
    if (camera.lens.diffracts()) {
      constexpr std::uint32_t kDiffractionStream = 0x1002;
      alignas(64) float u[kPacket], v[kPacket];
      padded_samples(indices.first, indices.index_mask, indices.pixel_key, kDiffractionStream, u, v);
      camera.lens.bend(color, u, v, packet);
    }
  }
  to_world(packet, camera.pose(y), rays);
}

/// Whether lane `i` of a packet is one of `count` samples: half of them lie in each half of the pupil, an odd one in
/// the half that `odd_left` says.
bool is_wanted(int i, int count, int odd_left) {
  constexpr int kPairs = kPacket / 2;
  return i < kPairs ? i < (count + odd_left) / 2 : i - kPairs < (count + 1 - odd_left) / 2;
}

/// Which half of the pupil gets the last of an odd number of samples.
int odd_left_of(std::uint64_t pixel_key) { return static_cast<int>(hash(pixel_key) >> 63); }

/// Weighs samples that nobody wants by nothing.
void keep_wanted(int count, int odd_left, LensPacket& packet) {
  for (int i = 0; i < kPacket; ++i) {
    if (!is_wanted(i, count, odd_left)) packet.left[i] = packet.right[i] = 0;
  }
}

/// Starts a path for each sample that the lens lets pass.
void start_paths(const LensPacket& packet, float spread, Paths& paths) {
  for (int i = 0; i < kPacket; ++i) {
    paths.active[i] = packet.left[i] + packet.right[i] > 0 ? -1 : 0;
    paths.throughput.set(i, glm::vec3(1));
    paths.radiance.set(i, glm::vec3(0));
    paths.pdf[i] = kCountedInFull;
    paths.spacing_m[i] = 0, paths.spread[i] = spread, paths.before_m[i] = 0, paths.straight_pdf[i] = -1;
    paths.reflected_pdf[i] = 0, paths.sent_to[i] = -1;
  }
}

/// Spacing of points of light for each meter of distance.
float lattice_spread(const RenderScene& world, const CameraView& camera) {
  if (!world.light_cache) return 0;
  const double photosite = camera.lens.sensor().pixel_pitch_m / camera.lens.lens().thin.focal_length_m;
  return static_cast<float>(world.light_cache->options.light_spacing_px * photosite);
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

/// Where two photosites share a packet, whose lane this is: each has a quarter of the lanes in either half of the
/// pupil.
int owner_of(int lane) { return lane / (kPacket / 4) % 2; }

void copy_lane(const LensPacket& from, const RayPacket& from_rays, int source, int lane, LensPacket& packet,
               RayPacket& rays) {
  packet.left[lane] = from.left[source], packet.right[lane] = from.right[source];
  rays.origin_x[lane] = from_rays.origin_x[source], rays.direction_x[lane] = from_rays.direction_x[source];
  rays.origin_y[lane] = from_rays.origin_y[source], rays.direction_y[lane] = from_rays.direction_y[source];
  rays.origin_z[lane] = from_rays.origin_z[source], rays.direction_z[lane] = from_rays.direction_z[source];
  rays.far[lane] = from_rays.far[source], rays.mesh[lane] = from_rays.mesh[source];
}

}  // namespace

HalfRadiance render_pixel(const RenderScene& world, const CameraView& camera, const PathOptions& options, int x, int y,
                          std::uint32_t samples, std::uint64_t pixel_key) {
  const std::uint32_t index_mask = std::bit_ceil(std::max(samples, std::uint32_t{kPacket})) / 2 - 1;
  const float spread = lattice_spread(world, camera);
  LensPacket packet;
  alignas(64) RayPacket rays;
  alignas(64) Paths paths;
  Vec3Packet left_sum{}, right_sum{};
  for (std::uint32_t first = 0; first < samples; first += kPacket) {
    const SampleIndices indices{first / 2, index_mask, pixel_key};
    camera_packet(camera, options, x, y, indices, packet, rays);
    keep_wanted(static_cast<int>(std::min<std::uint32_t>(kPacket, samples - first)), odd_left_of(pixel_key), packet);
    start_paths(packet, spread, paths);
    trace_paths(world, options, indices, 0, rays, paths);
    add_weighted(packet.left, paths.radiance, left_sum);
    // the ideal lens gives both halves the same light: one sum serves both
    if (!options.ideal_aperture_scale) add_weighted(packet.right, paths.radiance, right_sum);
  }
  const float scale = 1 / static_cast<float>(samples);
  const glm::vec3 left = sum_of(left_sum) * scale;
  return {left, options.ideal_aperture_scale ? left : sum_of(right_sum) * scale};
}

std::array<HalfRadiance, 2> render_pixel_pair(const RenderScene& world, const CameraView& camera,
                                              const PathOptions& options, int x, int y, std::uint32_t samples,
                                              const std::array<std::uint64_t, 2>& pixel_keys) {
  constexpr std::uint32_t kIndexMask = kPacket / 2 - 1;
  LensPacket packet;
  alignas(64) RayPacket rays;
  alignas(64) Paths paths;
  for (int k = 0; k < 2; ++k) {
    LensPacket own;
    alignas(64) RayPacket own_rays;
    camera_packet(camera, options, x + k, y, {0, kIndexMask, pixel_keys[k]}, own, own_rays);
    keep_wanted(static_cast<int>(samples), odd_left_of(pixel_keys[k]), own);
    for (int lane = 0; lane < kPacket; ++lane) {
      if (owner_of(lane) == k) copy_lane(own, own_rays, lane - k * kPacket / 4, lane, packet, rays);
    }
  }
  start_paths(packet, lattice_spread(world, camera), paths);
  trace_paths(world, options, {0, kIndexMask, pixel_keys[0]}, 0, rays, paths);
  std::array<HalfRadiance, 2> out;
  const float scale = 1 / static_cast<float>(samples);
  for (int lane = 0; lane < kPacket; ++lane) {
    HalfRadiance& own = out[owner_of(lane)];
    own.left += packet.left[lane] * scale * paths.radiance.at(lane);
    own.right +=
        (options.ideal_aperture_scale ? packet.left[lane] : packet.right[lane]) * scale * paths.radiance.at(lane);
  }
  return out;
}

}  // namespace dualpixel::simulator
