#pragma once
#include "capture/image.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

namespace dualpixel::simulator {

/// Where each point that a pixel's chief ray sees in `first` is found in a later frame: two channels, x and y, in
/// photosites, to be added to the pixel's place; infinite where the point lies behind the later camera. The point
/// moves with its triangle; what the ray misses is infinitely far. Geometry alone: the later place may be hidden, or
/// outside of the picture. Throws InputError where the scenes don't have the same triangles.
Image trace_motion(const RenderScene& first_world, const CameraView& first, const Scene& later_scene,
                   const CameraView& later);

}  // namespace dualpixel::simulator
