#pragma once
#include <array>
#include <string>
#include <vector>

#include "scenes/people/body/skeleton.h"
#include "scenes/people/shape/stage.h"

/// One person in full: body, head, hair, clothes and what it holds, as pieces of a stage with the truth beside them.
namespace dualpixel::scenes {

/// A round cone from a to b, flattened along one direction; what bodies and garments are blended from.
struct Cone {
  vec3 a, b;
  float radius_a, radius_b;
  float fillet_m = 0.03f;
  vec3 flat_axis{0, 0, 1};
  float flat = 1;      ///< how many times thinner along flat_axis
  vec3 end_normal{0};  ///< not 0: cut off square beyond b, along this direction
};

struct Shape {
  std::vector<Cone> cones;
  vec3 cut_point{0}, cut_normal{0};  ///< not 0: nothing beyond the plane
  float operator()(vec3 p) const;
};

/// A figure under way: the parts are added one after another and see each other's shapes.
struct Figure {
  Body body;
  Pose pose;
  Skeleton skeleton;
  int person = 0;
  float head_cell_m = 0.005f, body_cell_m = 0.012f;
  float lowest_m = -1;                      ///< nothing below this height is seen
  float top_cloth_m = 0, legs_cloth_m = 0;  ///< how far clothes stand off the body, at the most
  Material skin, face, hair;
  /// World places: nose, left and right eye, left and right ear; and of brow, chin, cheeks and jaw.
  std::array<vec3, 5> face_points{};
  std::vector<vec3> face_outline;
  Shape bare;                     ///< the body without clothes, head and hands
  std::vector<std::string> tags;  ///< "hair:long", "held:phone", ...
};

struct FigureOptions {
  vec3 place{0};
  float yaw = 0;       ///< of the body, to its left; 0: towards +z
  float head_yaw = 0;  ///< added to the pose's
  float meters_per_px = 0.004f;
  float lowest_m = -1;  ///< nothing below this height is seen: it need not be made
  int person = 0;
  Gesture gesture = Gesture::hanging;
};

/// Body, pose and joints alone, the same that add_figure() draws from these dice.
Figure pose_figure(RandomStream rng, const FigureOptions& options);
/// Draws a person and adds it to the stage.
Figure add_figure(SceneModel& scene, RandomStream rng, const FigureOptions& options);

// the parts, which see what was drawn before them
void add_body(SceneModel& scene, Figure& figure);
void add_head(SceneModel& scene, Figure& figure, RandomStream rng);
void add_clothes(SceneModel& scene, Figure& figure, RandomStream rng);
void add_hair_and_hat(SceneModel& scene, Figure& figure, RandomStream rng);
void add_held_thing(SceneModel& scene, Figure& figure, RandomStream rng);
void add_seat(SceneModel& scene, const Figure& figure, RandomStream rng);  ///< of one who sits; it is nobody's

/// Torso, shoulders and neck with `offset_m` of room; arms and legs likewise. Sides as in Skeleton.
std::vector<Cone> torso_cones(const Figure& figure, float offset_m);
std::vector<Cone> neck_cones(const Figure& figure, float offset_m);
/// An arm from the shoulder to the share `until` of its length (elbow at .55), cut square where it ends early.
std::vector<Cone> arm_cones(const Figure& figure, int side, float offset_m, float until = 1);
std::vector<Cone> leg_cones(const Figure& figure, int side, float offset_m, float until = 1);

/// The head without hair, in its own frame at scale 1, meters.
struct HeadShape {
  float jaw = 1, cheeks = 1, nose = 1, nose_length = 1, lips = 1, brow = 1, chin = 1, long_face = 1, lids = 1, ears = 1;
  float operator()(vec3 p) const;
};
float skull(vec3 p);

/// Moves a piece from the head's own frame, at scale 1, into the world; rest stays.
void move_to_head(const Figure& figure, SceneObject& object);

void add_object(SceneModel& scene, const Figure& figure, SceneObject object, const Material& material);
/// The surface of a shape between two corners, with rest places of the body and folds of `folds_m`.
SceneObject cloth_object(const Figure& figure, const Shape& shape, float folds_m, std::uint32_t seed,
                         const std::vector<Cone>& carved = {}, float carve_fillet_m = 0.01f);

}  // namespace dualpixel::scenes
