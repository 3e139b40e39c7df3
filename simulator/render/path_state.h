#pragma once
#include <cstdint>
#include <limits>
#include <optional>

#include "simulator/render/ray_log.h"
#include "simulator/render/render_options.h"
#include "simulator/render/shading/lights.h"
#include "simulator/render/vec3_packet.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"

/// What paths of one packet carry on their way, and the numbers that decide it.
namespace dualpixel::simulator {

struct PathOptions {
  int max_bounces = 0;                         ///< as in RenderOptions
  std::optional<double> ideal_aperture_scale;  ///< as in RenderOptions
  Sampling sampling = Sampling::mirrored;
  std::optional<int> color;  ///< as in RenderOptions
  RayLog* log = nullptr;     ///< set: gets every packet that is traced, too; one log serves one thread
};

/// Which of a pixel's samples a packet holds: `first` of each half packet.
struct SampleIndices {
  std::uint32_t first, index_mask;
  std::uint64_t pixel_key;
  int first_bounce = 0;  ///< the reflection with which the path begins

  /// Reflections of the path before `bounce`. Random numbers go by this: then light at points is the same whatever the
  /// most reflections of the job are, and more of them add to what fewer find.
  int reflections_before(int bounce) const { return bounce - first_bounce; }
};

/// What a path's `pdf` says of rays whose light is counted in full where they meet a light.
inline constexpr float kCountedInFull = std::numeric_limits<float>::infinity();

/// Light carried along the sixteen paths of one packet.
struct Paths {
  alignas(64) int active[kPacket];  ///< -1 or 0, as Embree wants it
  Vec3Packet throughput, radiance;
  /// What of `throughput` counts on unlit surfaces beyond the last reflection: diffuse reflection does not see them
  /// there.
  Vec3Packet unlit_throughput;
  /// Solid-angle density of the ray's direction, if light samples could have found the same light: infinite for camera
  /// rays, 0 where they have found all of it.
  alignas(64) float pdf[kPacket];
  Vec3Packet start, normal;  ///< where the ray left a surface, before any glass; unset for camera rays
  /// The kinds of light that light samples there were of. Soft: at points of light, for which unlit surfaces are
  /// reflections.
  LightKinds kinds = LightKinds::all;
  /// Where glass divides camera rays: the next reflection of all is followed, however little it carries.
  bool follow_all = false;
  alignas(64) float before_m[kPacket];  ///< through glass, from the reflection that `pdf` is of to the ray's start
  /// After glass that bends: density with which light samples, which go straight, find what lies straight ahead of the
  /// ray that `pdf` is of. Negative: not bent, so that they find what the path does.
  alignas(64) float straight_pdf[kPacket];
  /// Of a ray that may have been sent towards bright surfaces: the density of its direction by reflection alone, else
  /// 0; and the triangle of BrightSurfaces that it was sent to, -1: none.
  alignas(64) float reflected_pdf[kPacket];
  alignas(64) int sent_to[kPacket];
  /// Between points of light on the surface that the ray meets: so much at its start, and so much more for each meter.
  /// An infinite spread: the path samples all light itself.
  alignas(64) float spacing_m[kPacket], spread[kPacket];
};

/// Independent numbers, all `stream`s of one sample different.
inline void random_samples(const SampleIndices& indices, std::uint32_t stream, float out[kPacket]) {
  for (int i = 0; i < kPacket; ++i) {
    out[i] = unit_float(static_cast<std::uint32_t>(hash(indices.pixel_key, 2 * indices.first + i, stream) >> 32));
  }
}

/// Numbers for the decision `stream` of each path. Each of a mirrored pair has its own: with one light sample for both,
/// the views would share their noise, and noise at the same position in both pulls disparity to 0.
inline void path_samples(Sampling sampling, const SampleIndices& indices, std::uint32_t stream, float u[kPacket],
                         float v[kPacket]) {
  if (sampling == Sampling::random) {
    random_samples(indices, 4 + 2 * stream, u);
    random_samples(indices, 5 + 2 * stream, v);
  } else {
    padded_samples(indices.first, indices.index_mask, indices.pixel_key, stream, u, v);
  }
}

}  // namespace dualpixel::simulator
