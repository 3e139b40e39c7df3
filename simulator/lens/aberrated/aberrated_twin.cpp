#include "simulator/lens/aberrated/aberrated_twin.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "capture/error.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"

namespace dualpixel::simulator {
namespace {

constexpr int kNodes = 33;  ///< distances from the axis at which the lens is traced
constexpr int kSamples = 2048;

/// Least squares of values at h by sum c_i h^(2 i + 2).
EvenPolynomial fit_even(const std::vector<double>& h, const std::vector<double>& values, int terms) {
  Eigen::MatrixXd a(h.size(), terms);
  Eigen::VectorXd b(h.size());
  for (std::size_t row = 0; row < h.size(); ++row) {
    for (int i = 0; i < terms; ++i) a(row, i) = std::pow(h[row], 2 * i + 2);
    b[row] = values[row];
  }
  const Eigen::VectorXd c = a.colPivHouseholderQr().solve(b);
  return {{c.data(), c.data() + c.size()}};
}

/// A ray of the bundle that reaches (0, r) of the sensor, as the ideal lens would name it.
struct BundleRay {
  double p_t, p_s;  ///< in the stop, p_t away from the axis in camera axes
  double image_t;   ///< where it belongs on an ideal sensor, mm, away from the axis
  double image_s;
};

/// The rays that pass from r in one color.
std::vector<BundleRay> trace_bundle(const TracedLens<double>& traced, const PupilEllipse& ellipse, double r_mm,
                                    double pupil_z_mm, const ThinLens& thin) {
  constexpr int kSide = 64, kLanes = 16;
  std::vector<BundleRay> bundle;
  RayBatch<double, kLanes> rays;
  const double scale_mm = thin.image_distance_m() * 1e3;
  for (int first = 0; first < kSide * kSide; first += kLanes) {
    for (int i = 0; i < kLanes; ++i) {
      const int row = (first + i) / kSide;
      const double x = (2 * ((first + i) % kSide) + 1.0) / kSide - 1, y = (2 * row + 1.0) / kSide - 1;
      rays.x[i] = 0, rays.y[i] = r_mm, rays.z[i] = traced.sensor_z_mm();
      rays.l[i] = ellipse.half_l * x;
      rays.m[i] = ellipse.center_m + ellipse.half_m * y;
      const double rest = 1 - rays.l[i] * rays.l[i] - rays.m[i] * rays.m[i];
      rays.n[i] = -std::sqrt(std::max(rest, 1e-9));
      rays.end[i] = rest > 1e-6 && x * x + y * y <= 1 ? 0 : 1;
    }
    traced.trace(rays);
    move_to_plane(rays, pupil_z_mm);
    for (int i = 0; i < kLanes; ++i) {
      if (rays.end[i] != 0) continue;
      // the real sensor is upside down: away from the axis in the picture is -y here
      const double per_focus = 1e-3 / thin.focus_distance_m;
      bundle.push_back({-rays.stop_y[i], rays.stop_x[i], -(rays.m[i] / -rays.n[i] + rays.y[i] * per_focus) * scale_mm,
                        (rays.l[i] / -rays.n[i] + rays.x[i] * per_focus) * scale_mm});
    }
  }
  return bundle;
}

/// Where the middle of the stop's ray belongs: the bundle's tangential height at p = 0, by a plane through its core.
double chief_height(const std::vector<BundleRay>& bundle) {
  double sum = 0, weight = 0;
  for (const BundleRay& ray : bundle) {
    const double w = std::exp(-(ray.p_t * ray.p_t + ray.p_s * ray.p_s) / (2 * 0.15 * 0.15));
    sum += w * ray.image_t;
    weight += w;
  }
  return sum / weight;
}

/// Least squares of the transverse aberration by defocus and spherical terms, the rim's shifts in mm.
Eigen::Vector4d fit_axis(const std::vector<BundleRay>& bundle) {
  Eigen::MatrixXd a(2 * bundle.size(), 4);
  Eigen::VectorXd b(2 * bundle.size());
  for (std::size_t i = 0; i < bundle.size(); ++i) {
    const BundleRay& ray = bundle[i];
    const double rho2 = ray.p_t * ray.p_t + ray.p_s * ray.p_s;
    const double powers[4] = {1, rho2, rho2 * rho2, rho2 * rho2 * rho2};
    for (int k = 0; k < 4; ++k) {
      a(2 * i, k) = ray.p_t * powers[k];
      a(2 * i + 1, k) = ray.p_s * powers[k];
    }
    b[2 * i] = -ray.image_t;
    b[2 * i + 1] = -ray.image_s;
  }
  return a.colPivHouseholderQr().solve(b);
}

/// From where straight chief rays meet the sensor as steeply as these do: its distance, mm from the sensor of the lens
/// focused at infinity, and how that grows over the field. 0, the focal length's, where some meet it as from behind.
void fit_exit_pupil(const PupilBounds& bounds, const ThinLens& thin, Aberrations& a) {
  std::vector<double> h, growth;
  double at_axis_mm = 0;
  for (int k = 1; k < PupilBounds::kNodes; ++k) {
    const double field = k / (PupilBounds::kNodes - 1.0), m = bounds.nodes[k].chief_m;
    if (!(bounds.nodes[k].half_m > 0)) continue;
    const double distance_mm = -field * bounds.image_radius_mm * std::sqrt(1 - m * m) / m;
    if (!(distance_mm > 0 && std::isfinite(distance_mm))) return;
    if (h.empty()) at_axis_mm = distance_mm;
    h.push_back(field);
    growth.push_back(distance_mm / at_axis_mm - 1);
  }
  const double moved_mm = 1e3 * (thin.image_distance_m() - thin.focal_length_m);
  if (!(at_axis_mm > moved_mm)) return;
  a.exit_pupil_mm = at_axis_mm - moved_mm;
  a.exit_pupil_growth = fit_even(h, growth, 5);
}

/// Line through (h, limit) where the limit is inside the stop; false where it hardly ever is.
bool fit_limit(const std::vector<double>& h, const std::vector<double>& limit, double& at_axis, double& slope) {
  double n = 0, sh = 0, sl = 0, shh = 0, shl = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (limit[i] > 0.97) continue;
    n += 1, sh += h[i], sl += limit[i], shh += h[i] * h[i], shl += h[i] * limit[i];
  }
  if (n < 3) return false;
  slope = (n * shl - sh * sl) / (n * shh - sh * sh);
  at_axis = (sl - slope * sh) / n;
  return slope < -0.02 && at_axis > 0.2;
}

/// Disparity coefficients at h along the picture's x axis (the split is tangential) or y axis (sagittal),
/// behind a sensor just as long as the field: a lens need not be asked for what it does beyond.
std::vector<DisparityCoefficients> along(const Lens& lens, const std::vector<double>& h, bool tangential) {
  constexpr int kRadiusPx = 1000, kSide = 2 * kRadiusPx + 4;
  const int width = tangential ? kSide : 4, height = tangential ? 4 : kSide;
  const double pitch_m = field_radius_m(image_radius_mm(lens), lens.thin) / kRadiusPx;
  const LensSampler sampler(lens, {width, height, pitch_m, {0.5 * width, 0.5 * height}});
  std::vector<DisparityCoefficients> result;
  for (double value : h) {
    const int far = kSide / 2 + static_cast<int>(value * kRadiusPx);
    result.push_back(trace_disparity(sampler, tangential ? far : 2, tangential ? 2 : far, kSamples));
  }
  return result;
}

/// What green rays say over the field, at distances h from the axis.
struct FieldFit {
  std::vector<double> h, distortion;
  std::vector<double> upper, lower;  ///< how far the pupil is open, away from the axis and towards it, stop radii
};

/// `bundle_at(h)` traces the rays that reach h.
template <class BundleAt>
FieldFit trace_field(const BundleAt& bundle_at, double radius_mm) {
  FieldFit fit;
  for (int k = 0; k < kNodes; ++k) {
    const double height = std::max(k / (kNodes - 1.0), 0.01);
    const std::vector<BundleRay> bundle = bundle_at(height);
    if (bundle.size() < 64) {
      throw InputError(
          fmt::format("image_radius_mm: no aberrated lens fits: hardly any light reaches {:.2f} mm from the axis",
                      height * radius_mm));
    }
    fit.h.push_back(height);
    fit.distortion.push_back(height * radius_mm / chief_height(bundle) - 1);
    double high = -1, low = 1;
    for (const BundleRay& ray : bundle) {
      if (std::abs(ray.p_s) > 0.05) continue;
      high = std::max(high, ray.p_t);
      low = std::min(low, ray.p_t);
    }
    fit.upper.push_back(high);
    fit.lower.push_back(-low);
  }
  return fit;
}

/// What single rays show, color by color: the axis gives focus and spherical aberration, the field the picture's size,
/// its distortion and vignetting. Returns the distances from the axis that were traced.
std::vector<double> fit_rays(const Prescription& p, const ThinLens& thin, Aberrations& a) {
  const double pupil_z_mm = paraxial(p).entrance_pupil_z;
  const double radius_mm = field_radius_m(a.image_radius_mm, thin) * 1e3;
  const double rim = thin.rim_slope();
  FieldFit field;
  double color_focus_mm[3], color_size[3];
  for (int color = 0; color < 3; ++color) {
    const double nm = p.wavelengths_nm[color];
    const TracedLens<double> traced(p, nm);
    const PupilBounds bounds = find_pupil(p, nm, radius_mm);
    const auto bundle_at = [&](double height) {
      return trace_bundle(traced, bounds.at(height * radius_mm), height * radius_mm, pupil_z_mm, thin);
    };
    const Eigen::Vector4d axis = fit_axis(bundle_at(0));
    color_focus_mm[color] = -axis[0] / rim;
    color_size[color] = 0.7 * radius_mm / chief_height(bundle_at(0.7));
    if (color != 1) continue;
    fit_exit_pupil(bounds, thin, a);
    for (int k = 1; k < 4; ++k) a.spherical_um.push_back(axis[k] * 1e3);
    field = trace_field(bundle_at, radius_mm);
  }
  a.distortion = fit_even(field.h, field.distortion, 5);
  if (p.has_color()) {
    a.longitudinal_color_um = {1e3 * (color_focus_mm[0] - color_focus_mm[1]),
                               1e3 * (color_focus_mm[2] - color_focus_mm[1])};
    a.lateral_color = {color_size[0] / color_size[1] - 1, color_size[2] / color_size[1] - 1};
  }
  double at_axis = 0, slope = 0;
  if (fit_limit(field.h, field.upper, at_axis, slope)) a.rims.push_back({at_axis, slope});
  if (fit_limit(field.h, field.lower, at_axis, slope)) a.rims.push_back({at_axis, -slope});
  return field.h;
}

/// Sums of a straight line's least squares.
struct Line {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  void add(double at, double value) { n += 1, x += at, y += value, xx += at * at, xy += at * value; }
  double slope() const { return (n * xy - x * y) / (n * xx - x * x); }
};

/// A value for each direction (0 tangential, 1 sagittal) and each distance from the axis.
template <class Value>
using OverField = std::array<std::vector<Value>, 2>;

/// The growth of the pupil that makes the slopes of disparity agree, both lenses focused on infinity.
EvenPolynomial fit_pupil(const Lens& fitted, const std::vector<DisparityCoefficients>& wanted,
                         const std::vector<double>& h, bool tangential) {
  const std::vector<DisparityCoefficients> plain = along(fitted, h, tangential);
  std::vector<double> growth;
  for (std::size_t i = 0; i < h.size(); ++i) growth.push_back(wanted[i].slope_dp_px_m / plain[i].slope_dp_px_m - 1);
  return fit_even(h, growth, 7);
}

/// The change of focus, um, that gives `fitted` the disparity of a point at infinity that is wanted.
std::vector<double> focus_gaps_um(const Lens& fitted, const std::vector<DisparityCoefficients>& wanted,
                                  const std::vector<double>& h, bool tangential) {
  constexpr double kStepUm = 10;
  const std::vector<DisparityCoefficients> flat = along(fitted, h, tangential);
  Lens stepped_lens = fitted;
  std::get<Aberrations>(stepped_lens.model).focus_um += kStepUm;
  const std::vector<DisparityCoefficients> stepped = along(stepped_lens, h, tangential);
  std::vector<double> gaps_um;
  for (std::size_t i = 0; i < h.size(); ++i) {
    const double per_um = (stepped[i].intercept_dp_px - flat[i].intercept_dp_px) / kStepUm;
    gaps_um.push_back((wanted[i].intercept_dp_px - flat[i].intercept_dp_px) / per_um);
  }
  return gaps_um;
}

/// Splits focus over the field into its value on the axis and two polynomials.
void set_focus_surfaces(OverField<double> focus_um, const std::vector<double>& h, double& on_axis_um,
                        EvenPolynomial& tangential_um, EvenPolynomial& sagittal_um) {
  on_axis_um = 0.5 * (focus_um[0][0] + focus_um[1][0]);
  for (std::vector<double>& direction : focus_um) {
    for (double& value : direction) value -= on_axis_um;
  }
  tangential_um = fit_even(h, focus_um[0], 9);
  sagittal_um = fit_even(h, focus_um[1], 9);
}

/// The rest is chosen so that disparity agrees with that of `traced`: its slope in 1/depth gives the pupil's size, its
/// intercept the focus, tangentially and sagittally; at several focus distances, since focus errs more in near ones.
void fit_disparity(const Lens& traced, const std::vector<double>& h, Lens& twin) {
  auto& a = std::get<Aberrations>(twin.model);
  const double f = traced.thin.focal_length_m;
  twin.thin.f_number *= along(twin, {0.0}, true)[0].slope_dp_px_m / along(traced, {0.0}, true)[0].slope_dp_px_m;
  OverField<Line> lines = {std::vector<Line>(h.size()), std::vector<Line>(h.size())};
  for (double distance_m : {std::numeric_limits<double>::infinity(), 120 * f, 40 * f}) {
    const Lens wanted_lens = refocused(traced, distance_m);
    Lens fitted = refocused(twin, distance_m);
    for (int direction : {0, 1}) {
      const bool tangential = direction == 0;
      const std::vector<DisparityCoefficients> wanted = along(wanted_lens, h, tangential);
      if (std::isinf(distance_m)) {
        EvenPolynomial& pupil = tangential ? a.tangential_pupil : a.sagittal_pupil;
        pupil = fit_pupil(fitted, wanted, h, tangential);
        auto& focused_pupil = std::get<Aberrations>(fitted.model);
        (tangential ? focused_pupil.tangential_pupil : focused_pupil.sagittal_pupil) = pupil;
      }
      const std::vector<double> gaps_um = focus_gaps_um(fitted, wanted, h, tangential);
      for (std::size_t i = 0; i < h.size(); ++i) lines[direction][i].add(1 / distance_m, gaps_um[i]);
    }
  }
  OverField<double> constant, per_diopter;
  for (int direction : {0, 1}) {
    for (const Line& line : lines[direction]) {
      per_diopter[direction].push_back(line.slope());
      constant[direction].push_back((line.y - per_diopter[direction].back() * line.x) / line.n);
    }
  }
  set_focus_surfaces(constant, h, a.focus_um, a.tangential_focus_um, a.sagittal_focus_um);
  set_focus_surfaces(per_diopter, h, a.focus_um_per_diopter, a.tangential_focus_um_per_diopter,
                     a.sagittal_focus_um_per_diopter);
}

}  // namespace

Lens aberrated_twin(const Lens& lens) {
  const Prescription* p = prescription_of(lens);
  if (!p) throw InputError("model: only a prescription has an aberrated twin");

  Lens twin = lens;
  auto& a = twin.model.emplace<Aberrations>();
  twin.name = lens.name + ", aberrated twin";
  twin.derived = "parameters fitted to the traced prescription";
  a.image_radius_mm = p->image_radius_mm;
  a.falloff = Aberrations::Falloff::cos4;
  std::vector<double> h = fit_rays(*p, lens.thin, a);

  Lens traced = lens;
  Prescription green = *p;
  green.wavelengths_nm.fill(p->wavelengths_nm[1]);
  std::get<PrescriptionModel>(traced.model).prescription = std::make_shared<const Prescription>(std::move(green));
  // Behind a plain split, whatever the sensor's own: where that one's disparity hardly depends on focus, nothing of the
  // lens could be read from it.
  traced.split = twin.split = SplitPixel{};
  h.insert(h.begin(), 0.0);
  fit_disparity(traced, h, twin);
  twin.split = lens.split;
  return twin;
}

}  // namespace dualpixel::simulator
