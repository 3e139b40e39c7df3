#include "scenes/people/held/held_things.h"

#include <iterator>
#include <string>
#include <utility>

#include "scenes/people/held/things.h"

namespace dualpixel::scenes {
namespace {

/// In the order of Held; tags say "held:NAME".
constexpr struct {
  const char* name;
  void (*add)(Holding& hold, RandomStream& rng);
} kThings[] = {{"nothing", nullptr},
               {"phone", add_phone_or_tablet},
               {"cup", add_cup},
               {"bottle", add_bottle},
               {"book", add_book},
               {"bag", add_bag},
               {"bouquet", add_bouquet},
               {"ball", add_ball},
               {"animal", add_pet},
               {"tablet", add_phone_or_tablet},
               {"microphone", add_microphone},
               {"umbrella", add_umbrella},
               {"thing", add_generic_thing},
               {"glass", add_wine_glass},
               {"parcel", add_parcel}};
static_assert(std::size(kThings) == static_cast<std::size_t>(Held::parcel) + 1);

}  // namespace

void add_held_thing(SceneModel& scene, Figure& figure, RandomStream rng) {
  const Held held = figure.pose.held;
  if (held == Held::nothing) return;
  const auto& [name, add] = kThings[static_cast<std::size_t>(held)];
  figure.tags.push_back(std::string("held:") + name);
  const Skeleton& k = figure.skeleton;
  vec3 grip = k.hand[figure.pose.held_side].to_world({0, 0.02f, 0.035f});
  if (figure.pose.both_hands)
    grip = 0.5f * (k.hand[0].to_world({0, 0.03f, 0.03f}) + k.hand[1].to_world({0, 0.03f, 0.03f}));
  Holding hold{scene, figure, grip, k.chest.axes[2], {}, glossy_material(rng, 0.2f)};
  add(hold, rng);
  add_object(scene, figure, std::move(hold.object), hold.material);
}

}  // namespace dualpixel::scenes
