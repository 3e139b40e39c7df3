#include "scenes/people/body/cones.h"

#include <algorithm>

namespace dualpixel::scenes {

float Shape::operator()(vec3 p) const {
  float d = 10;
  for (const Cone& cone : cones) d = blend(d, cone_distance(cone, PreparedCone(cone), p), cone.fillet_m);
  return cut_normal == vec3(0) ? d : std::max(d, glm::dot(p - cut_point, cut_normal));
}

}  // namespace dualpixel::scenes
