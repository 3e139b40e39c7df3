#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "simulator/ready_scene.h"

namespace dualpixel::scenes {

/// The document with numbers in place of what depends on what the camera sees:
///   model_scale                a factor that becomes model_size_m, the scene's longest side
///   camera.focus_distance_m    "auto": the surface in the middle of the picture, or the nearest to it
///   camera.focus_at_px         [x, y] in photosites: the surface there
///   camera.focus_node          the median depth of what is seen of this glTF node's mesh
/// Of a glTF file (is_gltf(path)) what is left out is chosen, too: a sky for a light, a camera that sees the whole
/// scene unless the file has one, focus "auto", and an exposure that makes the mean of the green signal 0.18 of white.
/// Nothing is loaded where the document has none of these; else `ready` is the scene that was. Throws InputError.
/// `warnings` gets a line where that mean is missed.
nlohmann::json resolve_scene(nlohmann::json document, const std::string& path,
                             std::unique_ptr<simulator::ReadyScene>& ready, std::vector<std::string>& warnings);

}  // namespace dualpixel::scenes
