#pragma once
#include <array>

#include "scenes/people/body/body.h"
#include "scenes/people/body/frame.h"

/// A pose within human ranges: joint angles, hands, and what they hold. Sides: 0 is the person's left (+x when facing
/// +z), 1 the right.
namespace dualpixel::scenes {

/// What a person holds. The last two are for held-out sets only.
enum class Held : std::uint8_t {
  nothing,
  phone,
  cup,
  bottle,
  book,
  bag,
  bouquet,
  ball,
  animal,
  tablet,
  microphone,
  umbrella,
  thing,  ///< a generic object (domain randomization)
  // held-out
  glass,
  parcel
};

/// One arm: the wrist in the chest's frame as fractions of stature (x away from the middle of the body), and the
/// directions of the elbow, the fingers and the palm.
struct ArmPose {
  vec3 wrist{0.15f, -0.11f, 0.02f};
  vec3 elbow{0.3f, -0.2f, -1};
  vec3 fingers{0, -1, 0};
  vec3 palm{-1, 0, 0};
  float curl = 0.4f;  ///< 0 flat hand .. 1 fist
};

/// Joint angles, radians.
struct Pose {
  float lean = 0, side = 0, twist = 0;  ///< of the chest over the pelvis: forward, to the left, turned left
  float head_yaw = 0, head_pitch = 0, head_roll = 0;  ///< of the head over the chest: left, down, towards the left
  std::array<float, 2> shrug{0, 0};                   ///< shoulders up, as fractions of stature
  std::array<ArmPose, 2> arm;
  bool sitting = false;
  std::array<vec3, 2> foot{vec3(0.06f, 0, 0), vec3(0.06f, 0, 0)};  ///< ankle over the floor (x outwards), likewise
  Held held = Held::nothing;
  int held_side = 1;
  bool both_hands = false;
};

/// What the arms do. The last `kReservedGestures`, and what they hold, are drawn for held-out sets only.
enum class Gesture : std::uint8_t {
  hanging,
  bent,
  on_hip,
  crossed,
  in_pockets,
  holding,
  holding_both,
  phone_at_ear,
  hand_in_hair,
  selfie,
  folded_in_front,
  on_strap,
  raised_both,
  anywhere,    ///< wrists at random positions in front of the body (domain randomization)
  with_thing,  ///< a generic object between both hands (domain randomization)
  // held-out
  waving,
  at_chin,
  pointing,
  toasting,
  carrying
};

inline constexpr int kGestures = 20, kReservedGestures = 5;
static_assert(static_cast<int>(Gesture::carrying) == kGestures - 1);

Pose make_pose(RandomStream& rng, const Body& body, Gesture gesture);
Gesture random_gesture(RandomStream& rng);

}  // namespace dualpixel::scenes
