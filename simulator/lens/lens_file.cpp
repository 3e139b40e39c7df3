#include "simulator/lens/lens_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "capture/path_beside.h"
#include "simulator/lens/models.h"
#include "simulator/lens/split/split_json.h"

namespace dualpixel::simulator {
namespace {

constexpr int kDeepestChain = 8;  ///< of files that name another: a circle of them ends somewhere

/// A half that no ray of the middle photosite reaches makes no view.
void check_split(const Fields& lens, const Lens& read) {
  const SplitPixel::Shares light = read.split.light(read.thin.rim_slope());
  if (light.left > 0 && light.right > 0) {
    if (read.split.alpha(read.thin.rim_slope()) > -1e-9) return;  // 0, but for rounding, of even halves
    lens.fail("split",
              "gives each view the light of the other half of the pupil (alpha below 0): exchange left and right");
  }
  lens.fail("split", fmt::format("lets no light of the lens's pupil into the {} half: must into both",
                                 light.left > 0    ? "right"
                                 : light.right > 0 ? "left"
                                                   : "left and the right"));
}

/// The model may be a lens file's, and the field the user's.
void refuse_fields_of_other_models(Fields& lens, const std::string& model) {
  constexpr std::pair<const char*, const char*> kOwners[] = {
      {"wavelengths_nm", "prescription"},
      {"band_samples", "prescription"},
      {"band_width_nm", "prescription"},
      {"exact_trace", "prescription"},
      {"surfaces", "prescription"},
      {"focus_um", "aberrated"},
      {"spherical_um", "aberrated"},
      {"coma_um", "aberrated"},
      {"distortion", "aberrated"},
      {"exit_pupil_mm", "aberrated"},
      {"rims", "aberrated"},
      {"falloff", "aberrated"},
      {"split_offset", "aberrated"},
      {"left_gain", "aberrated"},
      {"right_gain", "aberrated"},
  };
  for (const auto& [field, owner] : kOwners) {
    if (owner == model || !lens.has(field)) continue;
    lens.fail(field, fmt::format("is a field of the model '{}'; the lens's model is '{}'", owner, model));
  }
}

Lens read_fields(Fields lens, const std::string& file, double focus_distance_m) {
  Lens result;
  int version = 1;
  lens.integer("version", version, 1, 1);
  lens.text("name", result.name);
  lens.text("source", result.source);
  lens.text("derived", result.derived);
  std::size_t model = result.model.index();
  read_named(lens, "model", model, kLensModels);
  result.model = row_of(kLensModels, model).read(lens, file, focus_distance_m, result.thin);
  result.split = read_split(lens.object("split"));
  check_split(lens, result);
  lens.boolean("diffraction", result.diffraction);
  lens.number("veiling_glare", result.veiling_glare, 0, 0.5);
  refuse_fields_of_other_models(lens, row_of(kLensModels, model).name);
  lens.done();
  return result;
}

/// Where a lens's own fields stand.
struct Origin {
  const nlohmann::json& json;
  std::string file, pointer;
};

/// The lens that the field `file` names, with its own fields replaced by the other fields of `json`.
nlohmann::json merged_over_file(const nlohmann::json& json, const std::string& name, const std::string& path,
                                Fields& fields) {
  nlohmann::json merged = read_json_file(path);
  nlohmann::json own = json;
  own.erase("file");
  std::string model;
  fields.choice("model", model, names_of(kLensModels));
  if (merged.is_object() && !merged.contains("file") && own.contains("model") &&
      nlohmann::json(model) != merged.value("model", nlohmann::json(kLensModels[0].name))) {
    fields.fail("model", "differs from that of " + printable(name) + ": leave out what is not that lens's");
  }
  return lens_laid_over(std::move(merged), own);
}

/// `outermost` is the lens that named the first file, if one did: faults in its own fields are told of as its own.
Lens read_lens(const nlohmann::json& json, const std::string& file, const std::string& pointer, double focus_distance_m,
               int depth, const Origin* outermost) {
  Fields fields(json, file, pointer);
  if (outermost) fields.laid_over(outermost->json, outermost->file, outermost->pointer);
  if (!fields.has("file")) {
    Lens lens = read_fields(std::move(fields), file, focus_distance_m);
    lens.json = json.dump();
    return lens;
  }
  if (depth == kDeepestChain) {
    fields.fail("file", fmt::format("the {}th that names another: do they go round?", kDeepestChain));
  }
  std::string name;
  fields.text("file", name);
  const std::string path = path_beside(file, name);
  const Origin here{json, file, pointer};
  return read_lens(merged_over_file(json, name, path, fields), path, "", focus_distance_m, depth + 1,
                   outermost ? outermost : &here);
}

}  // namespace

nlohmann::json lens_laid_over(nlohmann::json base, const nlohmann::json& own) {
  if (base.is_object() && own.is_object() && own.contains("split") && own["split"].is_object() &&
      own["split"].contains("model")) {
    base.erase("split");
  }
  base.merge_patch(own);
  return base;
}

void apply_overrides(nlohmann::json& document, const std::vector<std::string>& assignments) {
  const auto last = std::find_if(assignments.rbegin(), assignments.rend(),
                                 [](const std::string& assignment) { return assignment.starts_with("lens.file="); });
  if (document.is_object() && last != assignments.rend() && *last != "lens.file=null") document.erase("lens");
  for (const std::string& assignment : assignments) apply_override(document, assignment);
}

Lens read_lens(const nlohmann::json& json, const std::string& file, const std::string& pointer,
               double focus_distance_m) {
  return read_lens(json, file, pointer, focus_distance_m, 0, nullptr);
}

Lens read_lens_file(const std::string& path, double focus_distance_m) {
  return read_lens(read_json_file(path), path, "", focus_distance_m);
}

}  // namespace dualpixel::simulator
