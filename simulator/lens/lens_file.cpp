#include "simulator/lens/lens_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"

namespace dualpixel::simulator {
namespace {

constexpr std::size_t kMostCoefficients = 10;

std::string beside(const std::string& json_path, const std::string& name) {
  return (std::filesystem::path(json_path).parent_path() / name).string();
}

SplitPixel read_split(Fields fields) {
  SplitPixel split;
  std::string kind = "ramp";
  fields.choice("model", kind, {"hard", "ramp", "microlens", "table"});
  if (kind == "hard") {
    split.kind = SplitPixel::Kind::hard;
  } else if (kind == "ramp") {
    fields.number("k", split.k, 1, 1e6);
  } else if (kind == "microlens") {
    split.kind = SplitPixel::Kind::microlens;
    SplitPixel::Microlens& m = split.microlens;
    fields.number("focal_length_px", m.focal_length, 0.05, 1e3);
    fields.number("height_px", m.height, 0, 1e3);
    fields.number("diode_width_px", m.diode_width, 0.01, 10);
    fields.number("radius_px", m.radius, 0.01, 10);
    fields.number("shift_px", m.shift, -10, 10);
    fields.number("design_exit_pupil_mm", m.design_exit_pupil_mm, 0, 1e6);
  } else {
    split.kind = SplitPixel::Kind::table;
    SplitPixel::Table& table = split.table;
    fields.required("p").list("p", table.p, -4, 4, 4096);
    fields.required("left").list("left", table.left, 0, 1, 4096);
    fields.required("right").list("right", table.right, 0, 1, 4096);
    if (table.p.size() < 2 || table.p.front() > -1 || table.p.back() < 1 ||
        std::adjacent_find(table.p.begin(), table.p.end(), std::greater_equal<>()) != table.p.end()) {
      fields.fail("p", "must ascend from -1 or less to 1 or more");
    }
    if (table.left.size() != table.p.size()) fields.fail("left", "must have as many numbers as p");
    if (table.right.size() != table.p.size()) fields.fail("right", "must have as many numbers as p");
    double left_sum = 0, right_sum = 0;
    for (std::size_t i = 0; i < table.p.size(); ++i) {
      if (table.left[i] + table.right[i] > 1 + 1e-9) fields.fail("right", "left + right must not exceed 1");
      left_sum += table.left[i];
      right_sum += table.right[i];
    }
    if (left_sum == 0) fields.fail("left", "must not be 0 throughout");
    if (right_sum == 0) fields.fail("right", "must not be 0 throughout");
  }
  fields.number("crosstalk", split.crosstalk, 0, 0.5);
  fields.done();
  return split;
}

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
    const Image image = read_image(beside(file, name));
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

Aberrations read_aberrations(Fields& lens, const std::string& file) {
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
  polynomial("distortion", a.distortion, 1e4);
  lens.numbers("longitudinal_color_um", a.longitudinal_color_um.data(), 2);
  lens.numbers("lateral_color", a.lateral_color.data(), 2);
  for (double value : a.lateral_color) {
    if (!(std::abs(value) < 0.5)) lens.fail("lateral_color", fmt::format("{}: must lie in (-0.5, 0.5)", value));
  }
  lens.number("exit_pupil_mm", a.exit_pupil_mm, 0, 1e6);
  polynomial("tangential_pupil", a.tangential_pupil, 1e4);
  polynomial("sagittal_pupil", a.sagittal_pupil, 1e4);
  for (Fields& fields : lens.objects("rims")) {
    Aberrations::Rim& rim = a.rims.emplace_back();
    fields.number("radius", rim.radius, 0.01, 100);
    fields.number("shift", rim.shift, -100, 100);
    fields.done();
  }
  std::string falloff = "none";
  lens.choice("falloff", falloff, {"none", "cos4", "disc"});
  a.falloff = falloff == "none"   ? Aberrations::Falloff::none
              : falloff == "cos4" ? Aberrations::Falloff::cos4
                                  : Aberrations::Falloff::disc;
  read_field_map(lens, "split_offset", a.split_offset, -1, 1, file);
  read_field_map(lens, "left_gain", a.left_gain, 0, 1, file);
  read_field_map(lens, "right_gain", a.right_gain, 0, 1, file);
  for (const char* key : {"distortion", "tangential_pupil", "sagittal_pupil"}) {
    const EvenPolynomial& p = key == std::string("distortion")         ? a.distortion
                              : key == std::string("tangential_pupil") ? a.tangential_pupil
                                                                       : a.sagittal_pupil;
    for (int i = 0; i <= 100; ++i) {
      const double h = (key == std::string("distortion") ? 1.25 : 1.0) * i / 100;
      const double value = 1 + p(h * h);
      if (!(value > 0.05 && value < 20)) {
        lens.fail(key, fmt::format("reaches {:.3g} at h = {:.2f}: 1 + it must lie in (0.05, 20)", value - 1, h));
      }
    }
  }
  return a;
}

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
  bool disperses = false;
  std::vector<Fields> surfaces = lens.required("surfaces").objects("surfaces");
  if (surfaces.empty() || surfaces.size() > 200) lens.fail("surfaces", "must be 1 to 200 surfaces");
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

void read_thin(Fields& lens, double focus_distance_m, ThinLens& thin) {
  double focal_length_mm = 4.442;
  thin.f_number = 1.8;
  std::string focusing = "move";
  lens.number("focal_length_mm", focal_length_mm, 0.1, 10000);
  lens.number("f_number", thin.f_number, 0.1, 1000);
  lens.choice("focusing", focusing, {"move", "power"});
  thin.focal_length_m = focal_length_mm * 1e-3;
  thin.focusing = focusing == "move" ? ThinLens::Focusing::move : ThinLens::Focusing::power;
  if (!(focus_distance_m > thin.focal_length_m)) {
    lens.fail("focal_length_mm", fmt::format("{}: the focal length must be below focus_distance_m, {} m",
                                             focal_length_mm, focus_distance_m));
  }
  thin.focus_distance_m = focus_distance_m;
}

void read_prescribed(Fields& lens, double focus_distance_m, Lens& result) {
  Prescription p = read_prescription(lens);
  lens.boolean("exact_trace", result.exact_trace);
  double f_number = paraxial(p).f_number();
  if (lens.has("f_number")) {
    lens.number("f_number", f_number, 0.1, 1000);
    try {
      p = stopped_down(p, f_number);
    } catch (const std::invalid_argument& error) {
      lens.fail("f_number", fmt::format("{}: {}", f_number, error.what()));
    }
  }
  const Paraxial open = paraxial(p);
  const double nearest_m = 2e-3 * open.focal_length;
  if (!(focus_distance_m > nearest_m)) {
    lens.fail("surfaces", fmt::format("focus distance {} m: must be above twice the focal length, {:.4g} m",
                                      focus_distance_m, nearest_m));
  }
  result.prescription = std::make_shared<const Prescription>(std::move(p));
  try {
    result = refocused(std::move(result), focus_distance_m);
  } catch (const std::invalid_argument& error) {
    lens.fail("focus_gap", error.what());
  }
}

Lens read_fields(Fields lens, const std::string& file, double focus_distance_m) {
  Lens result;
  int version = 1;
  lens.integer("version", version, 1, 1);
  lens.text("name", result.name);
  lens.text("source", result.source);
  lens.text("derived", result.derived);
  std::string model = "thin";
  lens.choice("model", model, {"thin", "aberrated", "prescription"});
  if (model == "prescription") {
    result.model = Lens::Model::prescription;
    read_prescribed(lens, focus_distance_m, result);
  } else {
    read_thin(lens, focus_distance_m, result.thin);
    if (model == "aberrated") {
      result.model = Lens::Model::aberrated;
      result.aberrations = read_aberrations(lens, file);
    }
  }
  result.split = read_split(lens.object("split"));
  lens.done();
  return result;
}

}  // namespace

namespace {

/// `depth` of files that name another: a circle of them ends somewhere.
Lens read_lens(const nlohmann::json& json, const std::string& file, const std::string& pointer, double focus_distance_m,
               int depth) {
  Fields fields(json, file, pointer);
  if (!fields.has("file")) return read_fields(std::move(fields), file, focus_distance_m);
  constexpr int kDeepest = 8;
  if (depth == kDeepest) fields.fail("file", fmt::format("the {}th that names another: do they go round?", kDeepest));
  std::string name;
  fields.text("file", name);
  const std::string path = beside(file, name);
  nlohmann::json merged = read_json_file(path);
  nlohmann::json own = json;
  own.erase("file");
  if (merged.is_object() && !merged.contains("file") && own.contains("model") &&
      own["model"] != merged.value("model", nlohmann::json("thin"))) {
    fields.fail("model", "differs from that of " + printable(name) + ": leave out what is not that lens's");
  }
  if (merged.is_object() && merged.contains("split") && own.contains("split") && own["split"].is_object() &&
      own["split"].contains("model")) {
    merged.erase("split");  // another model of split: none of the file's figures belong to it
  }
  merged.merge_patch(own);
  return read_lens(merged, path, "", focus_distance_m, depth + 1);
}

}  // namespace

Lens read_lens(const nlohmann::json& json, const std::string& file, const std::string& pointer,
               double focus_distance_m) {
  return read_lens(json, file, pointer, focus_distance_m, 0);
}

Lens read_lens_file(const std::string& path, double focus_distance_m) {
  return read_lens(read_json_file(path), path, "", focus_distance_m);
}

nlohmann::ordered_json aberrated_lens_json(const Lens& lens) {
  const Aberrations& a = lens.aberrations;
  nlohmann::ordered_json j;
  j["version"] = 1;
  j["name"] = lens.name;
  j["source"] = lens.source;
  j["derived"] = lens.derived;
  j["model"] = "aberrated";
  j["focal_length_mm"] = lens.thin.focal_length_m * 1e3;
  j["f_number"] = lens.thin.f_number;
  j["focusing"] = lens.thin.focusing == ThinLens::Focusing::move ? "move" : "power";
  j["image_radius_mm"] = a.image_radius_mm;
  j["focus_um"] = a.focus_um;
  j["tangential_focus_um"] = a.tangential_focus_um.c;
  j["sagittal_focus_um"] = a.sagittal_focus_um.c;
  j["focus_um_per_diopter"] = a.focus_um_per_diopter;
  j["tangential_focus_um_per_diopter"] = a.tangential_focus_um_per_diopter.c;
  j["sagittal_focus_um_per_diopter"] = a.sagittal_focus_um_per_diopter.c;
  j["spherical_um"] = a.spherical_um;
  j["distortion"] = a.distortion.c;
  j["longitudinal_color_um"] = a.longitudinal_color_um;
  j["lateral_color"] = a.lateral_color;
  j["exit_pupil_mm"] = a.exit_pupil_mm;
  j["tangential_pupil"] = a.tangential_pupil.c;
  j["sagittal_pupil"] = a.sagittal_pupil.c;
  j["rims"] = nlohmann::ordered_json::array();
  for (const Aberrations::Rim& rim : a.rims) j["rims"].push_back({{"radius", rim.radius}, {"shift", rim.shift}});
  j["falloff"] = a.falloff == Aberrations::Falloff::none   ? "none"
                 : a.falloff == Aberrations::Falloff::cos4 ? "cos4"
                                                           : "disc";
  const SplitPixel& s = lens.split;
  switch (s.kind) {
    case SplitPixel::Kind::hard:
      j["split"] = {{"model", "hard"}};
      break;
    case SplitPixel::Kind::ramp:
      j["split"] = {{"model", "ramp"}, {"k", s.k}};
      break;
    case SplitPixel::Kind::microlens:
      j["split"] = {{"model", "microlens"},
                    {"focal_length_px", s.microlens.focal_length},
                    {"height_px", s.microlens.height},
                    {"diode_width_px", s.microlens.diode_width},
                    {"radius_px", s.microlens.radius},
                    {"shift_px", s.microlens.shift},
                    {"design_exit_pupil_mm", s.microlens.design_exit_pupil_mm}};
      break;
    case SplitPixel::Kind::table:
      j["split"] = {{"model", "table"}, {"p", s.table.p}, {"left", s.table.left}, {"right", s.table.right}};
      break;
  }
  if (s.crosstalk != 0) j["split"]["crosstalk"] = s.crosstalk;
  return j;
}

}  // namespace dualpixel::simulator
