#pragma once
#include "scenes/drawn/scene_builder.h"
#include "scenes/shapes/solids.h"

/// Where scenes are: the ground is y = 0, the camera near (0, 1.5, 0) and looks along -z.
namespace dualpixel::scenes {

/// Sun, overcast, dusk or night: environment, sun, and how bright the picture should be.
void set_daylight(SceneBuilder& build, RandomStream rng, const std::string& light);

/// Luminance of street lamps; 0 by day.
float lamp_nits(const std::string& light);

struct PlaceOptions {
  std::string light = "sun";
  int trees = 6;
  int lamps = 4;
  float nearest_m = 1.5f;  ///< nothing but the ground is nearer
  float farthest_m = 100;
  float clear_m = 0.0f;  ///< so far from the axis nothing stands before `farthest_m` / 3: room for people
};

/// Grass, trees, shrubs, a fence, a wall.
void lay_garden(SceneBuilder& build, RandomStream rng, const PlaceOptions& options);
/// A street between facades with lamps, bollards, benches and trees.
void lay_street(SceneBuilder& build, RandomStream rng, const PlaceOptions& options);

/// Shared trees and shrubs, for place().
struct Planting {
  std::vector<int> trees, shrubs;
};
Planting grow_planting(SceneBuilder& build, RandomStream rng, int kinds);
/// Turned, scaled a little.
void plant(SceneBuilder& build, RandomStream& rng, const char* name, int shared, glm::vec3 at, float scale);

/// Leaves on a twig that hangs into the picture, `distance_m` before the camera.
void add_branch_in_front(SceneBuilder& build, RandomStream rng, glm::vec3 eye, float distance_m);
/// A facade of `wide` x `high` whose foot's middle is the origin and which faces +z: for place().
int build_house(SceneBuilder& build, RandomStream rng, float wide, float high, bool lit);
void add_lamp_post(SceneBuilder& build, RandomStream rng, glm::vec3 foot, float nits);
void add_bench(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_fence(SceneBuilder& build, RandomStream rng, glm::vec3 from, glm::vec3 to);
void add_railing(SceneBuilder& build, RandomStream rng, glm::vec3 from, glm::vec3 to);
void add_bollards(SceneBuilder& build, RandomStream rng, glm::vec3 from, glm::vec3 to, float spacing_m);
void add_sign(SceneBuilder& build, RandomStream rng, glm::vec3 foot);

}  // namespace dualpixel::scenes
