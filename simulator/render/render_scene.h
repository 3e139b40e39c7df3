#pragma once
#include <memory>

#include "simulator/render/intersector.h"
#include "simulator/render/light/bright_surfaces.h"
#include "simulator/render/light/light_cache.h"
#include "simulator/render/shading/lights.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// A scene made ready for rays: acceleration structure, light choice, and light found so far, which all renders of the
/// scene share. `scene` must outlive it.
struct RenderScene {
  explicit RenderScene(const Scene& source, const LightCacheOptions& cache = {})
      : scene(source),
        intersector(source),
        lights(source, intersector),
        bright(source, lights, intersector),
        light_cache(cache.light_spacing_px > 0 ? std::make_unique<LightCache>(cache) : nullptr) {}

  const Scene& scene;
  Intersector intersector;
  Lights lights;
  BrightSurfaces bright;
  std::unique_ptr<LightCache> light_cache;  ///< null: none
};

}  // namespace dualpixel::simulator
