#pragma once
#include <optional>

#include "scenes/people/shape/scene_model.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/intersector.h"

namespace dualpixel::scenes {

/// A scene prepared for ray tracing; `scene` must outlive it.
class RayTracer {
 public:
  explicit RayTracer(const SceneModel& scene);
  const SceneModel& scene() const { return scene_; }
  const simulator::Intersector& intersector() const { return *intersector_; }

 private:
  const SceneModel& scene_;
  simulator::Scene geometry_;
  std::optional<simulator::Intersector> intersector_;
};

/// What is in front of people, found with rays from the middle of the pupil through every fourth pixel.
struct Visibility {
  float occluded = 0;       ///< of the rays towards people, the fraction that meets another object first
  bool bystanders = false;  ///< one is visible
};
Visibility visibility_of(const RayTracer& tracer, const simulator::CameraView& camera);

}  // namespace dualpixel::scenes
