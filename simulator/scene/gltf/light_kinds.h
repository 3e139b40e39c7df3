#pragma once
#include "capture/names.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {

/// The types of light of KHR_lights_punctual.
inline constexpr Named<PunctualLight::Kind> kLightKinds[] = {
    {"point", PunctualLight::Kind::point, "the same in all directions"},
    {"spot", PunctualLight::Kind::spot, "within a cone"},
    {"directional", PunctualLight::Kind::directional, "from infinitely far"},
};

}  // namespace dualpixel::simulator
