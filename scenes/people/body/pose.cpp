#include "scenes/people/body/pose.h"

#include <algorithm>

namespace dualpixel::scenes {
namespace {

ArmPose arm(vec3 wrist, vec3 elbow, vec3 fingers, vec3 palm, float curl) { return {wrist, elbow, fingers, palm, curl}; }

/// The approximate direction of the forearm: its exact length is known only with the skeleton.
vec3 fore_arm(const ArmPose& pose) {
  vec3 wrist = pose.wrist;
  const vec3 shoulder(0.109f, 0.192f, -0.004f), elbow = bend_limb(shoulder, wrist, 0.182f, 0.15f, pose.elbow);
  return glm::normalize(wrist - elbow);
}

const ArmPose kHanging = arm({0.15f, -0.105f, 0.015f}, {0.3f, 0, -1}, {0.05f, -1, 0.1f}, {-1, 0, -0.2f}, 0.45f);
const ArmPose kBent = arm({0.15f, -0.02f, 0.09f}, {0.5f, -0.3f, -1}, {-0.2f, -0.4f, 1}, {-1, -0.2f, 0}, 0.5f);
const ArmPose kOnHip =
    arm({0.125f, -0.02f, 0.015f}, {1, 0.1f, -0.35f}, {-0.6f, -0.5f, 0.6f}, {-0.4f, -0.5f, -0.6f}, 0.4f);
const ArmPose kPocket = arm({0.13f, -0.075f, 0.04f}, {0.8f, 0, -1}, {-0.2f, -1, 0.15f}, {-1, 0, 0}, 0.7f);
const ArmPose kHold =
    arm({0.06f, 0.09f, 0.15f}, {0.7f, -1, -0.2f}, {-0.45f, 0.7f, 0.35f}, {-0.75f, -0.2f, -0.5f}, 0.7f);
const ArmPose kAtEar = arm({0.09f, 0.275f, 0.05f}, {0.8f, -1, 0.2f}, {-0.25f, 1, -0.15f}, {-1, -0.2f, -0.1f}, 0.65f);
const ArmPose kInHair = arm({0.1f, 0.33f, 0.01f}, {1, 0.2f, 0.2f}, {-0.7f, 0.6f, -0.3f}, {-0.7f, -0.5f, 0}, 0.5f);
const ArmPose kSelfie = arm({0.16f, 0.24f, 0.33f}, {0.5f, -1, 0}, {-0.1f, 0.5f, 1}, {-0.6f, 0, 0.4f}, 0.6f);
const ArmPose kFolded = arm({0.02f, -0.045f, 0.11f}, {1, -0.2f, -0.5f}, {-0.8f, -0.5f, 0.2f}, {0, 0, -1}, 0.6f);
const ArmPose kStrap = arm({0.095f, 0.135f, 0.085f}, {0.7f, -1, -0.3f}, {-0.3f, 0.8f, 0.1f}, {-0.4f, 0.1f, -1}, 0.95f);
const ArmPose kRaised = arm({0.17f, 0.42f, 0.03f}, {1, 0, 0.2f}, {0.1f, 1, 0.1f}, {-0.2f, 0, 1}, 0.2f);
const ArmPose kWave = arm({0.2f, 0.29f, 0.09f}, {0.8f, -1, -0.1f}, {0.1f, 1, 0}, {0, 0.1f, 1}, 0.1f);
const ArmPose kChin = arm({0.035f, 0.175f, 0.12f}, {0.5f, -1, 0}, {-0.3f, 0.9f, -0.3f}, {-0.3f, 0.3f, -1}, 0.75f);
const ArmPose kPoint = arm({0.13f, 0.2f, 0.2f}, {0.6f, -1, 0}, {0.3f, 0.5f, 0.6f}, {-1, 0, 0.2f}, 0.6f);
const ArmPose kToast = arm({0.12f, 0.17f, 0.17f}, {0.7f, -1, -0.1f}, {-0.3f, 0.7f, 0.4f}, {-0.8f, 0, 0.2f}, 0.7f);
const ArmPose kCarry = arm({0.085f, 0.01f, 0.16f}, {0.5f, -0.6f, -1}, {-0.2f, 0.1f, 1}, {-0.6f, 0.8f, 0}, 0.2f);
const ArmPose kCrossedOver =
    arm({-0.05f, 0.105f, 0.115f}, {0.9f, -0.9f, 0.1f}, {-0.9f, 0.25f, -0.15f}, {-0.1f, -0.5f, -1}, 0.3f);
const ArmPose kCrossedUnder =
    arm({-0.055f, 0.085f, 0.085f}, {0.9f, -0.9f, 0.1f}, {-0.8f, 0.5f, -0.3f}, {0.2f, 0, -1}, 0.3f);

/// The arm that a gesture is mainly of, and the other.
struct Arms {
  ArmPose& first;
  ArmPose& second;
};

void hold_in_one_hand(RandomStream& rng, Pose& pose, Arms arms) {
  arms.first = kHold;
  arms.first.wrist += vec3(rng.uniform(-0.03f, 0.05f), rng.uniform(-0.06f, 0.1f), rng.uniform(-0.03f, 0.05f));
  constexpr Held kOneHand[] = {Held::phone, Held::cup, Held::bottle, Held::bouquet, Held::microphone, Held::umbrella};
  pose.held = kOneHand[rng.below(6)];
}

void hold_in_both_hands(RandomStream& rng, Pose& pose, Arms arms) {
  arms.first = arms.second = kHold;
  const vec3 shift(rng.uniform(-0.01f, 0.02f), rng.uniform(-0.08f, 0.06f), rng.uniform(-0.02f, 0.04f));
  arms.first.wrist += shift, arms.second.wrist += shift;
  constexpr Held kTwoHands[] = {Held::book, Held::ball, Held::animal, Held::tablet, Held::bouquet, Held::phone};
  pose.held = kTwoHands[rng.below(6)];
  pose.both_hands = true;
}

void place_wrists_at_random(RandomStream& rng, Pose& pose, Arms arms) {
  for (ArmPose& a : pose.arm) {
    if (&a == &arms.second && rng.chance(0.4f)) continue;
    a.wrist = {rng.uniform(-0.06f, 0.25f), rng.uniform(-0.1f, 0.42f), rng.uniform(0.06f, 0.32f)};
    a.elbow = vec3(0.8f, -0.6f, -0.3f) + vec3(0.7f, 0.8f, 0.8f) * rng.uniform3(-1, 1);
    a.fingers = 1.2f * fore_arm(a) + 0.7f * rng.uniform3(-1, 1);
    a.palm = vec3(-0.4f, 0, 0) + rng.uniform3(-1, 1);
    a.curl = rng.uniform();
  }
  if (rng.chance(0.4f)) pose.held = Held::thing;
}

void hold_generic_object(RandomStream& rng, Pose& pose, Arms arms) {
  arms.first = arms.second = kHold;
  arms.first.wrist += vec3(rng.uniform(-0.02f, 0.06f), rng.uniform(-0.14f, 0.1f), rng.uniform(-0.04f, 0.06f));
  arms.second.wrist = arms.first.wrist + vec3(0, rng.uniform(-0.03f, 0.03f), rng.uniform(-0.03f, 0.03f));
  pose.held = Held::thing;
  pose.both_hands = true;
}

void raise_a_glass(RandomStream& rng, Pose& pose, Arms arms) {
  arms.first = kToast;
  arms.first.wrist += vec3(rng.uniform(-0.03f, 0.04f), rng.uniform(-0.05f, 0.05f), rng.uniform(-0.03f, 0.03f));
  pose.held = Held::glass;
}

void carry_parcel(RandomStream& rng, Pose& pose, Arms arms) {
  arms.first = arms.second = kCarry;
  const float higher = rng.uniform(-0.03f, 0.07f);
  arms.first.wrist.y += higher, arms.second.wrist.y += higher;
  pose.held = Held::parcel;
  pose.both_hands = true;
}

/// Moves the arms as the gesture says; `one` is the side that was drawn.
void apply_gesture(RandomStream& rng, Pose& pose, Gesture gesture, ArmPose& one, ArmPose& other) {
  switch (gesture) {
    case Gesture::hanging:
      break;
    case Gesture::bent:
      one = kBent;
      break;
    case Gesture::on_hip:
      one = kOnHip;
      if (rng.chance(0.35f)) other = kOnHip;
      break;
    case Gesture::crossed:
      one = kCrossedOver, other = kCrossedUnder;
      break;
    case Gesture::in_pockets:
      one = kPocket;
      if (rng.chance(0.6f)) other = kPocket;
      break;
    case Gesture::holding:
      hold_in_one_hand(rng, pose, {one, other});
      break;
    case Gesture::holding_both:
      hold_in_both_hands(rng, pose, {one, other});
      break;
    case Gesture::phone_at_ear:
      one = kAtEar;
      pose.held = Held::phone;
      break;
    case Gesture::hand_in_hair:
      one = kInHair;
      break;
    case Gesture::selfie:
      one = kSelfie;
      break;
    case Gesture::folded_in_front:
      one = other = kFolded;
      other.wrist.y -= 0.01f;
      break;
    case Gesture::on_strap:
      one = kStrap;
      pose.held = Held::bag;
      break;
    case Gesture::raised_both:
      one = other = kRaised;
      break;
    case Gesture::anywhere:
      place_wrists_at_random(rng, pose, {one, other});
      break;
    case Gesture::with_thing:
      hold_generic_object(rng, pose, {one, other});
      break;
    case Gesture::waving:
      one = kWave;
      break;
    case Gesture::at_chin:
      one = kChin;
      break;
    case Gesture::pointing:
      one = kPoint;
      break;
    case Gesture::toasting:
      raise_a_glass(rng, pose, {one, other});
      break;
    case Gesture::carrying:
      carry_parcel(rng, pose, {one, other});
      break;
  }
}

}  // namespace

Gesture random_gesture(RandomStream& rng) {
  if (!rng.held_out() && rng.chance(rng.domain_randomized() ? 0.6f : 0.2f))
    return rng.chance(0.6f) ? Gesture::anywhere : Gesture::with_thing;
  return static_cast<Gesture>(rng.choose(kGestures, kReservedGestures));
}

Pose make_pose(RandomStream& rng, const Body& body, Gesture gesture) {
  Pose pose;
  pose.lean = 0.06f + 0.09f * rng.normal();
  pose.side = 0.05f * rng.normal();
  pose.twist = 0.12f * rng.normal();
  pose.head_yaw = 0.25f * rng.normal();
  pose.head_pitch = 0.02f + 0.1f * rng.normal();
  pose.head_roll = 0.1f * rng.normal();
  for (float& shrug : pose.shrug) shrug = 0.006f * rng.normal();
  pose.sitting = rng.chance(0.2f);
  for (vec3& foot : pose.foot) foot = {rng.uniform(0.03f, 0.11f), 0, rng.uniform(-0.06f, 0.08f)};
  const int side = rng.below(2);
  ArmPose& one = pose.arm[side];
  ArmPose& other = pose.arm[1 - side];
  one = other = kHanging;
  if (rng.chance(0.3f)) other = kBent;
  pose.held_side = side;
  apply_gesture(rng, pose, gesture, one, other);
  if (pose.held == Held::nothing && rng.chance(0.12f)) pose.held = Held::bag;  // on a shoulder strap
  const float spread = gesture == Gesture::crossed || pose.both_hands ? 0.006f : 0.014f;
  for (ArmPose& a : pose.arm) {
    a.wrist += spread * vec3(rng.normal(), rng.normal(), rng.normal());
    a.elbow += 0.15f * vec3(rng.normal(), rng.normal(), rng.normal());
    a.fingers = glm::normalize(glm::normalize(a.fingers) + 0.12f * vec3(rng.normal(), rng.normal(), rng.normal()));
    a.curl = std::clamp(a.curl + 0.12f * rng.normal(), 0.0f, 1.0f);
    a.wrist.x += std::max(body.girth, 0.0f) * 0.02f;
    a.wrist.z += std::max(body.girth, 0.0f) * 0.015f;
  }
  return pose;
}

}  // namespace dualpixel::scenes
