#pragma once
#include <string>

#include "scenes/people/body/cones.h"
#include "scenes/people/body/skeleton.h"
#include "scenes/people/shape/scene_model.h"

/// A person under construction, as objects of a scene with the ground truth.
namespace dualpixel::scenes {

/// One person. Its parts are added one after another, each with access to those before it.
struct Figure {
  Body body;
  Pose pose;
  Skeleton skeleton;
  int person = 0;
  float head_cell_m = 0.005f, body_cell_m = 0.012f;
  float lowest_m = -1;                      ///< nothing below this height is visible
  float top_cloth_m = 0, legs_cloth_m = 0;  ///< greatest distance of the clothes from the body
  Material skin, face, hair;
  /// World positions: nose, left and right eye, left and right ear; and points on brow, chin, cheeks and jaw.
  std::array<vec3, 5> face_points{};
  std::vector<vec3> face_outline;
  Shape bare;                     ///< the body without clothes, head and hands
  std::vector<std::string> tags;  ///< "hair:long", "held:phone", ...
};

struct FigureOptions {
  vec3 position{0};    ///< of the point on the floor below the pelvis, meters
  float yaw = 0;       ///< of the body, to its left; 0: towards +z
  float head_yaw = 0;  ///< added to the pose's
  float meters_per_px = 0.004f;
  float lowest_m = -1;  ///< nothing below this height is visible, so it is not made
  int person = 0;
  Gesture gesture = Gesture::hanging;
};

/// Body, pose and mesh resolution, without a skeleton. The streams continue after these draws.
Figure draw_body_and_pose(RandomStream& body_rng, RandomStream& pose_rng, const FigureOptions& options);
/// Body, pose and joints alone, the same that add_figure() draws from this stream.
Figure pose_figure(RandomStream rng, const FigureOptions& options);

/// Adds an object that belongs to the figure; nothing where it has no triangles.
void add_object(SceneModel& scene, const Figure& figure, SceneObject object, const Material& material);

}  // namespace dualpixel::scenes
