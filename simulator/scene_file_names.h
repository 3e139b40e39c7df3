#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace dualpixel::simulator {

using FileNameVisitor = std::function<void(std::string& name)>;

/// Calls `visit` with each name of a file that a scene file's document gives, or a part of one: glTF, camera, lens and
/// what that names, environment, the photograph's lens. Names may be changed. What is no text is passed over.
void each_file_name(nlohmann::json& scene, const FileNameVisitor& visit);

/// Those of its object "lens": files, and maps over the field.
void each_file_name_of_lens(nlohmann::json& lens, const FileNameVisitor& visit);

}  // namespace dualpixel::simulator
