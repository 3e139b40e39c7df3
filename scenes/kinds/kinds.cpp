#include "scenes/kinds/kinds.h"

#include "capture/names.h"

namespace dualpixel::scenes {

const std::vector<SceneKind>& scene_kinds() {
  static const std::vector<SceneKind> kinds = {portrait_kind(), still_life_kind(), outdoors_kind(), room_kind(),
                                               chart_kind()};
  return kinds;
}

const SceneKind& scene_kind(const std::string& name) {
  const SceneKind* kind = find_named(scene_kinds(), name);
  if (kind == nullptr) refuse_name("scene kind", name, names_of(scene_kinds()));
  return *kind;
}

}  // namespace dualpixel::scenes
