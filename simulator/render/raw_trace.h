#pragma once
#include <cstddef>

#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

namespace dualpixel::simulator {

/// What raw Embree does with the same camera rays, on the calling thread: ray generation, primary packets, a constant
/// colour, one shadow ray of each hit towards `to_light`, and nothing else. Returns how many rays found light. The
/// floor that `dualpixel bench` measures the renderer against.
std::size_t trace_raw(const RenderScene& scene, const CameraView& camera, int samples_per_pixel, glm::vec3 to_light);

}  // namespace dualpixel::simulator
