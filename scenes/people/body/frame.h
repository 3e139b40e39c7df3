#pragma once
#include "scenes/procedural/signed_distance.h"

/// Rotations, local frames and two-bone limbs.
namespace dualpixel::scenes {

struct Frame {
  vec3 origin{0};
  mat3 axes{1};  ///< columns: x left, y up, z forward
  vec3 to_world(vec3 local) const { return origin + axes * local; }
  vec3 to_local(vec3 world) const { return (world - origin) * axes; }
};

/// A rotation by `angle` radians about a unit axis.
mat3 rotation(float angle, vec3 axis);
/// The smallest rotation that takes unit vector a to unit vector b.
mat3 rotation_between(vec3 a, vec3 b);
/// Axes with y along `along` and z as close to `towards` as possible.
mat3 axes_along(vec3 along, vec3 towards);

/// Two-bone inverse kinematics: the middle joint of a limb from a to b, which is moved within reach; the joint bends
/// towards `pole`.
vec3 bend_limb(vec3 a, vec3& b, float first_m, float second_m, vec3 pole);

}  // namespace dualpixel::scenes
