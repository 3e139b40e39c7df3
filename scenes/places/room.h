#pragma once
#include "scenes/drawn/scene_builder.h"

namespace dualpixel::scenes {

struct RoomOptions {
  std::string light = "window";  ///< or "lamps": the window is dark
  float lamp_strength = 1;       ///< 1: bright
  float wide_m = 4, deep_m = 5, high_m = 2.6f;
  float beyond_m = 0;  ///< depth of a second room behind an opening of the back wall; 0: none
  int furniture = 7;
  bool mirror = false;
  bool clear_middle = false;  ///< room for people between the camera and half of the depth
};

/// How far the room goes on behind the camera, where a window or lamp lights what the camera sees.
inline constexpr float kRoomBehind_m = 2.2f;

/// A furnished room: the floor is y = 0, the back wall z = -deep_m, the camera's end z = kRoomBehind_m; x from the
/// middle.
void furnish_room(SceneBuilder& build, RandomStream rng, const RoomOptions& options);

/// A piece or two at the side of the picture that is taken from `eye` towards `target`, an arm's length or two away.
void add_near_furniture(SceneBuilder& build, RandomStream rng, const RoomOptions& options, glm::vec3 eye,
                        glm::vec3 target);

}  // namespace dualpixel::scenes
