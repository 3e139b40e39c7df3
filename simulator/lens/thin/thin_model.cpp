#include "simulator/lens/thin/thin_model.h"

#include <fmt/format.h>

#include "capture/error.h"
#include "capture/json_fields.h"

namespace dualpixel::simulator {

ThinModel ThinModel::read(Fields& lens, const std::string&, double focus_distance_m, ThinLens& thin) {
  read_thin_lens(lens, focus_distance_m, thin);
  return {};
}

void read_thin_lens(Fields& lens, double focus_distance_m, ThinLens& thin) {
  double focal_length_mm = 4.442;
  thin.f_number = 1.8;
  lens.number("focal_length_mm", focal_length_mm, 0.1, 10000);
  lens.number("f_number", thin.f_number, 0.1, 1000);
  read_named(lens, "focusing", thin.focusing, kFocusings);
  thin.focal_length_m = focal_length_mm * 1e-3;
  if (!(focus_distance_m > thin.focal_length_m)) {
    lens.fail("focal_length_mm", fmt::format("{}: the focal length must be below focus_distance_m, {} m",
                                             focal_length_mm, focus_distance_m));
  }
  thin.focus_distance_m = focus_distance_m;
}

void set_focus(ThinLens& thin, double focus_distance_m) {
  thin.focus_distance_m = focus_distance_m;
  if (!(focus_distance_m * thin.pupil_magnification > thin.focal_length_m)) {
    throw InputError(fmt::format("focus_distance_m: {}: must be greater than the focal length, {:.6g} m",
                                 focus_distance_m, thin.focal_length_m));
  }
}

}  // namespace dualpixel::simulator
