#pragma once
#include <vector>

#include "scenes/drawn/draw_scene.h"

/// The kinds of scene that can be drawn.
namespace dualpixel::scenes {

SceneKind portrait_kind();
SceneKind still_life_kind();
SceneKind outdoors_kind();
SceneKind room_kind();
SceneKind chart_kind();

/// All of them, in the order in which they are listed.
const std::vector<SceneKind>& scene_kinds();

/// The kind of that name. Throws InputError that lists them.
const SceneKind& scene_kind(const std::string& name);

}  // namespace dualpixel::scenes
