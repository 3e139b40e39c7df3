#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "capture/error.h"
#include "scenes/kinds/kinds.h"
#include "scenes/kinds/portrait_people.h"
#include "scenes/people/makehuman/assets.h"
#include "scenes/places/places.h"
#include "scenes/places/room.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;
using Type = Parameter::Type;

void lay_place(SceneBuilder& build, RandomStream rng, const Parameters& p) {
  const std::string& place = p.choice("place");
  if (place == "room") {
    RoomOptions room;
    RandomStream own = rng.substream(1);
    room.light = p.choice("light") == "night" || p.choice("light") == "dusk" ? "lamps" : "window";
    room.deep_m = p.real("distance_m") + own.uniform(2, 5);
    room.wide_m = own.uniform(3, 5);
    room.clear_middle = true;
    return furnish_room(build, rng.substream(2), room);
  }
  PlaceOptions options;
  options.light = p.choice("light");
  options.nearest_m = p.real("distance_m") + 0.8f;
  options.clear_m = 0.5f;
  options.farthest_m = 60;
  options.trees = 7;
  options.lamps = 6;
  set_daylight(build, rng.substream(1), options.light);
  if (place == "street") {
    lay_street(build, rng.substream(2), options);
  } else {
    lay_garden(build, rng.substream(2), options);
  }
  if (const float nits = lamp_nits(options.light); nits > 0) {  // faces would be dark before the lamps behind them
    RandomStream lamp = rng.substream(3);
    const float beside = lamp.sign() * lamp.uniform(0.9f, 1.8f);
    add_lamp_post(build, lamp.substream(1), {build.eye.x + beside, 0, lamp.uniform(0.2f, 0.8f)}, nits);
  }
}

/// None where no folder is given.
std::unique_ptr<const MakeHumanAssets> read_makehuman(const std::string& folder) {
  if (folder.empty()) return nullptr;
  try {
    return std::make_unique<const MakeHumanAssets>(folder);
  } catch (const InputError& error) {
    throw InputError(std::string("portrait: makehuman: ") + error.what());
  }
}

void build_portrait(SceneBuilder& build, const Parameters& p, RandomStream rng) {
  const std::unique_ptr<const MakeHumanAssets> makehuman = read_makehuman(p.folder("makehuman"));
  lay_place(build, rng.substream(1), p);
  const float center = build.eye.x, distance = p.real("distance_m");
  const int people = p.integer("people");
  RandomStream at = rng.substream(2);
  // shoulder to shoulder as far as the picture is wide enough, else behind one another's shoulders
  const float spacing = std::clamp(0.42f * distance, 0.32f, 0.5f);
  StandingFace nearest;
  for (int i = 0; i < people; ++i) {
    const float beside =
        spacing * (static_cast<float>(i) - 0.5f * static_cast<float>(people - 1)) + 0.05f * at.normal();
    PersonSpot spot;
    spot.foot = {center + beside * (people > 1 ? 1.0f : 0.4f), 0,
                 -distance - p.real("depth_step_m") * static_cast<float>(i)};
    spot.yaw = 0.35f * at.normal() - 0.4f * beside;
    spot.lowest_m = i == 0 ? 0.4f : 0.1f;
    if (i > 0) spot.eyes_m = nearest.middle.y + std::clamp(0.08f * at.normal(), -0.15f, 0.15f);
    const StandingFace face = add_person(build, rng.substream(10 + i), spot, makehuman.get());
    if (i == 0) nearest = face;
  }
  const vec3 middle = nearest.middle;
  const vec3 eye(center + 0.12f * distance * at.normal(), std::clamp(middle.y + 0.1f * at.normal(), 0.5f, 2.1f), 0);
  const float lower = distance * at.uniform(0.02f, 0.14f);  // the face above the picture's middle
  // towards the middle of a group, as far as the first face stays well inside the picture
  const float aside = people > 1 ? std::min(0.5f * spacing * static_cast<float>(people - 1), 0.2f * distance)
                                 : 0.05f * distance * at.normal();
  if (p.integer("branch") == 1 && distance > 0.7f) add_branch_in_front(build, rng.substream(4), eye, 0.5f * distance);
  build.camera(eye, middle + vec3(aside, -lower, 0));
  build.focus_on(middle);
  build.shooting.clear_m = 0.4f * distance;
  build.shooting.key *= 0.8f;           // skin is brighter than most of what people wear
  build.shooting.most_clipped = 0.25f;  // faces before windows and skies
  build.face = nearest.outline;
}

}  // namespace

SceneKind portrait_kind() {
  return {
      "portrait",
      "people in front of a garden, a street or a room; the first one's eyes are in focus",
      {{"people", "", Type::integer, 1, 4, 1, 3, "side by side"},
       {"place", "", Type::number, 0, 0, 0, 0, "behind them", {"garden", "street", "room"}},
       {"light",
        "",
        Type::number,
        0,
        0,
        0,
        0,
        "as outdoors; in a room dusk and night mean lamps",
        {"sun", "overcast", "dusk", "night"}},
       {"distance_m", "m", Type::logarithmic, 0.4, 4, 0.7, 1.5, "from the camera to the first person"},
       {"depth_step_m", "m", Type::number, 0, 3, 0.25, 0.6, "that each further person stands behind the one before"},
       {"branch", "", Type::integer, 0, 1, 0, 1, "1: leaves hang into the picture"},
       {"makehuman", "", Type::folder, 0, 0, 0, 0, "of assets in MakeHuman's formats that people are made from"}},
      build_portrait,
      [](const Parameters& p) {
        return p.choice("place") == "room" ? simulator::EnvironmentModel::constant : simulator::EnvironmentModel::sky;
      }};
}

}  // namespace dualpixel::scenes
