#include <algorithm>
#include <cmath>

#include "scenes/kinds/kinds.h"
#include "scenes/places/places.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;
using Type = Parameter::Type;

void build_outdoors(SceneBuilder& build, const Parameters& p, RandomStream rng) {
  PlaceOptions options;
  options.light = p.choice("light");
  options.trees = p.integer("trees");
  options.lamps = p.integer("lamps");
  options.nearest_m = p.real("nearest_m");
  options.farthest_m = p.real("farthest_m");
  set_daylight(build, rng.substream(1), options.light);
  const bool street = p.choice("place") == "street";
  if (street) {
    lay_street(build, rng.substream(2), options);
  } else {
    lay_garden(build, rng.substream(2), options);
  }
  RandomStream aim = rng.substream(3);
  const vec3 eye(build.eye.x, p.real("height_m"), 0);
  const float turn = std::clamp(0.22f * aim.normal(), -0.4f, 0.4f), pitch = -0.05f + 0.06f * aim.normal();
  if (p.integer("branch") == 1)
    add_branch_in_front(build, rng.substream(4), eye, options.nearest_m * aim.uniform(0.6f, 1));
  build.shooting.clear_m = 0.5f * options.nearest_m;
  build.camera(eye, eye + vec3(std::sin(turn), pitch, -std::cos(turn)));
}

}  // namespace

SceneKind outdoors_kind() {
  return {"outdoors",
          "a garden or a street; focused on whatever surface the seed picks",
          {{"place", "", Type::number, 0, 0, 0, 0, "where", {"garden", "street"}},
           {"light",
            "",
            Type::number,
            0,
            0,
            0,
            0,
            "time and weather; lamps shine at dusk and night",
            {"sun", "overcast", "dusk", "night"}},
           {"trees", "", Type::integer, 1, 60, 3, 14, "besides the wood's edge"},
           {"lamps", "", Type::integer, 0, 40, 2, 12, "lamp posts"},
           {"nearest_m", "m", Type::logarithmic, 0.5, 10, 1, 4, "nothing but the ground is nearer"},
           {"farthest_m", "m", Type::logarithmic, 20, 300, 50, 110, "to the wood's edge or the street's end"},
           {"height_m", "m", Type::number, 0.2, 3, 1.1, 1.8, "of the camera over the ground"},
           {"branch", "", Type::integer, 0, 1, 0, 1, "1: leaves hang into the picture"}},
          build_outdoors,
          [](const Parameters&) { return simulator::EnvironmentModel::sky; }};
}

}  // namespace dualpixel::scenes
