#include "scenes/people/makehuman/motion.h"

#include <fmt/format.h>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace dualpixel::scenes {
namespace {

/// Fingers bend towards the palm about the x axis of the hand; they are a little bent at rest.
void bend_fingers(const MorphedBody& morphed, const Skeleton& k, const Pose& pose, int side,
                  std::vector<PartMotion>& motion) {
  const float bend = 1.1f * (pose.arm[side].curl - 0.25f);
  for (int finger = 0; finger < kFingers; ++finger) {
    PartMotion parent = motion[part_of(side, kHand)];
    for (int bone = 0; bone < kPhalanges; ++bone) {
      const vec3 joint = morphed.joint(side, fmt::format("finger-{}-{}", finger + 2, bone + 1));
      const mat3 turned = mat3(glm::rotate(glm::mat4(1), bend, k.hand[side].axes[0])) * parent.axes;
      const PartMotion own{turned, joint, parent.moved(joint)};
      motion[part_of(side, kFirstFinger + finger * kPhalanges + bone)] = own;
      parent = own;
    }
  }
}

}  // namespace

RestFrames rest_frames(const MorphedBody& morphed, float stature) {
  RestFrames f;
  f.pelvis = 0.5f * (morphed.joint("l-upper-leg") + morphed.joint("r-upper-leg")) + vec3(0, 0.01f * stature, 0);
  f.chest = f.pelvis + vec3(0, 0.065f * stature, 0);
  f.neck = morphed.joint("neck");
  const vec3 eyes = 0.5f * (morphed.joint("l-eye") + morphed.joint("r-eye"));
  const float s = glm::distance(morphed.joint("l-eye"), morphed.joint("r-eye")) / 0.062f;
  f.head = eyes - s * vec3(0, 0.0148f, 0.0715f);
  return f;
}

std::vector<PartMotion> motions_of(const MorphedBody& morphed, const RestFrames& rest, const Skeleton& k,
                                   const Pose& pose) {
  std::vector<PartMotion> motion(kParts);
  motion[kPelvis] = {k.pelvis.axes, rest.pelvis, k.pelvis.origin};
  motion[kChest] = {k.chest.axes, rest.chest, k.chest.origin};
  motion[kNeck] = {k.bones[Skeleton::kNeckBone].axes, rest.neck, k.neck_base};
  motion[kHead] = {k.head.axes, rest.head, k.head.origin};
  for (int side = 0; side < 2; ++side) {
    const vec3 shoulder = morphed.joint(side, "shoulder"), elbow = morphed.joint(side, "elbow"),
               wrist = morphed.joint(side, "hand");
    const vec3 hip = morphed.joint(side, "upper-leg"), knee = morphed.joint(side, "knee"),
               ankle = morphed.joint(side, "ankle");
    const auto limb = [](const mat3& from, vec3 rest_along, vec3 posed_along) {
      return from * rotation_between(glm::normalize(rest_along), glm::normalize(posed_along) * from);
    };
    const auto set = [&](int part, const mat3& axes, vec3 from, vec3 to) {
      motion[part_of(side, part)] = {axes, from, to};
    };
    const mat3 upper = limb(k.chest.axes, elbow - shoulder, k.elbow[side] - k.shoulder[side]);
    const mat3 fore = limb(upper, wrist - elbow, k.wrist[side] - k.elbow[side]);
    // the hand's own frame at rest: fingers along y, palm towards z, x towards the thumb of a right hand and away from
    // a left one's
    const vec3 along = glm::normalize(morphed.joint(side, "finger-3-1") - wrist);
    vec3 across = morphed.joint(side, "finger-2-1") - morphed.joint(side, "finger-5-1");
    across = glm::normalize(across - along * glm::dot(across, along)) * (side == 0 ? -1.0f : 1.0f);
    const mat3 rest_hand(across, along, glm::cross(across, along));
    const mat3 hand = k.hand[side].axes * glm::transpose(rest_hand);
    // how far the hand turns about the forearm: half way down, the forearm has turned by a good half of that
    const vec3 axis = glm::normalize(k.wrist[side] - k.elbow[side]);
    const auto flat = [&](vec3 v) { return v - axis * glm::dot(v, axis); };
    const vec3 before = flat(fore * across), after = flat(hand * across);
    const float twist = std::atan2(glm::dot(glm::cross(before, after), axis), glm::dot(before, after));
    set(kUpperArm, upper, shoulder, k.shoulder[side]);
    set(kForeArm, mat3(glm::rotate(glm::mat4(1), 0.15f * twist, axis)) * fore, elbow, k.elbow[side]);
    set(kTwist, mat3(glm::rotate(glm::mat4(1), 0.6f * twist, axis)) * fore, elbow, k.elbow[side]);
    set(kHand, hand, wrist, k.wrist[side]);
    const mat3 thigh = limb(k.pelvis.axes, knee - hip, k.knee[side] - k.hip[side]);
    set(kThigh, thigh, hip, k.hip[side]);
    set(kShin, limb(thigh, ankle - knee, k.ankle[side] - k.knee[side]), knee, k.knee[side]);
    set(kFoot, k.pelvis.axes, ankle, k.ankle[side]);
    bend_fingers(morphed, k, pose, side, motion);
  }
  return motion;
}

vec3 moved(const std::vector<PartMotion>& motion, const Weights& weights, vec3 p) {
  vec3 sum(0);
  for (const auto& [part, weight] : weights) sum += weight * motion[static_cast<std::size_t>(part)].moved(p);
  return sum;
}

}  // namespace dualpixel::scenes
