#pragma once
#include "scenes/people/environment/builder.h"

namespace dualpixel::scenes {

Material leaves_material(RandomStream& rng);

/// Leaves as single rhombi about the surface of an ellipsoid.
void add_leaves(SceneObject& object, RandomStream& rng, vec3 center, vec3 radii, int count, float leaf_m);

/// Its foot and height, meters.
void add_tree(EnvironmentBuilder& build, RandomStream& rng, vec3 foot, float tall);
void add_plant(EnvironmentBuilder& build, RandomStream& rng, vec3 foot);

}  // namespace dualpixel::scenes
