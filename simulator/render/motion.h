#pragma once
#include <cstddef>
#include <optional>

#include "capture/image/image.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

/// Where points go from one frame of a burst to another: geometry and the lens's chief rays, as all truth is.
namespace dualpixel::simulator {

/// Where each point that a pixel's chief ray sees in `first` is found in a later frame: two channels, x and y, in
/// photosites, to be added to the pixel's position; infinite where the point lies behind the later camera, or so far to
/// its side that no chief ray of the lens leads there. The point moves with its triangle; what the ray misses is
/// infinitely far. The later position may be hidden, or outside of the picture. `later_scene` has the same triangles
/// and placements of shared meshes, which may be elsewhere. Where the shutter rolls, the later position is that at the
/// time at which its own row is exposed; beyond the picture, the last row.
Image trace_motion(const RenderScene& first_world, const CameraView& first, const Scene& later_scene,
                   const CameraView& later);

/// The same of rows [first_row, end_row) alone; elsewhere infinite.
Image trace_motion_rows(const RenderScene& first_world, const CameraView& first, const Scene& later_scene,
                        const CameraView& later, int first_row, int end_row);

/// The first mesh whose triangles, or whose number of instances, differ; empty: none.
std::optional<std::size_t> mesh_that_differs(const Scene& a, const Scene& b);

}  // namespace dualpixel::simulator
