#pragma once
#include <array>
#include <vector>

#include "scenes/people/dice.h"
#include "scenes/people/shape/sdf.h"

/// A body's measures, a pose within human ranges, and the joints that follow from both. Proportions: Drillis & Contini
/// 1966, segment lengths as shares of stature. Sides: 0 is the person's left (+x when facing +z), 1 the right.
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

/// What the hands do.
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
  thing,  ///< of no particular kind
  // held-out
  glass,
  parcel
};

/// Where one hand is: the wrist in the chest's frame as shares of stature (x away from the body's middle), the way the
/// elbow points, the fingers and the palm.
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
  std::array<float, 2> shrug{0, 0};                   ///< shoulders up, as shares of stature
  std::array<ArmPose, 2> arm;
  bool sitting = false;
  std::array<vec3, 2> foot{vec3(0.06f, 0, 0), vec3(0.06f, 0, 0)};  ///< ankle over the floor (x outwards), shares
  Held held = Held::nothing;
  int held_side = 1;
  bool both_hands = false;
};

/// What people do with their arms. The last `kReservedGestures`, and what they hold, are drawn for held-out sets only.
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
  anywhere,    ///< one or both wrists anywhere before the body, at times with something in the hand
  with_thing,  ///< something of no particular kind between both hands
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

struct Frame {
  vec3 origin{0};
  mat3 axes{1};  ///< columns: x left, y up, z forward
  vec3 to_world(vec3 local) const { return origin + axes * local; }
  vec3 to_local(vec3 world) const { return (world - origin) * axes; }
};

/// A stick of the body, posed and at rest; `axes` turn rest directions into posed ones.
struct Bone {
  vec3 a, b;  ///< posed ends
  mat3 axes;
  vec3 rest_a;
  float radius_m;  ///< about, to weigh bones against each other
};

struct Skeleton {
  Frame pelvis, chest, head;  ///< head: origin in the middle between the ears
  vec3 neck_base;
  std::array<vec3, 2> shoulder, elbow, wrist, hip, knee, ankle, toe;
  std::array<Frame, 2> hand;  ///< y along the fingers, z out of the palm; origin in the palm
  std::vector<Bone> bones;    ///< pelvis, chest, neck; upper arm, forearm, thigh, shin of each side
  static constexpr std::size_t kNeckBone = 2;

  /// Where a place on the posed body lies on the body at rest.
  vec3 rest_position_of(vec3 p) const;
};

/// Lengths of the sticks, meters; places in the frame of the part that they hang from, of the left side.
struct Proportions {
  float pelvis_m = 0.9f, sitting_pelvis_m = 0.5f;  ///< over the floor
  vec3 chest{0}, neck_base{0}, neck{0}, shoulder{0}, hip{0};
  float head_forward_m = 0;
  float upper_arm_m = 0.3f, fore_arm_m = 0.25f, thigh_m = 0.4f, shank_m = 0.4f;
};
Proportions proportions_of(const Body& body);

/// The person stands (or sits) at `place`, turned by `yaw` (radians, to its left).
Skeleton make_skeleton(const Body& body, const Pose& pose, vec3 place, float yaw, const Proportions& proportions);

/// Axes of which y runs along `along` and z as near to `towards` as can be.
mat3 axes_along(vec3 along, vec3 towards);

}  // namespace dualpixel::scenes
