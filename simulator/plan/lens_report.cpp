#include "simulator/plan/lens_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/error.h"
#include "capture/option_ranges.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/lens/models.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/sampling/sobol.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {
namespace {

constexpr double kDegree = M_PI / 180;

/// Angles whose chief rays fall on evenly spread heights of the picture of infinity.
std::vector<double> field_angles(const LensSampler& sampler) {
  constexpr int kFields = 21;
  const Lens& lens = sampler.lens();
  const double breathing = lens.thin.image_distance_m() / lens.thin.focal_length_m;
  std::vector<double> theta;
  for (int k = 0; k < kFields; ++k) {
    const double height_m = 1e-3 * image_radius_mm(lens) * k / (kFields - 1) * breathing;
    theta.push_back(std::atan(sampler.chief_slope(height_m, 0).x));
  }
  return theta;
}

std::vector<CutPoint> cut(const LensSampler& sampler, bool horizontal) {
  constexpr int kPoints = 25;
  std::vector<CutPoint> points;
  const SensorGrid& sensor = sampler.sensor();
  for (int k = 0; k < kPoints; ++k) {
    const double field = -1 + 2.0 * k / (kPoints - 1);
    const double x = horizontal ? 0.5 * (field + 1) * (sensor.width_px - 1) : 0.5 * (sensor.width_px - 1);
    const double y = horizontal ? 0.5 * (sensor.height_px - 1) : 0.5 * (field + 1) * (sensor.height_px - 1);
    const DisparityCoefficients c =
        trace_disparity(sampler, static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
    const double slope_px_m = c.slope_dp_px_m * sensor.dp_downsample_x;
    points.push_back({field, c, c.blur_slope_px_m != 0 ? slope_px_m / c.blur_slope_px_m : 0});
  }
  return points;
}

std::vector<FastFormError> fast_form_errors(const Lens& lens, const SensorGrid& sensor) {
  Lens other = lens;
  bool& exact_trace = std::get<PrescriptionModel>(other.model).exact_trace;
  exact_trace = false;
  const LensSampler fast(other, sensor);
  exact_trace = true;
  const LensSampler exact(other, sensor);
  const double px_per_slope = lens.thin.image_distance_m() / sensor.pixel_pitch_m;
  std::vector<FastFormError> errors;
  alignas(64) float s[4][kPacket];
  LensPacket a, b;
  for (double field : {0.0, 0.25, 0.5, 0.7, 0.85, 0.99}) {
    const int x = std::min(static_cast<int>(0.5 * sensor.width_px * (1 + field)), sensor.width_px - 1);
    const int y = std::min(static_cast<int>(0.5 * sensor.height_px * (1 + field)), sensor.height_px - 1);
    FastFormError e;
    e.field = field;
    double both = 0, all = 0, square = 0;
    for (std::uint32_t first = 0; first < 4096; first += kPacket) {
      joint_samples(first, 1, s);
      fast.sample(x, y, 1, s, a);
      exact.sample(x, y, 1, s, b);
      for (int i = 0; i < kPacket; ++i) {
        const bool passes = a.left[i] + a.right[i] > 0, passes_too = b.left[i] + b.right[i] > 0;
        all += passes || passes_too ? 1 : 0;
        e.disagreeing += passes != passes_too ? 1 : 0;
        if (!passes || !passes_too) continue;
        const double error = std::hypot(a.slope_x[i] - b.slope_x[i], a.slope_y[i] - b.slope_y[i]) * px_per_slope;
        both += 1;
        square += error * error;
        e.largest_px = std::max(e.largest_px, error);
      }
    }
    e.rms_px = both > 0 ? std::sqrt(square / both) : 0;
    e.disagreeing = all > 0 ? e.disagreeing / all : 0;
    e.disparity_dp_px = trace_disparity(fast, x, y).intercept_dp_px - trace_disparity(exact, x, y).intercept_dp_px;
    errors.push_back(e);
  }
  return errors;
}

const char* model_name(const Lens& lens) { return name_of(kLensModels, lens.model.index()); }

nlohmann::ordered_json cut_json(const std::vector<CutPoint>& points) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const CutPoint& p : points) {
    rows.push_back({{"field", p.field},
                    {"slope_dp_px_m", p.coefficients.slope_dp_px_m},
                    {"intercept_dp_px", p.coefficients.intercept_dp_px},
                    {"alpha", p.alpha},
                    {"left_light", p.coefficients.left_light},
                    {"right_light", p.coefficients.right_light}});
  }
  return rows;
}

