#pragma once
#include <optional>
#include <vector>

#include "scenes/drawn/scene_builder.h"

namespace dualpixel::scenes {

class MakeHumanAssets;

struct PersonSpot {
  glm::vec3 foot{0};    ///< below the pelvis, on the floor
  float yaw = 0;        ///< 0: faces +z
  float lowest_m = -1;  ///< nothing below this height is seen, so it is not made
  /// Set: the person is lifted or lowered until the eyes are this high, where nobody sees the feet.
  std::optional<float> eyes_m;
};

/// Points about a face in the world: brow, chin, cheeks, jaw; and its middle.
struct StandingFace {
  std::vector<glm::vec3> outline;
  glm::vec3 middle{0};
};

/// A drawn person (scenes/people) whose colors are those of its vertices. `makehuman`: made from these, with their
/// textures; null: by code.
StandingFace add_person(SceneBuilder& build, RandomStream rng, const PersonSpot& spot,
                        const MakeHumanAssets* makehuman = nullptr);

}  // namespace dualpixel::scenes
