#pragma once
#include "scenes/procedural/signed_distance.h"
#include "simulator/render/camera_view.h"

/// The camera of a picture: the simulator's thin lens.
namespace dualpixel::scenes {

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

/// The unit direction from the middle of the pupil to what appears at pixel `at`: the inverse of project().
vec3 direction_of(const simulator::CameraView& camera, vec2 at);

/// The lowest height visible between the planes z = -reach_m and z = reach_m, meters.
float lowest_visible_m(const simulator::CameraView& camera, float reach_m);

}  // namespace dualpixel::scenes