std::optional<OptionProblem> check_view(const LensView& view) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (view.focus_distance_m) {
    if (const auto why = out_of_range(*view.focus_distance_m, kNearestLensFocus_m, kInfinity)) {
      return OptionProblem{"focus_distance_m", *why};
    }
  }
  for (const auto& [name, side] : {std::pair{"width_px", view.width_px}, {"height_px", view.height_px}}) {
    if (!side) continue;
    if (const auto why = out_of_range(*side, kLensViewSide_px[0], kLensViewSide_px[1])) {
      return OptionProblem{name, *why};
    }
  }
  if (view.pixel_pitch_um) {
    if (const auto why = out_of_range(*view.pixel_pitch_um, kLensViewPitch_um[0], kLensViewPitch_um[1])) {
      return OptionProblem{"pixel_pitch_um", *why};
    }
  }
  return std::nullopt;
}

}  // namespace

SensorGrid sensor_for(const Lens& lens, int width_px, int height_px, double pixel_pitch_um) {
  constexpr double kPitchWithoutPicture_um = 1.4;
  double pitch_um = pixel_pitch_um;
  if (pitch_um == 0) {
    const double radius_mm = image_radius_mm(lens);
    pitch_um = radius_mm == 0 ? kPitchWithoutPicture_um : 2e3 * radius_mm / std::hypot(width_px, height_px);
  }
  return {width_px, height_px, pitch_um * 1e-6, {0.5 * width_px, 0.5 * height_px}};
}

LensReport report_lens(const Lens& lens, const SensorGrid& sensor) {
  LensReport report;
  report.lens = lens;
  report.sensor = sensor;
  const LensSampler sampler(lens, sensor);
  if (prescription_of(lens)) {
    const Lens at_infinity = refocused(lens, std::numeric_limits<double>::infinity());
    const Prescription& p = *prescription_of(at_infinity);
    report.warnings = overlaps(p);
    report.fields = analyze_fields(p, p.reference_nm, field_angles(sampler));
    for (const FieldAnalysis& f : report.fields) {
      report.field_of_radius.push_back(f.chief_height / p.image_radius_mm);
      if (!f.reached) report.warnings.push_back(fmt::format("no chief ray at {:.4g} degrees", f.theta_rad / kDegree));
    }
    report.fast_form = fast_form_errors(lens, sensor);
  }
  report.horizontal = cut(sampler, true);
  report.vertical = cut(sampler, false);
  return report;
}

LensReport report_lens(const nlohmann::json& json, const std::string& path, const LensView& view) {
  if (const auto problem = check_view(view)) {
    throw InputError(fmt::format("{}: {}: {}", printable(path), problem->field, problem->message));
  }
  const LensOfFile file = read_lens_of(json, path, view.focus_distance_m);
  constexpr int kWidth_px = 2688, kHeight_px = 2016;
  const int width_px = view.width_px.value_or(file.sensor ? file.sensor->width_px : kWidth_px);
  const int height_px = view.height_px.value_or(file.sensor ? file.sensor->height_px : kHeight_px);
  const double pitch_um = view.pixel_pitch_um.value_or(file.sensor ? file.sensor->pixel_pitch_um : 0.0);
  try {
    SensorGrid sensor = sensor_for(file.lens, width_px, height_px, pitch_um);
    if (file.sensor) sensor.dp_downsample_x = file.sensor->dp_downsample_x;
    return report_lens(file.lens, sensor);
  } catch (const InputError& error) {
    throw InputError(printable(path) + ": " + file.pointer + "/" + error.what());
  }
}

nlohmann::ordered_json to_json(const LensReport& report) {
  const Lens& lens = report.lens;
  const ThinLens& thin = lens.thin;
  nlohmann::ordered_json j = {{"name", lens.name},
                              {"source", lens.source},
                              {"derived", lens.derived},
                              {"model", model_name(lens)},
                              {"efl_mm", thin.focal_length_m * 1e3},
                              {"f_number", thin.f_number},
                              {"image_distance_mm", thin.image_distance_m() * 1e3}};
  j["focus_distance_m"] =
      std::isinf(thin.focus_distance_m) ? nlohmann::ordered_json("inf") : nlohmann::ordered_json(thin.focus_distance_m);
  j["alpha"] = lens.split.alpha(thin.rim_slope());
  j["sensor"] = {{"width_px", report.sensor.width_px},
                 {"height_px", report.sensor.height_px},
                 {"pixel_pitch_um", report.sensor.pixel_pitch_m * 1e6}};
  if (const Prescription* prescription = prescription_of(lens)) {
    const Paraxial p = paraxial(*prescription);
    j["paraxial"] = {{"efl_mm", p.focal_length},
                     {"bfl_mm", p.back_focus},
                     {"ffl_mm", p.front_focus},
                     {"f_number", p.f_number()},
                     {"petzval_radius_mm", p.petzval_radius},
                     {"entrance_pupil_z_mm", p.entrance_pupil_z},
                     {"entrance_pupil_diameter_mm", p.entrance_pupil_diameter},
                     {"exit_pupil_z_mm", p.exit_pupil_z},
                     {"exit_pupil_diameter_mm", p.exit_pupil_diameter}};
    j["fields"] = nlohmann::ordered_json::array();
    for (const FieldAnalysis& f : report.fields) {
      j["fields"].push_back({{"theta_deg", f.theta_rad / kDegree},
                             {"reached", f.reached},
                             {"chief_height_mm", f.chief_height},
                             {"distortion_percent", 100 * f.distortion},
                             {"chief_angle_deg", f.chief_angle_rad / kDegree},
                             {"tangential_focus_mm", f.tangential_focus},
                             {"sagittal_focus_mm", f.sagittal_focus},
                             {"pupil_fraction", f.pupil_fraction},
                             {"relative_illumination", f.relative_illumination},
                             {"cos4", f.cos4},
                             {"spot_rms_um", 1e3 * f.spot_rms},
                             {"rays_through", f.rays.through},
                             {"rays_clipped", f.rays.clipped},
                             {"rays_missed", f.rays.missed},
                             {"rays_reflected", f.rays.reflected}});
    }
    j["fast_form"] = nlohmann::ordered_json::array();
    for (const FastFormError& e : report.fast_form) {
      j["fast_form"].push_back({{"field", e.field},
                                {"ray_rms_px", e.rms_px},
                                {"ray_largest_px", e.largest_px},
                                {"disagreeing_share", e.disagreeing},
                                {"disparity_dp_px", e.disparity_dp_px}});
    }
  }
  j["calibration"] = {{"horizontal", cut_json(report.horizontal)}, {"vertical", cut_json(report.vertical)}};
  j["warnings"] = report.warnings;
  return j;
}

