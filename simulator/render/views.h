#pragma once
#include "capture/image/image.h"
#include "simulator/render/pixel.h"
#include "simulator/render/render_options.h"
#include "simulator/render/sample_map.h"
#include "simulator/render/tile_store.h"

/// The renderer: one render gives both views, and left + right is the undivided pixel.
namespace dualpixel::simulator {

/// Both halves of every photosite, full sensor size, linear RGB. left + right is the radiance in nits that the
/// photosite sees, averaged over its area and the pupil and weighed by the lens's shading and the split's losses; the
/// sensor turns it into light by LensSampler::lux_per_nit(). Through a lens with color, light is traced at the
/// wavelength of the photosite's own filter, so only that channel is right there.
struct Views {
  Image left;
  Image right;
};

/// The same bytes for any number of threads. With a map, tile by tile as many samples as it says.
Views render_views(const RenderScene& scene, const CameraView& camera, const RenderOptions& options,
                   const ProgressCallback& progress = {});
Views render_views(const RenderScene& scene, const CameraView& camera, const RenderOptions& options,
                   const SampleMap& map, const ProgressCallback& progress = {});

/// Adds a `count`-th of `views` to `mean`, which is empty at first.
void add_share(const Views& views, int count, Views& mean);

/// left + right: what an undivided sensor sees. `views` is used up.
Image undivided(Views views);

}  // namespace dualpixel::simulator
