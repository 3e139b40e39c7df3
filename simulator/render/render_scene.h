#pragma once
#include "simulator/render/intersector.h"
#include "simulator/render/shading/lights.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// A scene made ready for rays: acceleration structure and light choice. `scene` must outlive it.
struct RenderScene {
  explicit RenderScene(const Scene& source)
      : scene(source), intersector(source), lights(source, intersector.bounds().low, intersector.bounds().high) {}

  const Scene& scene;
  Intersector intersector;
  Lights lights;
};

}  // namespace dualpixel::simulator
