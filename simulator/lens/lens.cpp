#include "simulator/lens/lens.h"

namespace dualpixel::simulator {

Lens refocused(Lens lens, double focus_distance_m) {
  std::visit([&](auto& model) { model.refocus(focus_distance_m, lens.thin); }, lens.model);
  set_focus(lens.thin, focus_distance_m);
  return lens;
}

double image_radius_mm(const Lens& lens) {
  return std::visit([](const auto& model) { return model.radius_of_image_mm(); }, lens.model);
}

const Prescription* prescription_of(const Lens& lens) {
  const auto* model = std::get_if<PrescriptionModel>(&lens.model);
  return model ? model->prescription.get() : nullptr;
}

}  // namespace dualpixel::simulator
