#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "simulator/render/camera_view.h"
#include "simulator/render/paths.h"

/// The light paths of one photosite: every camera sample crosses the pixel and the pupil at one point and is shared
/// between the left and the right view by the split pixel. Sixteen samples go together as one packet.
namespace dualpixel::simulator {

/// Linear RGB in nits, as Views holds it.
struct HalfRadiance {
  glm::vec3 left{0}, right{0};
};

/// Mean over `samples` points, 1 .. 65536, of the net that `pixel_key` scrambles; powers of two sample best. The last
/// of an odd number lies in either half of the pupil, by the key.
HalfRadiance render_pixel(const RenderScene& world, const CameraView& camera, const PathOptions& options, int x, int y,
                          std::uint32_t samples, std::uint64_t pixel_key);

/// With so few samples, two photosites share one packet, which would otherwise be half empty.
inline constexpr std::uint32_t kMostSharedSamples = kPacket / 2;

/// The same for the photosites (x, y) and (x + 1, y) together, of 1 .. kMostSharedSamples samples each.
std::array<HalfRadiance, 2> render_pixel_pair(const RenderScene& world, const CameraView& camera,
                                              const PathOptions& options, int x, int y, std::uint32_t samples,
                                              const std::array<std::uint64_t, 2>& pixel_keys);

}  // namespace dualpixel::simulator
