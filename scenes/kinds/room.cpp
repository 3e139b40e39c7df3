#include <algorithm>
#include <cmath>

#include "scenes/kinds/kinds.h"
#include "scenes/places/room.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;
using Type = Parameter::Type;

void build_room(SceneBuilder& build, const Parameters& p, RandomStream rng) {
  RoomOptions room;
  room.light = p.choice("light");
  room.lamp_strength = p.real("lamp_strength");
  room.wide_m = p.real("width_m");
  room.deep_m = p.real("depth_m");
  room.furniture = p.integer("furniture");
  room.mirror = p.integer("mirror") == 1;
  RandomStream aim = rng.substream(2), beyond = rng.substream(3);
  const float most_beyond = std::min(8.5f - room.deep_m, 4.0f);
  if (!room.mirror && most_beyond > 1.5f && beyond.chance(0.5f)) room.beyond_m = beyond.uniform(1.5f, most_beyond);
  furnish_room(build, rng.substream(1), room);
  const float half = 0.5f * room.wide_m - 0.5f;
  const vec3 eye(half * aim.uniform(-0.8f, 0.8f), p.real("height_m"), 0.3f);
  const vec3 target(0.5f * half * aim.uniform(-1, 1), aim.uniform(0.4f, 1.1f), -room.deep_m);
  add_near_furniture(build, rng.substream(4), room, eye, target);
  build.camera(eye, target);
  build.shooting.clear_m = 0.6f;
}

}  // namespace

SceneKind room_kind() {
  return {"room",
          "a furnished room; focused on whatever surface the seed picks",
          {{"light", "", Type::number, 0, 0, 0, 0, "daylight from windows, or lamps at night", {"window", "lamps"}},
           {"lamp_strength", "", Type::number, 0.0001, 10, 1, 1, "of lamps; 1: about a hundred lux, 0.05: five"},
           {"width_m", "m", Type::number, 1.8, 12, 3, 5.5, "of the room"},
           {"depth_m", "m", Type::number, 1.5, 12, 3, 8, "from the camera to the wall behind"},
           {"furniture", "", Type::integer, 0, 30, 4, 9, "pieces, as far as there is room"},
           {"height_m", "m", Type::number, 0.2, 2.3, 1.1, 1.7, "of the camera over the floor"},
           {"mirror", "", Type::integer, 0, 1, 0, 0, "1: a mirror on the wall behind, and glass before it"}},
          build_room,
          [](const Parameters&) { return simulator::EnvironmentModel::constant; }};
}

}  // namespace dualpixel::scenes
