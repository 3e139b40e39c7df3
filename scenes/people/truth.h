#pragma once
#include "scenes/people/body/figure.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/photo/render.h"
#include "scenes/people/sample.h"

/// Ground truth of a person in a picture, in the camera's pixels.
namespace dualpixel::scenes {

/// The 17 keypoints in the world, meters.
std::array<vec3, kKeypoints> keypoints_of(const Figure& figure);

/// Keypoints, face box and tags. A keypoint is visible where its own part of the person is the first surface on the ray
/// to it; else it is hidden.
PeopleSample truth_of(const RayTracer& tracer, const simulator::CameraView& camera, const Figure& figure,
                      const Rendering& rendering);

/// The square from brow to chin, about 0.15 m of an adult: x, y, width, height.
glm::vec4 face_box(const Figure& figure, const simulator::CameraView& camera);

/// The angle between where the head looks and the camera, 0 to pi.
float turn_of(const Figure& figure, const simulator::CameraView& camera);

/// Whether a detector would find this face, where it finds those that are turned less than `most_turned_rad`.
bool is_face_detectable(const Figure& figure, const simulator::CameraView& camera, const PeopleSample& sample,
                        const Image& coverage, float most_turned_rad = 1.15f);

}  // namespace dualpixel::scenes
