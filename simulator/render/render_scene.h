#pragma once
#include <cstdint>
#include <memory>
#include <vector>

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
  std::unique_ptr<LightCache> light_cache;               ///< null: none
  std::vector<std::unique_ptr<LightCache>> spare_light;  ///< set aside by use_light(), the last one last
};

/// Makes `world.light_cache` one of these options and samples, and sets the one before aside with what it holds: light
/// hangs on options and scramble alone, so that a later picture may go on with it. What is set aside takes as much
/// memory as one cache may; the caches that were not used for longest go.
void use_light(RenderScene& world, const LightCacheOptions& options, std::uint64_t scramble = 0);

}  // namespace dualpixel::simulator
