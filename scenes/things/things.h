#pragma once
#include "scenes/drawn/scene_builder.h"
#include "scenes/shapes/solids.h"

/// Things that stand on tables, shelves and floors. Each is drawn from its stream and put where `pose` says: its foot
/// at the origin, y up, meters.
namespace dualpixel::scenes {

using ThingFunction = void (*)(SceneBuilder&, RandomStream, const glm::mat4& pose);

struct Thing {
  const char* name;
  ThingFunction add;
  float radius_m;  ///< that it may take up
  float height_m;  ///< at most
  float weight;    ///< how often it is drawn
};

void add_mug(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_bowl(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_bottle(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_candle(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_turned_piece(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_tin(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);

void add_fruit(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_potted_plant(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_vase_of_flowers(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);

void add_book_stack(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_open_page(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_carton(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
/// Books side by side along x, `length_m` of them.
void add_book_row(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, float length_m, float height_m);

void add_letter_blocks(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_toy_car(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_ring_tower(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_toy_ball(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);

void add_pencil_holder(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_wire_basket(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_whisk(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);
void add_crumpled_cloth(SceneBuilder& build, RandomStream rng, const glm::mat4& pose);

/// What stands on tables.
const std::vector<Thing>& table_things();
/// One of them, by weight, of those that fit.
const Thing& draw_thing(RandomStream& rng, float most_radius_m, float most_height_m);

/// Paths of many points; `pose` applied.
Mesh pipe(const glm::mat4& pose, const std::vector<glm::vec3>& path, float radius, int sides = 8);
std::vector<glm::vec3> ring(glm::vec3 center, float radius, int points = 40);

}  // namespace dualpixel::scenes
