#pragma once
#include <string>

#include "capture/capture.h"
#include "scenes/drawn/scene_builder.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

namespace dualpixel::scenes {

/// What a look through a scene's camera gave.
struct Look {
  const simulator::RenderScene& world;
  const simulator::CameraView& camera;
  const Truth& truth;    ///< its depth and what is seen are used
  const Image& picture;  ///< of truth's size, linear RGB, in any unit
};

/// What is wrong with where the camera stands and what it shows, in a few words; empty: nothing. The camera must stand
/// in free space (rays all around it), nothing near may fill the picture, something must be seen that is not an even
/// surface, and the subject, where the shooting has one, must be in the picture and not hidden.
std::string view_fault(const Look& look, const Shooting& shooting);

}  // namespace dualpixel::scenes
