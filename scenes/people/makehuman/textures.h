#pragma once
#include <memory>
#include <string>

#include "scenes/procedural/signed_distance.h"
#include "simulator/scene/scene.h"

namespace dualpixel::scenes {

/// A picture as a texture; `mean`: of its opaque texels, linear.
std::shared_ptr<const simulator::Texture> read_texture(const std::string& path, vec3& mean);

/// The texture that a .mhmat file names; null where either is missing.
std::shared_ptr<const simulator::Texture> material_texture(const std::string& path, vec3& mean);

}  // namespace dualpixel::scenes
