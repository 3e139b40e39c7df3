#include "simulator/lens/aberrated/aberrated_json.h"

#include "simulator/lens/models.h"
#include "simulator/lens/split/split_json.h"

namespace dualpixel::simulator {

nlohmann::ordered_json aberrated_lens_json(const Lens& lens) {
  const auto& a = std::get<Aberrations>(lens.model);
  nlohmann::ordered_json j;
  j["version"] = 1;
  j["name"] = lens.name;
  j["source"] = lens.source;
  j["derived"] = lens.derived;
  j["model"] = name_of(kLensModels, lens.model.index());
  j["focal_length_mm"] = lens.thin.focal_length_m * 1e3;
  j["f_number"] = lens.thin.f_number;
  j["focusing"] = name_of(kFocusings, lens.thin.focusing);
  j["image_radius_mm"] = a.image_radius_mm;
  j["focus_um"] = a.focus_um;
  j["tangential_focus_um"] = a.tangential_focus_um.c;
  j["sagittal_focus_um"] = a.sagittal_focus_um.c;
  j["focus_um_per_diopter"] = a.focus_um_per_diopter;
  j["tangential_focus_um_per_diopter"] = a.tangential_focus_um_per_diopter.c;
  j["sagittal_focus_um_per_diopter"] = a.sagittal_focus_um_per_diopter.c;
  j["spherical_um"] = a.spherical_um;
  if (!a.coma_um.empty()) j["coma_um"] = a.coma_um;
  j["distortion"] = a.distortion.c;
  j["longitudinal_color_um"] = a.longitudinal_color_um;
  j["lateral_color"] = a.lateral_color;
  j["exit_pupil_mm"] = a.exit_pupil_mm;
  if (!a.exit_pupil_growth.c.empty()) j["exit_pupil_growth"] = a.exit_pupil_growth.c;
  j["tangential_pupil"] = a.tangential_pupil.c;
  j["sagittal_pupil"] = a.sagittal_pupil.c;
  j["rims"] = nlohmann::ordered_json::array();
  for (const Aberrations::Rim& rim : a.rims) j["rims"].push_back({{"radius", rim.radius}, {"shift", rim.shift}});
  j["falloff"] = name_of(kFalloffs, a.falloff);
  if (lens.diffraction) j["diffraction"] = true;
  if (lens.veiling_glare > 0) j["veiling_glare"] = lens.veiling_glare;
  j["split"] = split_json(lens.split);
  return j;
}

}  // namespace dualpixel::simulator
