#pragma once
#include "scenes/procedural/random_stream.h"
#include "scenes/textures/paint.h"

/// What surfaces are made of: a picture of the color, how large it is, and how it reflects.
namespace dualpixel::scenes {

struct Surface {
  Texture texture;     ///< size 0: none
  float repeat_m = 1;  ///< side of the picture
  glm::vec3 color{1};  ///< multiplies the picture
  float roughness = 1;
  float metallic = 0;
  bool unlit = false;
  glm::vec3 emission_nits{0};
  float transmission = 0;  ///< as in GlbMaterial
  bool solid = false;
  float subsurface = 0;
};

/// One color, mottled a little: paint, plastic, ceramics, leather, metal.
Surface plain_surface(RandomStream rng, glm::vec3 color, float roughness, float contrast = 0.06f);
Surface metal_surface(RandomStream rng, glm::vec3 color, float roughness);
/// Boards of wood, `board_m` wide, that run along v; 0: one piece.
Surface wood_surface(RandomStream rng, glm::vec3 color, float board_m, float repeat_m = 0.6f);
/// Plaster, concrete, earth: noise of `slope` from the size of the picture down to its texels.
Surface rough_surface(RandomStream rng, glm::vec3 color, float contrast, float repeat_m, float slope = 1.3f);
Surface brick_surface(RandomStream rng, glm::vec3 color);
/// Square or oblong tiles, setts and slabs with joints.
Surface tile_surface(RandomStream rng, glm::vec3 color, glm::vec3 joint, glm::vec2 tile_m, float variety);
/// Threads over and under each other: `thread_m` from one to the next; with stripes or checks of a second color.
Surface woven_surface(RandomStream rng, glm::vec3 color, glm::vec3 second, float thread_m);
Surface bark_surface(RandomStream rng, glm::vec3 color);
/// Leaves: shade along u picks the tone.
Surface leaf_surface(RandomStream rng, glm::vec3 color, glm::vec3 other);
Surface glowing_surface(glm::vec3 nits);

/// Colors that paint, cloth and toys come in: muted ones more often than bright ones.
glm::vec3 paint_color(RandomStream& rng);
glm::vec3 wood_color(RandomStream& rng);

}  // namespace dualpixel::scenes
