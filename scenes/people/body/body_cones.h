#pragma once
#include "scenes/people/body/figure.h"

/// The cones that torso, neck, arms and legs are blended from, `offset_m` larger than the skin: with 0 the body, with
/// more the garments over it. Sides as in Pose.
namespace dualpixel::scenes {

std::vector<Cone> torso_cones(const Figure& figure, float offset_m);
std::vector<Cone> neck_cones(const Figure& figure, float offset_m);
/// An arm from the shoulder to the fraction `until` of its length (elbow at .55), cut square where it ends early.
std::vector<Cone> arm_cones(const Figure& figure, int side, float offset_m, float until = 1);
std::vector<Cone> leg_cones(const Figure& figure, int side, float offset_m, float until = 1);

}  // namespace dualpixel::scenes
