#pragma once
#include "scenes/procedural/random_stream.h"
#include "scenes/procedural/signed_distance.h"

/// A person's measures. Proportions: Drillis & Contini 1966, segment lengths as fractions of stature.
namespace dualpixel::scenes {

struct Body {
  float stature_m = 1.7f;
  float head_scale = 1;  ///< 1: 22.5 cm from chin to crown
  float girth = 0;       ///< -1 thin .. 1 heavy
  float woman = 0;       ///< 0 .. 1: breadth of shoulders and hips, waist, bust
  bool child = false, old = false;
  float shoulder_half_m = 0.18f;  ///< from the spine to the joint
  float hip_half_m = 0.085f;
};
Body make_body(RandomStream& rng);

/// Segment lengths, meters; positions in the frame of the parent segment, of the left side.
struct Proportions {
  float pelvis_m = 0.9f, sitting_pelvis_m = 0.5f;  ///< over the floor
  vec3 chest{0}, neck_base{0}, neck{0}, shoulder{0}, hip{0};
  float head_forward_m = 0;
  float upper_arm_m = 0.3f, fore_arm_m = 0.25f, thigh_m = 0.4f, shank_m = 0.4f;
};
Proportions proportions_of(const Body& body);

}  // namespace dualpixel::scenes
