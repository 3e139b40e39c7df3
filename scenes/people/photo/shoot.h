#pragma once
#include <optional>

#include "capture/image/image.h"
#include "scenes/people/shape/stage.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/intersector.h"

/// Takes a picture of a stage through the simulator's thin lens: sixteen samples a pixel over its area and the pupil,
/// each lit directly by either the key light or a piece of the dome, with a shadow ray; no bounces.
namespace dualpixel::scenes {

/// A stage made ready for rays; `stage` must outlive it.
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

struct CameraSetup {
  vec3 eye{0, 1.6f, 2}, target{0, 1.6f, 0};
  float roll = 0;             ///< radians
  float height_m = 1;         ///< what the picture's height covers at the target's distance
  float aperture_m = 0.002f;  ///< diameter of the pupil
  float focus_m = 2;          ///< from the eye, along the axis
  int width_px = 192, height_px = 256;
};
simulator::CameraView make_camera(const CameraSetup& plan);

/// Where a point of the world appears (pixel centers at .5) and how far it is, meters along the axis.
vec3 project(const simulator::CameraView& camera, vec3 point);
/// The way from the middle of the pupil to what appears at `at`, unit: the inverse of project().
vec3 direction_of(const simulator::CameraView& camera, vec2 at);
/// The lowest height in the picture between the planes z = -reach_m and z = reach_m, meters.
float lowest_visible_m(const simulator::CameraView& camera, float reach_m);

struct Rendering {
  Image light;         ///< linear RGB
  Image people_light;  ///< the part of it that came from people: premultiplied by their coverage
  Image coverage;      ///< one channel a person: the share of the pixel's samples that met them
};
Rendering render(const RayTracer& tracer, const simulator::CameraView& camera, int people, std::uint64_t seed);

/// What stands in the way, from rays from the middle of the pupil through every fourth pixel.
struct Visibility {
  float occluded = 0;       ///< of the rays on whose way somebody is, the share that meets something nobody's first
  bool bystanders = false;  ///< one was met
};
Visibility visibility_of(const RayTracer& tracer, const simulator::CameraView& camera);

}  // namespace dualpixel::scenes
