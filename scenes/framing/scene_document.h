#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <string>

namespace dualpixel::scenes {

bool is_gltf(const std::string& path);

/// A scene file's JSON; of a glTF file, the smallest scene file that names it, as if it lay beside it. Throws
/// InputError.
nlohmann::json read_scene_document(const std::string& path);

/// Sets the document's camera, in place of a node of the glTF file.
void set_pose(nlohmann::json& scene_file, const std::array<double, 3>& position_m,
              const std::array<double, 3>& look_at_m);

/// To so few digits that the last bits of a ray do not show.
double short_number(double value);

}  // namespace dualpixel::scenes
