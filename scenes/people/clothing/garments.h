#pragma once
#include "scenes/people/body/body_cones.h"

namespace dualpixel::scenes {

/// A garment for the upper body: torso and sleeves with room, down to the height `hem` (share of stature, about the
/// pelvis; negative is lower), flaring by `flare` there.
Shape upper_garment(const Figure& figure, float room_m, float sleeves, float hem, float flare_m);

/// What the neckline leaves open: a round or pointed cut below the neck.
std::vector<Cone> neckline(const Figure& figure, float width, float depth);

/// A band around the neck: collar, turtleneck, hood at rest.
SceneObject collar(const Figure& figure, float low, float high, float room_m, float spread_m, float open);

}  // namespace dualpixel::scenes
