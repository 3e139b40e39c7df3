#include "scenes/people/truth.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::scenes {
namespace {

/// A face detector finds faces larger than this.
constexpr float kSmallestFace_px = 9;

/// Whether the first surface on the ray to a joint belongs to that person and is close to the joint.
bool is_visible(const RayTracer& tracer, vec3 eye, vec3 joint, int person, float within_m) {
  const vec3 d = joint - eye;
  const float distance = glm::length(d);
  const auto hit = tracer.intersector().intersect({eye, d / distance});
  return hit && tracer.scene().objects[hit->mesh].person == person && hit->t > distance - within_m;
}

/// Distance from a joint to the surface of its own part of the body, with clothes: what the ray meets earlier is
/// another object, or another part of the same person.
float joint_depth_m(const Figure& figure, int keypoint) {
  // keypoints of the face are on the skin, but noses, lids and glasses have a shape, and rays meet ears at a slant
  if (keypoint < 5) return 0.025f * figure.body.head_scale;
  // shoulder, elbow, wrist, hip, knee, ankle: the radii of body_cones.cpp
  constexpr float kRadius[] = {0.0315f, 0.0235f, 0.016f, 0.072f, 0.034f, 0.022f};
  const float radius = kRadius[(keypoint - 5) / 2] * figure.body.stature_m * (1 + 0.25f * figure.body.girth);
  constexpr float kSlant = 1.4f;  // limbs up to 45 degrees from across the line of sight
  return kSlant * (radius + (keypoint < 11 ? figure.top_cloth_m : figure.legs_cloth_m));
}

}  // namespace

std::array<vec3, kKeypoints> keypoints_of(const Figure& figure) {
  const Skeleton& k = figure.skeleton;
  std::array<vec3, kKeypoints> joints;
  std::copy(figure.face_points.begin(), figure.face_points.end(), joints.begin());
  std::size_t next = figure.face_points.size();
  for (const auto* pair : {&k.shoulder, &k.elbow, &k.wrist, &k.hip, &k.knee, &k.ankle}) {
    for (const vec3& joint : *pair) joints[next++] = joint;
  }
  return joints;
}

PeopleSample truth_of(const RayTracer& tracer, const simulator::CameraView& camera, const Figure& figure,
                      const Rendering& rendering) {
  PeopleSample sample;
  const vec3 eye(camera.world_from_camera[3]);
  const auto joints = keypoints_of(figure);
  const Image& coverage = rendering.coverage;
  for (int i = 0; i < kKeypoints; ++i) {
    const vec3 at = project(camera, joints[i]);
    const bool inside = at.z > 0.05f && at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(coverage.width) &&
                        at.y < static_cast<float>(coverage.height);
    const bool visible = inside && is_visible(tracer, eye, joints[i], figure.person, joint_depth_m(figure, i)) &&
                         coverage.at(static_cast<int>(at.x), static_cast<int>(at.y), figure.person) > 0.5f;
    sample.keypoints[i] = {at.x, at.y, inside ? (visible ? 2.0f : 1.0f) : 0.0f};
  }
  sample.face = face_box(figure, camera);
  sample.tags = figure.tags;
  return sample;
}

glm::vec4 face_box(const Figure& figure, const simulator::CameraView& camera) {
  vec2 low(1e9f), high(-1e9f);
  for (const vec3& p : figure.face_outline) {
    const vec2 at(project(camera, p));
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  const float side = std::max(high.x - low.x, high.y - low.y);
  const vec2 corner = 0.5f * (low + high) - 0.5f * side;
  return {corner, side, side};
}

float turn_of(const Figure& figure, const simulator::CameraView& camera) {
  const vec3 eye(camera.world_from_camera[3]);
  const vec3 to_eye = glm::normalize(eye - figure.skeleton.head.origin);
  return std::acos(std::clamp(glm::dot(to_eye, figure.skeleton.head.axes[2]), -1.0f, 1.0f));
}

bool is_face_detectable(const Figure& figure, const simulator::CameraView& camera, const PeopleSample& sample,
                        const Image& coverage, float most_turned_rad) {
  if (turn_of(figure, camera) > most_turned_rad) return false;
  if (sample.face.z < kSmallestFace_px) return false;
  // nothing in front of it: the mask also holds the umbrella, hand or phone that may hide a face
  if (sample.keypoints[0].z != 2 || (sample.keypoints[1].z != 2 && sample.keypoints[2].z != 2)) return false;
  const int x0 = static_cast<int>(sample.face.x), y0 = static_cast<int>(sample.face.y),
            side = static_cast<int>(sample.face.z);
  float shown = 0;
  for (int y = std::max(y0, 0); y < std::min(y0 + side, coverage.height); ++y) {
    for (int x = std::max(x0, 0); x < std::min(x0 + side, coverage.width); ++x)
      shown += coverage.at(x, y, figure.person);
  }
  return shown > 0.6f * static_cast<float>(side * side);
}

}  // namespace dualpixel::scenes
