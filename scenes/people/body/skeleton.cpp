#include "scenes/people/body/skeleton.h"

#include <glm/gtc/matrix_transform.hpp>

namespace dualpixel::scenes {
namespace {

mat3 turn(float angle, vec3 axis) { return mat3(glm::rotate(glm::mat4(1), angle, axis)); }

/// The smallest rotation that takes unit a to unit b.
mat3 rotation_between(vec3 a, vec3 b) {
  const vec3 axis = glm::cross(a, b);
  const float sine = glm::length(axis), cosine = glm::dot(a, b);
  if (sine < 1e-5f) return cosine > 0 ? mat3(1) : turn(3.14159265f, {1, 0, 0});
  return turn(std::atan2(sine, cosine), axis / sine);
}

/// The middle joint of two sticks from a towards b, which moves to within reach; the joint bends towards `pole`.
vec3 bend(vec3 a, vec3& b, float first_m, float second_m, vec3 pole) {
  const vec3 d = b - a;
  const float distance = glm::length(d);
  const vec3 along = distance > 1e-4f ? d / distance : vec3(0, -1, 0);
  const float reach = std::clamp(distance, 1.05f * std::abs(first_m - second_m) + 0.01f, 0.995f * (first_m + second_m));
  b = a + along * reach;
  const float x = (first_m * first_m - second_m * second_m + reach * reach) / (2 * reach);
  vec3 across = pole - along * glm::dot(pole, along);
  across = glm::length(across) > 1e-4f ? glm::normalize(across) : vec3(0, 0, -1);
  return a + along * x + across * std::sqrt(std::max(first_m * first_m - x * x, 0.0f));
}

ArmPose arm(vec3 wrist, vec3 elbow, vec3 fingers, vec3 palm, float curl) { return {wrist, elbow, fingers, palm, curl}; }

/// About where the fore-arm points, before the skeleton and so its lengths are known.
vec3 fore_arm(const ArmPose& pose) {
  vec3 wrist = pose.wrist;
  const vec3 shoulder(0.109f, 0.192f, -0.004f), elbow = bend(shoulder, wrist, 0.182f, 0.15f, pose.elbow);
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

}  // namespace

mat3 axes_along(vec3 along, vec3 towards) {
  const vec3 y = glm::normalize(along);
  vec3 z = towards - y * glm::dot(towards, y);
  z = glm::length(z) > 1e-4f ? glm::normalize(z) : glm::normalize(glm::cross(y, vec3(0.3f, 0.9f, 0.1f)));
  return {glm::cross(y, z), y, z};
}

Body make_body(RandomStream& rng) {
  Body body;
  body.child = rng.chance(0.12f);
  body.old = !body.child && rng.chance(0.15f);
  body.woman = rng.chance(0.5f) ? rng.uniform(0.7f, 1) : rng.uniform(0, 0.2f);
  body.girth = std::clamp(0.45f * rng.normal(), -1.0f, 1.2f);
  if (body.child) {
    body.stature_m = rng.uniform(0.95f, 1.5f);
    body.head_scale = 0.84f + 0.1f * (body.stature_m - 0.95f) / 0.55f + 0.02f * rng.normal();
    body.woman *= 0.3f;
    body.girth *= 0.5f;
  } else {
    body.stature_m = 1.765f - 0.13f * body.woman + 0.065f * rng.normal();
    body.head_scale = 1.02f - 0.05f * body.woman + 0.025f * rng.normal();
  }
  body.shoulder_half_m = body.stature_m * (0.109f - 0.008f * body.woman + 0.006f * body.girth) + 0.006f * rng.normal();
  body.hip_half_m = body.stature_m * (0.05f + 0.004f * body.woman);
  return body;
}

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
    case Gesture::holding: {
      one = kHold;
      one.wrist += vec3(rng.uniform(-0.03f, 0.05f), rng.uniform(-0.06f, 0.1f), rng.uniform(-0.03f, 0.05f));
      constexpr Held kOneHand[] = {Held::phone,   Held::cup,        Held::bottle,
                                   Held::bouquet, Held::microphone, Held::umbrella};
      pose.held = kOneHand[rng.below(6)];
      break;
    }
    case Gesture::holding_both: {
      one = other = kHold;
      const vec3 shift(rng.uniform(-0.01f, 0.02f), rng.uniform(-0.08f, 0.06f), rng.uniform(-0.02f, 0.04f));
      one.wrist += shift, other.wrist += shift;
      constexpr Held kTwoHands[] = {Held::book, Held::ball, Held::animal, Held::tablet, Held::bouquet, Held::phone};
      pose.held = kTwoHands[rng.below(6)];
      pose.both_hands = true;
      break;
    }
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
      for (ArmPose& a : pose.arm) {
        if (&a == &other && rng.chance(0.4f)) continue;
        a.wrist = {rng.uniform(-0.06f, 0.25f), rng.uniform(-0.1f, 0.42f), rng.uniform(0.06f, 0.32f)};
        a.elbow = vec3(0.8f, -0.6f, -0.3f) + vec3(0.7f, 0.8f, 0.8f) * rng.uniform3(-1, 1);
        a.fingers = 1.2f * fore_arm(a) + 0.7f * rng.uniform3(-1, 1);
        a.palm = vec3(-0.4f, 0, 0) + rng.uniform3(-1, 1);
        a.curl = rng.uniform();
      }
      if (rng.chance(0.4f)) pose.held = Held::thing;
      break;
    case Gesture::with_thing:
      one = other = kHold;
      one.wrist += vec3(rng.uniform(-0.02f, 0.06f), rng.uniform(-0.14f, 0.1f), rng.uniform(-0.04f, 0.06f));
      other.wrist = one.wrist + vec3(0, rng.uniform(-0.03f, 0.03f), rng.uniform(-0.03f, 0.03f));
      pose.held = Held::thing;
      pose.both_hands = true;
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
      one = kToast;
      one.wrist += vec3(rng.uniform(-0.03f, 0.04f), rng.uniform(-0.05f, 0.05f), rng.uniform(-0.03f, 0.03f));
      pose.held = Held::glass;
      break;
    case Gesture::carrying: {
      one = other = kCarry;
      const float higher = rng.uniform(-0.03f, 0.07f);
      one.wrist.y += higher, other.wrist.y += higher;
      pose.held = Held::parcel;
      pose.both_hands = true;
      break;
    }
  }
  if (pose.held == Held::nothing && rng.chance(0.12f)) pose.held = Held::bag;  // over a shoulder
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

vec3 Skeleton::rest_position_of(vec3 p) const {
  vec3 sum(0);
  float total = 0;
  for (const Bone& bone : bones) {
    const float d = std::max(capsule(p, bone.a, bone.b, 0, 0) / bone.radius_m, 0.2f);
    const float d2 = d * d, weight = 1 / (d2 * d2 * d2);
    sum += weight * (bone.rest_a + (p - bone.a) * bone.axes);
    total += weight;
  }
  return sum / total;
}

Proportions proportions_of(const Body& body) {
  const float h = body.stature_m, s = body.head_scale;
  Proportions p;
  p.pelvis_m = 0.535f * h;
  p.sitting_pelvis_m = 0.28f * h;
  p.chest = {0, 0.065f * h, 0};
  p.neck_base = {0, 0.218f * h, -0.012f * h};
  // what stature leaves over the neck's base, less what of the head is above its origin
  const float head_top = 0.137f * s;
  p.neck = {0, std::max(h * (1 - 0.535f - 0.065f - 0.218f) - head_top, 0.055f * s), 0.004f * h};
  p.head_forward_m = 0.012f * s;
  p.shoulder = {body.shoulder_half_m, 0.192f * h, -0.004f * h};
  p.hip = {body.hip_half_m, -0.01f * h, 0};
  const float arm_scale = body.child ? 0.96f : 1.0f;
  p.upper_arm_m = 0.182f * h * arm_scale;
  p.fore_arm_m = 0.15f * h * arm_scale;
  p.thigh_m = 0.245f * h;
  p.shank_m = 0.246f * h;
  return p;
}

Skeleton make_skeleton(const Body& body, const Pose& pose, vec3 place, float yaw, const Proportions& proportions) {
  const float h = body.stature_m;
  Skeleton k;
  k.pelvis.axes = turn(yaw, {0, 1, 0});
  k.pelvis.origin = place + vec3(0, pose.sitting ? proportions.sitting_pelvis_m : proportions.pelvis_m, 0);
  k.chest.axes = k.pelvis.axes * turn(pose.twist, {0, 1, 0}) * turn(pose.lean, {1, 0, 0}) * turn(-pose.side, {0, 0, 1});
  k.chest.origin = k.pelvis.to_world(proportions.chest) + 0.06f * h * vec3(k.chest.axes[1] - vec3(0, 1, 0));
  k.neck_base = k.chest.to_world(proportions.neck_base);
  const mat3 neck_axes = k.chest.axes * turn(0.45f * pose.head_yaw, {0, 1, 0}) *
                         turn(0.12f + 0.5f * pose.head_pitch, {1, 0, 0}) * turn(-0.5f * pose.head_roll, {0, 0, 1});
  k.head.axes = k.chest.axes * turn(pose.head_yaw, {0, 1, 0}) * turn(pose.head_pitch - 0.6f * pose.lean, {1, 0, 0}) *
                turn(-pose.head_roll, {0, 0, 1});
  k.head.origin = k.neck_base + neck_axes * proportions.neck + k.head.axes[2] * proportions.head_forward_m;
  const Frame rest_chest{{0, 0.6f * h, 0}, mat3(1)};
  const auto add_bone = [&](vec3 a, vec3 b, const mat3& axes, vec3 rest_a, float radius) {
    k.bones.push_back({a, b, axes, rest_a, radius});
  };
  add_bone(k.pelvis.origin, k.pelvis.to_world({0, 0.03f * h, 0}), k.pelvis.axes, {0, 0.535f * h, 0}, 0.09f * h);
  add_bone(k.chest.to_world({0, 0.05f * h, 0}), k.chest.to_world({0, 0.2f * h, 0}), k.chest.axes,
           rest_chest.to_world({0, 0.05f * h, 0}), 0.09f * h);
  add_bone(k.neck_base, k.head.origin, neck_axes, rest_chest.to_world(proportions.neck_base), 0.035f * h);
  for (int side = 0; side < 2; ++side) {
    const float x = side == 0 ? 1.0f : -1.0f;
    const ArmPose& arm_pose = pose.arm[side];
    const auto mirrored = [&](vec3 v) { return vec3(x * v.x, v.y, v.z); };
    const auto to_world = [&](vec3 v) { return k.chest.axes * mirrored(v); };
    const float lift = 0.25f * std::max(arm_pose.wrist.y - 0.2f, 0.0f) + pose.shrug[side];
    const vec3 shoulder_rest = mirrored(proportions.shoulder);
    k.shoulder[side] = k.chest.to_world(shoulder_rest + vec3(-0.3f * x * lift * h, lift * h, 0));
    const float upper = proportions.upper_arm_m, fore = proportions.fore_arm_m;
    k.wrist[side] = k.chest.to_world(h * mirrored(arm_pose.wrist));
    k.elbow[side] = bend(k.shoulder[side], k.wrist[side], upper, fore, to_world(arm_pose.elbow));
    const mat3 hand_axes = axes_along(to_world(arm_pose.fingers), to_world(arm_pose.palm));
    const float hand_m = 0.108f * h;
    k.hand[side] = {k.wrist[side] + hand_axes[1] * (0.45f * hand_m), hand_axes};
    // at rest arms hang a little away from the body
    const vec3 rest_down = glm::normalize(vec3(x * 0.2f, -1, 0));
    const auto limb_axes = [&](vec3 a, vec3 b, const mat3& from, vec3 rest) {
      return from * rotation_between(rest, glm::normalize((b - a) * from));
    };
    const mat3 upper_axes = limb_axes(k.shoulder[side], k.elbow[side], k.chest.axes, rest_down);
    const mat3 fore_axes = limb_axes(k.elbow[side], k.wrist[side], upper_axes, rest_down);
    const vec3 rest_shoulder = rest_chest.to_world(shoulder_rest), rest_elbow = rest_shoulder + rest_down * upper;
    add_bone(k.shoulder[side], k.elbow[side], upper_axes, rest_shoulder, 0.034f * h);
    add_bone(k.elbow[side], k.wrist[side], fore_axes, rest_elbow, 0.028f * h);

    k.hip[side] = k.pelvis.to_world(mirrored(proportions.hip));
    const vec3 foot = pose.foot[side];
    k.ankle[side] = place + k.pelvis.axes * vec3(x * foot.x * h, 0.045f * h, (foot.z + (pose.sitting ? 0.22f : 0)) * h);
    k.knee[side] = bend(k.hip[side], k.ankle[side], proportions.thigh_m, proportions.shank_m,
                        k.pelvis.axes * (pose.sitting ? vec3(0.15f * x, 0.6f, 1) : vec3(0.1f * x, 0, 1)));
    k.toe[side] = k.ankle[side] + k.pelvis.axes * vec3(0.25f * x * 0.1f * h, -0.028f * h, 0.1f * h);
    const vec3 rest_hip = vec3(0, 0.535f * h, 0) + mirrored(proportions.hip);
    const mat3 thigh_axes = limb_axes(k.hip[side], k.knee[side], k.pelvis.axes, {0, -1, 0});
    const mat3 shin_axes = limb_axes(k.knee[side], k.ankle[side], thigh_axes, {0, -1, 0});
    add_bone(k.hip[side], k.knee[side], thigh_axes, rest_hip, 0.05f * h);
    add_bone(k.knee[side], k.ankle[side], shin_axes, rest_hip - vec3(0, proportions.thigh_m, 0), 0.035f * h);
  }
  return k;
}

}  // namespace dualpixel::scenes
