#pragma once
#include <cstdint>

#include "capture/image/image.h"
#include "scenes/people/photo/ray_tracer.h"

namespace dualpixel::scenes {

struct Rendering {
  Image light;         ///< linear RGB
  Image people_light;  ///< the part of it from people, premultiplied by their coverage
  Image coverage;      ///< one channel per person: the fraction of the pixel's samples that met them
};

/// Renders a scene through the simulator's thin lens: sixteen samples per pixel over its area and the pupil, each with
/// direct light from either the key light or the dome and one shadow ray; no bounces. `people`: how many.
Rendering render(const RayTracer& tracer, const simulator::CameraView& camera, int people, std::uint64_t seed);

}  // namespace dualpixel::scenes
