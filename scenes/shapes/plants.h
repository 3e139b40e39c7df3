#pragma once
#include "scenes/gltf/mesh.h"
#include "scenes/procedural/random_stream.h"

/// Leaves and what carries them, appended to meshes: one for the wood, one for the leaves.
namespace dualpixel::scenes {

/// A leaf from `base` along `along`: a folded, drooping blade of `steps` quads a half.
struct Leaf {
  glm::vec3 base{0}, along{0, 1, 0}, up{0, 0, 1};
  float length = 0.1f, width = 0.04f;
  float droop = 0.2f;  ///< how far the tip sinks, of the length
  float fold = 0.3f;   ///< how far the edges rise, of the width
  float stalk = 0;     ///< narrow part at the base, of the length
};
void add_blade(Mesh& leaves, const Leaf& leaf, float shade, int steps = 3);

struct TreeOptions {
  float height_m = 6;
  float trunk_share = 0.3f;  ///< of the height, below the first branches
  float spread = 0.5f;       ///< width of the crown, of the height
  int leaves = 9000;
  float leaf_m = 0.09f;
  bool bare = false;
};
void add_tree(Mesh& wood, Mesh& leaves, RandomStream rng, const TreeOptions& options);

struct ShrubOptions {
  glm::vec3 radii{0.5f};
  int leaves = 900;
  float leaf_m = 0.06f;
};
/// A shrub that stands at the origin.
void add_shrub(Mesh& wood, Mesh& leaves, RandomStream rng, const ShrubOptions& options);

/// A rosette of long blades (grass, dracaena) or stems with leaves, from the origin up.
void add_pot_plant(Mesh& leaves, RandomStream rng, float height_m);

/// Blades of grass over a disc about the origin.
void add_grass(Mesh& leaves, RandomStream rng, int blades, float radius_m, float height_m);

/// A flower head at `at` facing `facing`: petals and a middle.
void add_flower(Mesh& petals, Mesh& middle, RandomStream rng, glm::vec3 at, glm::vec3 facing, float radius_m);

}  // namespace dualpixel::scenes
