#include "scenes/things/things.h"

#include <cmath>
#include <numbers>

namespace dualpixel::scenes {

const std::vector<Thing>& table_things() {
  static const std::vector<Thing> things = {
      {"mug", add_mug, 0.085f, 0.12f, 1.2f},
      {"bowl", add_bowl, 0.14f, 0.16f, 0.8f},
      {"bottle", add_bottle, 0.05f, 0.32f, 0.8f},
      {"candle", add_candle, 0.05f, 0.25f, 0.5f},
      {"turned piece", add_turned_piece, 0.045f, 0.22f, 0.7f},
      {"tin", add_tin, 0.05f, 0.14f, 0.7f},
      {"fruit", add_fruit, 0.06f, 0.1f, 2.2f},
      {"potted plant", add_potted_plant, 0.13f, 0.4f, 1},
      {"vase of flowers", add_vase_of_flowers, 0.12f, 0.45f, 0.9f},
      {"book stack", add_book_stack, 0.15f, 0.16f, 1.1f},
      {"page", add_open_page, 0.17f, 0.03f, 0.9f},
      {"carton", add_carton, 0.1f, 0.24f, 0.7f},
      {"letter blocks", add_letter_blocks, 0.08f, 0.13f, 1},
      {"toy car", add_toy_car, 0.09f, 0.08f, 0.8f},
      {"ring tower", add_ring_tower, 0.07f, 0.2f, 0.6f},
      {"ball", add_toy_ball, 0.06f, 0.11f, 0.7f},
      {"pencil holder", add_pencil_holder, 0.07f, 0.22f, 0.9f},
      {"wire basket", add_wire_basket, 0.13f, 0.14f, 0.9f},
      {"whisk", add_whisk, 0.15f, 0.08f, 0.5f},
      {"crumpled cloth", add_crumpled_cloth, 0.14f, 0.07f, 0.8f},
  };
  return things;
}

const Thing& draw_thing(RandomStream& rng, float most_radius_m, float most_height_m) {
  float total = 0;
  const auto fits = [&](const Thing& thing) {
    return thing.radius_m <= most_radius_m && thing.height_m <= most_height_m;
  };
  for (const Thing& thing : table_things()) total += fits(thing) ? thing.weight : 0;
  float at = rng.uniform() * total;
  const Thing* chosen = &table_things()[6];  // fruit fits everywhere
  for (const Thing& thing : table_things()) {
    if (!fits(thing)) continue;
    chosen = &thing;
    if ((at -= thing.weight) < 0) break;
  }
  return *chosen;
}

Mesh pipe(const glm::mat4& pose, const std::vector<glm::vec3>& path, float radius, int sides) {
  Mesh mesh;
  add_pipe(mesh, path, radius, sides);
  return placed_mesh(std::move(mesh), pose);
}

std::vector<glm::vec3> ring(glm::vec3 center, float radius, int points) {
  return curve(points, [&](float t) {
    const float phi = 2 * std::numbers::pi_v<float> * t;
    return center + radius * glm::vec3(std::cos(phi), 0, std::sin(phi));
  });
}

}  // namespace dualpixel::scenes