std::string to_text(const LensReport& report) {
  const Lens& lens = report.lens;
  const ThinLens& thin = lens.thin;
  std::string text =
      fmt::format("{}\nmodel {}, focal length {:.4f} mm, f/{:.3f}, focused at {:g} m, alpha {:.4f} on the axis\n",
                  printable(lens.name), model_name(lens), thin.focal_length_m * 1e3, thin.f_number,
                  thin.focus_distance_m, lens.split.alpha(thin.rim_slope()));
  if (!lens.source.empty()) text += "source: " + printable(lens.source, kLongestNoteBytes) + '\n';
  if (!lens.derived.empty()) text += "derived: " + printable(lens.derived, kLongestNoteBytes) + '\n';
  if (const Prescription* prescription = prescription_of(lens)) {
    const Paraxial p = paraxial(*prescription);
    text += fmt::format(
        "\nFirst order, mm: EFL {:.4f}  BFL {:.4f}  FFL {:.4f}  Petzval radius {:.3f}\n"
        "entrance pupil {:.4f} wide at z {:.4f}, exit pupil {:.4f} wide at z {:.4f} (z from the first vertex)\n\n"
        "Focused at infinity:\nfield   angle  height  distortion  chief ray   focus T   focus S   beam  light  cos^4  "
        "spot RMS\n"
        "            deg      mm           %        deg        um        um                           um\n",
        p.focal_length, p.back_focus, p.front_focus, p.petzval_radius, p.entrance_pupil_diameter, p.entrance_pupil_z,
        p.exit_pupil_diameter, p.exit_pupil_z);
    for (std::size_t k = 0; k < report.fields.size(); k += 2) {
      const FieldAnalysis& f = report.fields[k];
      text += fmt::format("{:5.2f}{:8.2f}{:8.3f}{:12.3f}{:11.2f}{:10.1f}{:10.1f}{:7.3f}{:7.3f}{:7.3f}{:10.2f}\n",
                          report.field_of_radius[k], f.theta_rad / kDegree, f.chief_height, 100 * f.distortion,
                          f.chief_angle_rad / kDegree, 1e3 * f.tangential_focus, 1e3 * f.sagittal_focus,
                          f.pupil_fraction, f.relative_illumination, f.cos4, 1e3 * f.spot_rms);
    }
    text += "\nPolynomials against the exact trace\nfield  ray RMS, px  largest  blocked apart  disparity, DP px\n";
    for (const FastFormError& e : report.fast_form) {
      text += fmt::format("{:5.2f}{:13.4f}{:9.3f}{:15.4f}{:18.5f}\n", e.field, e.rms_px, e.largest_px, e.disagreeing,
                          e.disparity_dp_px);
    }
  }
  text +=
      "\nDisparity = slope / depth + intercept, along the middle row\n"
      "field  slope, DP px m  intercept, DP px   alpha   left  right\n";
  for (std::size_t k = 0; k < report.horizontal.size(); k += 2) {
    const CutPoint& p = report.horizontal[k];
    text += fmt::format("{:5.2f}{:16.4f}{:18.4f}{:8.4f}{:7.3f}{:7.3f}\n", p.field, p.coefficients.slope_dp_px_m,
                        p.coefficients.intercept_dp_px, p.alpha, p.coefficients.left_light, p.coefficients.right_light);
  }
  for (const std::string& warning : report.warnings) text += "warning: " + warning + '\n';
  return text;
}

}  // namespace dualpixel::simulator
