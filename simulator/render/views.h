#pragma once
#include <cstdint>
#include <functional>
#include <optional>

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
  /// Set: instead of the lens the ideal one with its chief rays is looked through, its pupil this much wider; 0 is a
  /// pinhole.
  std::optional<double> ideal_aperture_scale;
};

/// Both halves of every photosite, full sensor size, linear RGB. left + right is the radiance in nits that the
/// photosite sees, averaged over its area and the pupil and weighed by the lens's shading and the split's losses; the
/// sensor turns it into light by LensSampler::lux_per_nit(). Through a lens with colour, light is traced at the
/// wavelength of the photosite's own filter, so only that channel is right there.
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
