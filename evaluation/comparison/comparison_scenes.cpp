#include "evaluation/comparison/comparison_scenes.h"

#include "evaluation/simulated_scene.h"
#include "scenes/kinds/kinds.h"

namespace dualpixel::evaluation {

std::span<const ComparisonScene> comparison_scenes() {
  static const std::vector<ComparisonScene> scenes = {
      {"portrait_garden_sun", "portrait", 201, {"people=1", "place=garden", "light=sun", "distance_m=0.8"}},
      {"still_life_window", "still_life", 301, {"light=window", "distance_m=0.35"}},
      {"group_street_overcast", "portrait", 202, {"people=3", "place=street", "light=overcast", "distance_m=1.2"}},
      {"portrait_room_day", "portrait", 203, {"people=1", "place=room", "light=overcast", "distance_m=1"}},
      {"still_life_lamp", "still_life", 302, {"light=lamp", "distance_m=0.4"}},
      {"portrait_street_night", "portrait", 204, {"people=1", "place=street", "light=night", "distance_m=0.9"}},
      {"pair_garden_overcast", "portrait", 205, {"people=2", "place=garden", "light=overcast", "distance_m=1"}},
      {"still_life_sun", "still_life", 303, {"light=sun", "distance_m=0.6"}},
      {"portrait_far_street_sun", "portrait", 206, {"people=1", "place=street", "light=sun", "distance_m=1.8"}},
      {"group_room_lamps", "portrait", 207, {"people=3", "place=room", "light=night", "distance_m=1.2"}},
      {"still_life_near", "still_life", 304, {"light=window", "distance_m=0.25"}},
      {"portrait_near_garden_dusk", "portrait", 208, {"people=1", "place=garden", "light=dusk", "distance_m=0.6"}},
      {"garden_overcast", "outdoors", 401, {"place=garden", "light=overcast", "nearest_m=0.6"}},
      {"pair_room_day", "portrait", 209, {"people=2", "place=room", "light=sun", "distance_m=0.9"}},
      {"still_life_overcast", "still_life", 305, {"light=overcast", "distance_m=0.8"}},
      {"portrait_garden_overcast", "portrait", 210, {"people=1", "place=garden", "light=overcast", "distance_m=1.1"}},
      {"still_life_dark", "still_life", 306, {"light=lamp", "distance_m=0.7"}},
      {"group_garden_sun", "portrait", 211, {"people=4", "place=garden", "light=sun", "distance_m=1.5"}},
      {"portrait_room_lamps", "portrait", 212, {"people=1", "place=room", "light=dusk", "distance_m=0.7"}},
      {"still_life_far", "still_life", 307, {"light=window", "distance_m=1.2"}},
      {"portrait_street_overcast", "portrait", 213, {"people=1", "place=street", "light=overcast", "distance_m=0.8"}},
      {"room_window", "room", 402, {"light=window"}},
      {"pair_street_dusk", "portrait", 214, {"people=2", "place=street", "light=dusk", "distance_m=1"}},
      {"still_life_bright", "still_life", 308, {"light=sun", "distance_m=0.45"}},
  };
  return scenes;
}

Capture simulate_comparison_scene(const ComparisonScene& scene, const std::string& scratch) {
  scenes::SceneOrder order{scene.kind, scene.seed, scene.assignments};
  order.assignments.insert(order.assignments.end(),
                           {"width_px=672", "lens=phone_thin", "burst.hand_shake=0", "sensor.full_well_e=6000",
                            "sensor.electrons_per_lux_s=[3600,4000,3200]"});
  draw_scene(scenes::scene_kind(scene.kind), order, scratch);
  return simulate_scene(
      scratch + "/scene.json",
      {"truth.photograph_aperture_scale=5", "render.samples_per_pixel=16", "render.photograph_samples_per_pixel=48",
       "render.all_in_focus_samples_per_pixel=1", "render.light_samples=16"});
}

}  // namespace dualpixel::evaluation
