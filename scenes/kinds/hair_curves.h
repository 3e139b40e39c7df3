#pragma once
#include <vector>

#include "scenes/people/body/figure.h"
#include "scenes/people/shape/scene_model.h"

namespace dualpixel::scenes {

/// Strands of hair as a glTF file's line primitive holds them.
struct HairCurves {
  std::vector<vec3> points, colors;
  std::vector<float> widths_m;
  std::vector<glm::uvec2> segments;  ///< pairs of points
};

/// Grows hair on `mass`, the smooth mesh that stands for all of it: combed away from the crown and downwards, in locks,
/// with a few strands that stand off. The mass is of a head's size. `mass.hair_m`: about the length of what shows of
/// one.
HairCurves grow_hair(const SceneObject& mass, const Material& material, const Figure& figure, RandomStream rng);

}  // namespace dualpixel::scenes
