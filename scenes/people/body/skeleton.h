#pragma once
#include <array>
#include <vector>

#include "scenes/people/body/pose.h"

/// The joints that follow from a body and its pose.
namespace dualpixel::scenes {

/// A bone, posed and at rest; `axes` turn rest directions into posed ones.
struct Bone {
  vec3 a, b;  ///< posed ends
  mat3 axes;
  vec3 rest_a;
  float radius_m;  ///< approximate, to weight bones against each other
};

struct Skeleton {
  Frame pelvis, chest, head;  ///< head: origin in the middle between the ears
  vec3 neck_base;
  std::array<vec3, 2> shoulder, elbow, wrist, hip, knee, ankle, toe;
  std::array<Frame, 2> hand;  ///< y along the fingers, z out of the palm; origin in the palm
  std::vector<Bone> bones;    ///< pelvis, chest, neck; upper arm, forearm, thigh, shin of each side
  static constexpr std::size_t kNeckBone = 2;

  /// The rest position of a point on the posed body.
  vec3 rest_position_of(vec3 p) const;
};

/// The person stands (or sits) at `position`, turned by `yaw` (radians, to its left).
Skeleton make_skeleton(const Body& body, const Pose& pose, vec3 position, float yaw, const Proportions& proportions);

}  // namespace dualpixel::scenes
