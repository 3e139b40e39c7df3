#pragma once
#include <string>
#include <vector>

#include "scenes/people/body/body.h"
#include "scenes/people/makehuman/asset_types.h"
#include "scenes/procedural/random_stream.h"

namespace dualpixel::scenes {

/// A morphed body: rest positions in meters, the floor at 0, and its joints.
struct MorphedBody {
  std::vector<vec3> rest;
  const BaseMesh* base;

  vec3 joint(const std::string& name) const {
    const std::vector<int>& about = base->joints.at("joint-" + name);  // the constructor of the assets checked it
    vec3 sum(0);
    for (const int v : about) sum += rest[static_cast<std::size_t>(v)];
    return sum / static_cast<float>(about.size());
  }
  vec3 joint(int side, const std::string& name) const { return joint((side == 0 ? "l-" : "r-") + name); }
};

/// Throws InputError (prefixed by `whose`) where eyes or width are no human's: hair and hats are meshed on cells of the
/// head's size, so another size could need any amount of memory.
void require_human_sizes(const MorphedBody& body, const std::string& whose);

/// Throws InputError where a joint is far outside the body, or the two bones of a limb are too short or too unlike to
/// be posed.
void require_limbs(const MorphedBody& body, const std::string& whose);

/// Throws InputError unless the base mesh of `path` has all joints and human sizes.
void require_a_body(const BaseMesh& base, const std::string& path);

}  // namespace dualpixel::scenes
