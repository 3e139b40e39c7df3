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

/// Starts a path for each of `count` samples that the lens lets pass. Half of them lie in each half of the pupil; an
/// odd one in the half that `odd_left` says.
void start_paths(const LensPacket& packet, int count, int odd_left, float spread, Paths& paths) {
  constexpr int kPairs = kPacket / 2;
  for (int i = 0; i < kPacket; ++i) {
    const bool wanted = i < kPairs ? i < (count + odd_left) / 2 : i - kPairs < (count + 1 - odd_left) / 2;
    paths.active[i] = wanted && packet.left[i] + packet.right[i] > 0 ? -1 : 0;
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

}  // namespace

HalfRadiance render_pixel(const RenderScene& world, const CameraView& camera, const PathOptions& options, int x, int y,
                          std::uint32_t samples, std::uint64_t pixel_key) {
  const std::uint32_t index_mask = std::bit_ceil(std::max(samples, std::uint32_t{kPacket})) / 2 - 1;
  const int odd_left = static_cast<int>(hash(pixel_key) >> 63);  // which half of the pupil gets an odd sample
  const float spread = lattice_spread(world, camera);
  LensPacket packet;
  alignas(64) RayPacket rays;
  alignas(64) Paths paths;
  Vec3Packet left_sum{}, right_sum{};
  for (std::uint32_t first = 0; first < samples; first += kPacket) {
    const SampleIndices indices{first / 2, index_mask, pixel_key};
    camera_packet(camera, options, x, y, indices, packet, rays);
    start_paths(packet, static_cast<int>(std::min<std::uint32_t>(kPacket, samples - first)), odd_left, spread, paths);
    trace_paths(world, options, indices, 0, rays, paths);
    add_weighted(packet.left, paths.radiance, left_sum);
    // the ideal lens gives both halves the same light: one sum serves both
    if (!options.ideal_aperture_scale) add_weighted(packet.right, paths.radiance, right_sum);
  }
  const float scale = 1 / static_cast<float>(samples);
  const glm::vec3 left = sum_of(left_sum) * scale;
  return {left, options.ideal_aperture_scale ? left : sum_of(right_sum) * scale};
}

}  // namespace dualpixel::simulator
