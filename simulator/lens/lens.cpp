#include "simulator/lens/lens.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace dualpixel::simulator {

Lens refocused(Lens lens, double focus_distance_m) {
  if (lens.model == Lens::Model::prescription) {
    Prescription p = focused(*lens.prescription, focus_distance_m * 1e3);
    const Paraxial now = paraxial(p);
    lens.thin.focal_length_m = now.focal_length * 1e-3;
    lens.thin.f_number = now.f_number();
    lens.thin.pupil_magnification = now.focal_length / (now.entrance_pupil_z - now.front_focus);
    lens.prescription = std::make_shared<const Prescription>(std::move(p));
  }
  lens.thin.focus_distance_m = focus_distance_m;
  if (!(focus_distance_m * lens.thin.pupil_magnification > lens.thin.focal_length_m)) {
    throw std::invalid_argument(fmt::format("{} m: must be greater than the focal length, {:.6g} m", focus_distance_m,
                                            lens.thin.focal_length_m));
  }
  return lens;
}

}  // namespace dualpixel::simulator
