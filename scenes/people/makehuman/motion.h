#pragma once
#include <vector>

#include "scenes/people/body/skeleton.h"
#include "scenes/people/makehuman/body_parts.h"
#include "scenes/people/makehuman/morphed_body.h"

/// Linear blend skinning: from the rest pose to the posed body.
namespace dualpixel::scenes {

/// A rigid motion: turns by `axes` about `from`, which moves to `to`.
struct PartMotion {
  mat3 axes{1};
  vec3 from{0}, to{0};
  vec3 moved(vec3 p) const { return to + axes * (p - from); }
};

/// Origins of the parts along the spine, at rest.
struct RestFrames {
  vec3 pelvis, chest, neck, head;
};

RestFrames rest_frames(const MorphedBody& morphed, float stature);

/// Motions of all parts, by part.
std::vector<PartMotion> motions_of(const MorphedBody& morphed, const RestFrames& rest, const Skeleton& k,
                                   const Pose& pose);

/// A rest position, moved with the parts that it belongs to.
vec3 moved(const std::vector<PartMotion>& motion, const Weights& weights, vec3 p);

}  // namespace dualpixel::scenes
