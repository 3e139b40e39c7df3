#pragma once
#include <cstdint>
#include <functional>

#include "capture/image.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

/// The renderer: every camera sample crosses the pixel and the pupil at one point and is shared between the left and
/// the right view by the split pixel, so one render gives both, and left + right is the undivided pixel.
namespace dualpixel::simulator {

using ProgressCallback = std::function<void(double fraction)>;

struct RenderOptions {
  int samples_per_pixel = 16;  ///< 1 .. 65536; powers of two sample best
  int max_bounces = 0;         ///< 0: emitted and direct light; n: n further reflections
  std::uint64_t seed = 1;
  double aperture_scale = 1;  ///< pupil diameter over the lens's own; 0 is a pinhole. Radiance, not light, is averaged
};

/// Both halves of every photosite, full sensor size, linear RGB. left + right is the radiance in nits that the
/// photosite sees, averaged over its area and the pupil; the sensor turns it into light by ThinLens::lux_per_nit().
struct Views {
  Image left;
  Image right;
};

/// The same bytes for any number of threads.
Views render_views(const RenderScene& scene, const CameraView& camera, const RenderOptions& options,
                   const ProgressCallback& progress = {});

/// left + right: what an undivided sensor sees. `views` is used up.
Image undivided(Views views);

}  // namespace dualpixel::simulator
