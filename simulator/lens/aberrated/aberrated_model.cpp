#include "simulator/lens/aberrated/aberrated_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "capture/path_beside.h"

namespace dualpixel::simulator {
namespace {

constexpr std::size_t kMostCoefficients = 10;

/// A number, or {"constant", "gradient", "map"}.
void read_field_map(Fields& parent, const std::string& key, FieldMap& map, double low, double high,
                    const std::string& file) {
  if (!parent.has(key)) return;
  if (!parent.raw(key).is_object()) {
    parent.number(key, map.constant, low, high);
    return;
  }
  Fields fields = parent.object(key);
  fields.number("constant", map.constant, low, high);
  double gradient[2] = {};
  fields.numbers("gradient", gradient, 2);
  map.gradient_x = gradient[0];
  map.gradient_y = gradient[1];
  if (fields.has("map")) {
    std::string name;
    fields.text("map", name);
    const Image image = read_image(path_beside(file, name));
    if (image.channels != 1) fields.fail("map", "must be a picture of one channel");
    map.columns = image.width;
    map.rows = image.height;
    map.cells = image.data;
    if (!std::all_of(map.cells.begin(), map.cells.end(), [](float v) { return std::isfinite(v); })) {
      fields.fail("map", "must be finite everywhere");
    }
  }
  fields.done();
}

/// 1 + the polynomial is a scale: it must stay positive and moderate up to h = `farthest`.
void check_scale(const Fields& lens, const char* key, const EvenPolynomial& p, double farthest) {
  for (int i = 0; i <= 100; ++i) {
    const double h = farthest * i / 100;
    const double value = 1 + p(h * h);
    if (!(value > 0.05 && value < 20)) {
      lens.fail(key, fmt::format("reaches {:.3g} at h = {:.2f}: 1 + it must lie in (0.05, 20)", value - 1, h));
    }
  }
}

/// Heights in the picture must grow with those in the scene up to the image circle, or the picture folds.
void check_distortion(const Fields& lens, const EvenPolynomial& p) {
  double before = -1;
  for (int i = 0; i <= 100; ++i) {
    const double h = i / 100.0, undistorted = h / (1 + p(h * h));
    if (undistorted <= before) {
      lens.fail("distortion", fmt::format("folds the picture at h = {:.2f}: h / (1 + it) must grow with h", h));
    }
    before = undistorted;
  }
}

}  // namespace

Aberrations Aberrations::read(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin) {
  read_thin_lens(lens, focus_distance_m, thin);
  Aberrations a;
  lens.number("image_radius_mm", a.image_radius_mm, 1e-3, 1e4);
  lens.number("focus_um", a.focus_um, -1e5, 1e5);
  const auto polynomial = [&](const char* key, EvenPolynomial& p, double bound) {
    lens.list(key, p.c, -bound, bound, kMostCoefficients);
  };
  polynomial("tangential_focus_um", a.tangential_focus_um, 1e9);
  polynomial("sagittal_focus_um", a.sagittal_focus_um, 1e9);
  lens.number("focus_um_per_diopter", a.focus_um_per_diopter, -1e5, 1e5);
  polynomial("tangential_focus_um_per_diopter", a.tangential_focus_um_per_diopter, 1e9);
  polynomial("sagittal_focus_um_per_diopter", a.sagittal_focus_um_per_diopter, 1e9);
  lens.list("spherical_um", a.spherical_um, -1e4, 1e4, kMostCoefficients);
  lens.list("coma_um", a.coma_um, -1e4, 1e4, kMostCoefficients);
  polynomial("distortion", a.distortion, 1e4);
  lens.numbers("longitudinal_color_um", a.longitudinal_color_um.data(), 2);
  lens.numbers("lateral_color", a.lateral_color.data(), 2);
  for (double value : a.lateral_color) {
    if (!(std::abs(value) < 0.5)) lens.fail("lateral_color", fmt::format("{}: must lie in (-0.5, 0.5)", value));
  }
  lens.number("exit_pupil_mm", a.exit_pupil_mm, 0, 1e6);
  polynomial("exit_pupil_growth", a.exit_pupil_growth, 1e4);
  polynomial("tangential_pupil", a.tangential_pupil, 1e4);
  polynomial("sagittal_pupil", a.sagittal_pupil, 1e4);
  for (Fields& fields : lens.objects("rims")) {
    Aberrations::Rim& rim = a.rims.emplace_back();
    fields.number("radius", rim.radius, 0.01, 100);
    fields.number("shift", rim.shift, -100, 100);
    fields.done();
  }
  read_named(lens, "falloff", a.falloff, kFalloffs);
  read_field_map(lens, "split_offset", a.split_offset, -1, 1, file);
  read_field_map(lens, "left_gain", a.left_gain, 0, 1, file);
  read_field_map(lens, "right_gain", a.right_gain, 0, 1, file);
  // the distortion is followed a little beyond the image circle, where chief rays are searched
  check_scale(lens, "distortion", a.distortion, 1.25);
  check_distortion(lens, a.distortion);
  check_scale(lens, "exit_pupil_growth", a.exit_pupil_growth, 1);
  check_scale(lens, "tangential_pupil", a.tangential_pupil, 1);
  check_scale(lens, "sagittal_pupil", a.sagittal_pupil, 1);
  return a;
}

}  // namespace dualpixel::simulator
