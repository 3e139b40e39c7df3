#include "scenes/people/body/skeleton.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::scenes {

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

Skeleton make_skeleton(const Body& body, const Pose& pose, vec3 position, float yaw, const Proportions& proportions) {
  const float h = body.stature_m;
  Skeleton k;
  k.pelvis.axes = rotation(yaw, {0, 1, 0});
  k.pelvis.origin = position + vec3(0, pose.sitting ? proportions.sitting_pelvis_m : proportions.pelvis_m, 0);
  k.chest.axes = k.pelvis.axes * rotation(pose.twist, {0, 1, 0}) * rotation(pose.lean, {1, 0, 0}) *
                 rotation(-pose.side, {0, 0, 1});
  k.chest.origin = k.pelvis.to_world(proportions.chest) + 0.06f * h * vec3(k.chest.axes[1] - vec3(0, 1, 0));
  k.neck_base = k.chest.to_world(proportions.neck_base);
  const mat3 neck_axes = k.chest.axes * rotation(0.45f * pose.head_yaw, {0, 1, 0}) *
                         rotation(0.12f + 0.5f * pose.head_pitch, {1, 0, 0}) *
                         rotation(-0.5f * pose.head_roll, {0, 0, 1});
  k.head.axes = k.chest.axes * rotation(pose.head_yaw, {0, 1, 0}) *
                rotation(pose.head_pitch - 0.6f * pose.lean, {1, 0, 0}) * rotation(-pose.head_roll, {0, 0, 1});
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
    k.elbow[side] = bend_limb(k.shoulder[side], k.wrist[side], upper, fore, to_world(arm_pose.elbow));
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
    k.ankle[side] =
        position + k.pelvis.axes * vec3(x * foot.x * h, 0.045f * h, (foot.z + (pose.sitting ? 0.22f : 0)) * h);
    k.knee[side] = bend_limb(k.hip[side], k.ankle[side], proportions.thigh_m, proportions.shank_m,
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
