#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "simulator/lens/lens.h"

/// Lenses as JSON: lens_models/README.md explains every field, lens_models/lens.schema.json is the same for programs.
namespace dualpixel::simulator {

/// Reads a lens from `json`, which came from `file` at `pointer`, and focuses it on `focus_distance_m` from its
/// entrance pupil. With a field `file`, that file (relative to `file`) is read and the other fields replace
/// its own. Throws InputError: unknown fields, values out of range, a focus or f-number out of the lens's reach.
Lens read_lens(const nlohmann::json& json, const std::string& file, const std::string& pointer,
               double focus_distance_m);

/// The lens `base` with the fields of `own` laid over it, at any depth. A split of another model takes nothing from the
/// base's.
nlohmann::json lens_laid_over(nlohmann::json base, const nlohmann::json& own);

/// Applies the assignments of `--set` (apply_override) to a scene's document. One of `lens.file` names the whole lens:
/// the document's own goes first, whatever is set of the lens stays.
void apply_overrides(nlohmann::json& document, const std::vector<std::string>& assignments);

/// A lens file.
Lens read_lens_file(const std::string& path, double focus_distance_m);

}  // namespace dualpixel::simulator
