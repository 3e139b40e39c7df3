#include "simulator/lens/prescription/prescription_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/prescription/prescription.h"

namespace dualpixel::simulator {
namespace {

Glass read_glass(Fields fields, bool& disperses) {
  Glass glass;
  std::string name;
  fields.text("name", name);
  std::vector<double> values;
  if (fields.has("sellmeier")) {
    fields.list("sellmeier", values, -1e4, 1e4, 6);
    if (values.size() != 6) fields.fail("sellmeier", "must be K1, K2, K3, L1, L2, L3");
    glass.kind = Glass::Kind::sellmeier;
  } else if (fields.has("schott")) {
    fields.list("schott", values, -1e4, 1e4, 6);
    if (values.size() != 6) fields.fail("schott", "must be a0 ... a5");
    glass.kind = Glass::Kind::schott;
  } else {
    values = {1, 0};
    fields.required("nd").number("nd", values[0], 1, 5);
    fields.number("vd", values[1], 5, 200);
    glass.kind = Glass::Kind::abbe;
  }
  std::copy(values.begin(), values.end(), glass.values.begin());
  for (double nm : {350.0, 587.5618, 1100.0}) {
    const double n = refractive_index(glass, nm);
    if (!(n >= 1 && n < 6)) {
      fields.fail(glass.kind == Glass::Kind::schott      ? "schott"
                  : glass.kind == Glass::Kind::sellmeier ? "sellmeier"
                                                         : "nd",
                  fmt::format("gives an index of {:.4g} at {} nm: must lie in [1, 6)", n, nm));
    }
  }
  disperses = disperses || refractive_index(glass, 480) != refractive_index(glass, 640);
  fields.done();
  return glass;
}

LensSurface read_surface(Fields& fields, bool& disperses) {
  LensSurface s;
  fields.boolean("stop", s.stop);
  if (!fields.required("radius_mm").raw("radius_mm").is_null()) {
    double radius_mm = 0;
    fields.number("radius_mm", radius_mm, -1e7, 1e7);
    if (std::abs(radius_mm) < 1e-3)
      fields.fail("radius_mm", fmt::format("{}: must be null (a plane) or 0.001 and more", radius_mm));
    s.curvature_per_mm = 1 / radius_mm;
  }
  fields.number("conic", s.conic, -1e6, 1e6);
  if (fields.has("asphere")) {
    Fields terms = fields.object("asphere");
    for (int power = 2; power <= 30; ++power) {
      const std::string key = std::to_string(power);
      if (!terms.has(key)) continue;
      double a = 0;
      terms.number(key, a, -1e12, 1e12);
      s.terms.emplace_back(power, a);
    }
    terms.done();
  }
  fields.required("thickness_mm").number("thickness_mm", s.thickness_mm, -1e4, 1e4);
  if (fields.has("glass")) s.after = read_glass(fields.object("glass"), disperses);
  fields.required("semi_diameter_mm").number("semi_diameter_mm", s.semi_diameter_mm, 1e-4, 1e4);
  const double limit = (1 + s.conic) * s.curvature_per_mm * s.curvature_per_mm;
  if (limit * s.semi_diameter_mm * s.semi_diameter_mm >= 1) {
    fields.fail("semi_diameter_mm",
                fmt::format("{}: the surface ends at radius {:.6g} mm", s.semi_diameter_mm, 1 / std::sqrt(limit)));
  }
  fields.done();
  return s;
}

Prescription read_prescription(Fields& lens) {
  Prescription p;
  lens.required("image_radius_mm").number("image_radius_mm", p.image_radius_mm, 1e-3, 1e4);
  lens.number("reference_nm", p.reference_nm, 350, 1100);
  p.wavelengths_nm.fill(p.reference_nm);
  lens.numbers("wavelengths_nm", p.wavelengths_nm.data(), 3);
  for (double nm : p.wavelengths_nm) {
    if (!(nm >= 350 && nm <= 1100)) lens.fail("wavelengths_nm", fmt::format("{}: must lie in [350, 1100]", nm));
  }
  lens.integer("band_samples", p.band_samples, 1, 9);
  if (p.band_samples % 2 == 0) lens.fail("band_samples", fmt::format("{}: must be odd", p.band_samples));
  if (p.band_samples > 1 && !p.has_color()) {
    lens.fail("band_samples", fmt::format("{}: must be 1 where wavelengths_nm are one: all light is of that wavelength",
                                          p.band_samples));
  }
  lens.number("band_width_nm", p.band_width_nm, 1, 200);
  for (int color = 0; color < 3; ++color) {
    for (const int i : {0, p.band_samples - 1}) {
      const double nm = p.wavelength_nm(color, i);
      if (!(nm >= 350 && nm <= 1100)) {
        lens.fail("band_width_nm", fmt::format("{}: takes {:.4g} nm: must lie in [350, 1100]", p.band_width_nm, nm));
      }
    }
  }
  bool disperses = false;
  std::vector<Fields> surfaces = lens.required("surfaces").objects("surfaces");
  if (surfaces.empty() || surfaces.size() > 200) {
    lens.fail("surfaces", fmt::format("{} surfaces: must be 1 to 200", surfaces.size()));
  }
  for (Fields& fields : surfaces) p.surfaces.push_back(read_surface(fields, disperses));
  if (!disperses) p.wavelengths_nm.fill(p.reference_nm);
  const auto stops = std::count_if(p.surfaces.begin(), p.surfaces.end(), [](const LensSurface& s) { return s.stop; });
  if (stops != 1) lens.fail("surfaces", fmt::format("{} of them have \"stop\": true: must be one", stops));
  if (p.surfaces.back().after.kind != Glass::Kind::fixed) lens.fail("surfaces", "the last one must end in air");
  if (!(p.surfaces.back().thickness_mm > 0))
    lens.fail("surfaces", "the last thickness, to the sensor, must be above 0");
  lens.integer("focus_gap", p.focus_gap, 0, static_cast<int>(p.surfaces.size()) - 1);
  const Paraxial first_order = paraxial(p);
  if (!(first_order.focal_length > 0 && std::isfinite(first_order.focal_length) && first_order.back_focus > 0)) {
    lens.fail("surfaces", fmt::format("focal length {:.6g} mm, back focus {:.6g} mm: both must be above 0",
                                      first_order.focal_length, first_order.back_focus));
  }
  return p;
}

}  // namespace

PrescriptionModel PrescriptionModel::read(Fields& lens, const std::string&, double focus_distance_m, ThinLens& thin) {
  Prescription p = read_prescription(lens);
  PrescriptionModel model;
  lens.boolean("exact_trace", model.exact_trace);
  if (lens.has("f_number")) {
    double f_number = 0;
    lens.number("f_number", f_number, 0.1, 1000);
    if (const auto why = check_f_number(p, f_number)) lens.fail("f_number", *why);
    p = stopped_down(p, f_number);
  }
  const double nearest_m = 2e-3 * paraxial(p).focal_length;
  if (!(focus_distance_m > nearest_m)) {
    lens.fail("surfaces", fmt::format("focus distance {} m: must be above twice the focal length, {:.4g} m",
                                      focus_distance_m, nearest_m));
  }
  model.prescription = std::make_shared<const Prescription>(std::move(p));
  try {
    model.refocus(focus_distance_m, thin);
    set_focus(thin, focus_distance_m);
  } catch (const InputError& error) {
    lens.fail("focus_gap", error.what());
  }
  return model;
}

double PrescriptionModel::radius_of_image_mm() const { return prescription->image_radius_mm; }

void PrescriptionModel::refocus(double focus_distance_m, ThinLens& thin) {
  Prescription p = focused(*prescription, focus_distance_m * 1e3);
  const Paraxial now = paraxial(p);
  thin.focal_length_m = now.focal_length * 1e-3;
  thin.f_number = now.f_number();
  thin.pupil_magnification = now.focal_length / (now.entrance_pupil_z - now.front_focus);
  prescription = std::make_shared<const Prescription>(std::move(p));
}

}  // namespace dualpixel::simulator
