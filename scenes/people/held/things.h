#pragma once
#include "scenes/people/body/figure.h"

/// One function for each thing that a person may hold; held_things.cpp lists them.
namespace dualpixel::scenes {

/// What is being made and where. A function adds to `object` and changes `material`, which are added to the scene after
/// it; what has several materials it adds itself.
struct Holding {
  SceneModel& scene;
  const Figure& figure;
  vec3 grip;     ///< in the palm, or between both hands
  vec3 forward;  ///< of the chest
  SceneObject object;
  Material material;

  const Frame& hand() const { return figure.skeleton.hand[figure.pose.held_side]; }
};
inline const vec3 kUp(0, 1, 0);

/// A shiny material of random colors.
Material glossy_material(RandomStream& rng, float gloss);

void add_phone_or_tablet(Holding& hold, RandomStream& rng);
void add_cup(Holding& hold, RandomStream& rng);
void add_bottle(Holding& hold, RandomStream& rng);
void add_book(Holding& hold, RandomStream& rng);
void add_ball(Holding& hold, RandomStream& rng);
void add_microphone(Holding& hold, RandomStream& rng);
void add_umbrella(Holding& hold, RandomStream& rng);
void add_wine_glass(Holding& hold, RandomStream& rng);
void add_parcel(Holding& hold, RandomStream& rng);
void add_bag(Holding& hold, RandomStream& rng);
void add_bouquet(Holding& hold, RandomStream& rng);
void add_pet(Holding& hold, RandomStream& rng);
void add_generic_thing(Holding& hold, RandomStream& rng);

}  // namespace dualpixel::scenes
