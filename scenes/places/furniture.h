#pragma once
#include "scenes/drawn/scene_builder.h"
#include "scenes/shapes/solids.h"

/// Furniture: its foot at the origin of `pose`, its front to +z, meters.
namespace dualpixel::scenes {

void add_dining_table(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_chair(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_sofa(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
/// Shelves with books and things.
void add_bookcase(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_cupboard(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
/// A lamp on a stand with a shade; `nits` of its bulb.
void add_floor_lamp(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float nits);
void add_pendant(SceneBuilder& build, RandomStream rng, glm::vec3 at, float ceiling_y, float nits);
void add_floor_plant(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
/// Folds of cloth that hang from `top`, `wide` along +x of the pose.
void add_curtain(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float wide, float high);
void add_blinds(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float wide, float high);
/// On a wall whose front is +z.
void add_wall_picture(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_mirror(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, glm::vec2 half);
/// A clear pane that stands upright on a wooden foot, and a ball of solid glass on the floor beside it.
void add_glass_screen(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, glm::vec2 half);

}  // namespace dualpixel::scenes
