#pragma once
#include "scenes/drawn/scene_builder.h"

namespace dualpixel::scenes {

struct RoomOptions {
  std::string light = "window";  ///< or "lamps": the window is dark
  float lamp_strength = 1;       ///< 1: bright
  float wide_m = 4, deep_m = 5, high_m = 2.6f;
  int furniture = 7;
  bool mirror = false;
  bool clear_middle = false;  ///< room for people between the camera and half of the depth
};

/// A furnished room: the floor is y = 0, the back wall z = -deep_m, the camera's end z = +0.6; x from the middle.
void furnish_room(SceneBuilder& build, RandomStream rng, const RoomOptions& options);

}  // namespace dualpixel::scenes
