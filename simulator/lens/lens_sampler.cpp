#include "simulator/lens/lens_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "capture/lanes.h"
#include "simulator/lens/prescription/cubic.h"

namespace dualpixel::simulator {

/// What all samples of one photosite share.
struct LensSampler::PixelFrame {
  float x_m, y_m;  ///< its centre
  float pitch_m;
  float radial_x, radial_y;  ///< unit vector from the axis to it; (0, 1) on the axis
  float radius_m;
  float h2;  ///< squared, in field radii (aberrated)
};

namespace {

constexpr int kTableSteps = 1024;

/// Value and derivative at r of a function given at evenly spaced nodes, odd about 0. Beyond the last node it goes on
/// straight: who looks for the place that a chief ray comes from may look there.
struct Odd {
  double value, slope;
};
Odd interpolate_odd(const std::vector<double>& nodes, double spacing, double r) {
  const int last = static_cast<int>(nodes.size()) - 1;
  const double u = std::clamp(r / spacing, 0.0, static_cast<double>(last));
  const int i = std::min(static_cast<int>(u), last - 1);
  const double t = u - i;
  const double v1 = nodes[i], v2 = nodes[i + 1];
  const double v0 = i > 0 ? nodes[i - 1] : -nodes[1];
  const double v3 = i + 2 <= last ? nodes[i + 2] : 2 * v2 - v1;
  const std::array<double, 4> w = cubic_weights(t), s = cubic_slopes(t);
  const double slope = (s[0] * v0 + s[1] * v1 + s[2] * v2 + s[3] * v3) / spacing;
  const double over = std::max(r - last * spacing, 0.0);
  return {w[0] * v0 + w[1] * v1 + w[2] * v2 + w[3] * v3 + slope * over, slope};
}

/// Slopes in front of the lens of the chief rays of `bounds`' nodes, positive as the picture is upright.
std::vector<double> trace_chief_slopes(const Prescription& lens, double wavelength_nm, const PupilBounds& bounds) {
  const TracedLens<double> unclipped(lens, wavelength_nm, false);
  std::vector<double> slopes;
  for (int k = 0; k < PupilBounds::kNodes; ++k) {
    RayBatch<double, 1> ray{};
    ray.y[0] = bounds.image_radius_mm * k / (PupilBounds::kNodes - 1);
    ray.z[0] = unclipped.sensor_z_mm();
    ray.m[0] = bounds.nodes[k].chief_m;
    ray.n[0] = -std::sqrt(1 - ray.m[0] * ray.m[0]);
    unclipped.trace(ray);
    const bool usable = k < 2 || (ray.end[0] == 0 && bounds.nodes[k].half_m > 0);
    // beyond the picture that the lens draws its outermost line goes on
    slopes.push_back(usable ? ray.m[0] / ray.n[0] : 2 * slopes[k - 1] - slopes[k - 2]);
  }
  return slopes;
}

// In registers by hand: compilers vectorize loops over plain arrays of terms along the wrong axis.
constexpr int kHalves = kPacket / kLanes;

/// All terms of RayPolynomial at the sixteen places of a packet.
class PupilTerms {
 public:
  PupilTerms(const float x[kPacket], const float y[kPacket]) {
    for (int half = 0; half < kHalves; ++half) {
      const Lanes y_lanes = load_lanes(y + kLanes * half);
      x_[half] = load_lanes(x + kLanes * half);
      const Lanes x2 = x_[half] * x_[half];
      Lanes row = x2 - x2 + 1;
      int k = 0;
      for (int i = 0; 2 * i <= kSlopeDegree; ++i) {
        Lanes term = row;
        for (int j = 0; 2 * i + j <= kSlopeDegree; ++j, ++k) {
          terms_[k][half] = term;
          term *= y_lanes;
        }
        row *= x2;
      }
    }
  }

  template <int Degree>
  void even(const float (&c)[count_terms(Degree)], float result[kPacket]) const {
    Lanes sum[kHalves];
    add<Degree>(c, sum);
    std::memcpy(result, sum, sizeof(sum));
  }
  template <int Degree>
  void odd(const float (&c)[count_terms(Degree)], float result[kPacket]) const {
    Lanes sum[kHalves];
    add<Degree>(c, sum);
    for (int half = 0; half < kHalves; ++half) sum[half] *= x_[half];
    std::memcpy(result, sum, sizeof(sum));
  }

 private:
  template <int Degree>
  void add(const float* c, Lanes sum[kHalves]) const {
    Lanes a{}, b{};
    int k = 0, from = 0;
    for (int i = 0; 2 * i <= Degree; ++i) {
      for (int j = 0; 2 * i + j <= Degree; ++j, ++k) {
        a += c[k] * terms_[from + j][0];
        b += c[k] * terms_[from + j][1];
      }
      from += kSlopeDegree - 2 * i + 1;
    }
    sum[0] = a;
    sum[1] = b;
  }

  Lanes x_[kHalves];
  Lanes terms_[count_terms(kSlopeDegree)][kHalves];
};
static_assert(kHalves == 2);

}  // namespace

LensSampler::LensSampler(const Lens& lens, const SensorGrid& sensor) : lens_(lens), sensor_(sensor) {
  const ThinLens& thin = lens_.thin;
  radius_m_ = static_cast<float>(0.5 * thin.pupil_diameter_m());
  image_distance_m_ = static_cast<float>(thin.image_distance_m());
  inverse_focus_ = static_cast<float>(1 / thin.focus_distance_m);
  lux_per_nit_ = thin.lux_per_nit();
  field_radius_m_ = lens_.aberrations.field_radius_m(thin);

  const SplitPixel& split = lens_.split;
  if (split.kind == SplitPixel::Kind::microlens || split.kind == SplitPixel::Kind::table) {
    double reach = 1;
    if (split.kind == SplitPixel::Kind::microlens) {
      const SplitPixel::Microlens& m = split.microlens;
      const double spot = m.radius * std::abs(1 - m.height / m.focal_length);
      reach = (m.diode_width + spot + std::abs(m.shift)) / std::max(m.height, 1e-3) + 1e-3;
    }
    table_.low = static_cast<float>(-reach);
    table_.per_step = static_cast<float>(kTableSteps / (2 * reach));
    for (int i = 0; i <= kTableSteps + 1; ++i) {
      const double at = -reach + 2 * reach * std::min(i, kTableSteps) / kTableSteps;
      const SplitPixel::Shares s = split.shares(at, at);
      table_.left.push_back(static_cast<float>(s.left));
      table_.right.push_back(static_cast<float>(s.right));
    }
  }

  if (lens_.model == Lens::Model::aberrated) {
    const Aberrations& a = lens_.aberrations;
    has_color_ = a.longitudinal_color_um != std::array<double, 2>{} || a.lateral_color != std::array<double, 2>{};
  } else if (lens_.model == Lens::Model::prescription) {
    const Prescription& p = *lens_.prescription;
    has_color_ = p.has_color();
    entrance_pupil_z_mm_ = paraxial(p).entrance_pupil_z;
    const glm::dvec2 corner = glm::max(sensor_.principal_point_px,
                                       glm::dvec2(sensor_.width_px, sensor_.height_px) - sensor_.principal_point_px);
    const double reach_mm = 1e3 * sensor_.pixel_pitch_m * glm::length(corner) * 1.001;
    const std::vector<double> wavelengths = has_color_
                                                ? std::vector<double>(p.wavelengths_nm.begin(), p.wavelengths_nm.end())
                                                : std::vector<double>{p.wavelengths_nm[1]};
    for (double nm : wavelengths) {
      const PupilBounds bounds = find_pupil(p, nm, reach_mm);
      polynomials_.push_back(fit_ray_polynomials(p, nm, bounds, entrance_pupil_z_mm_));
      if (lens_.exact_trace) traced_.emplace_back(p, nm);
    }
    const RayPolynomials& green = polynomials_[polynomials_.size() / 2];
    axis_area_ = green.bounds.nodes[0].pass_area;
    if (!(axis_area_ > 0)) throw std::invalid_argument("no light passes the lens on its axis");
    lux_per_nit_ = axis_area_;
    chief_slopes_ = trace_chief_slopes(p, p.wavelengths_nm[1], green.bounds);
  }
}

LensSampler::PixelFrame LensSampler::frame(int x, int y) const {
  PixelFrame f;
  const glm::dvec2 at_m = sensor_.middle_m(x, y);
  const double r = glm::length(at_m);
  f.x_m = static_cast<float>(at_m.x);
  f.y_m = static_cast<float>(at_m.y);
  f.pitch_m = static_cast<float>(sensor_.pixel_pitch_m);
  f.radial_x = r > 0 ? static_cast<float>(at_m.x / r) : 0.0f;
  f.radial_y = r > 0 ? static_cast<float>(at_m.y / r) : 1.0f;
  f.radius_m = static_cast<float>(r);
  const double h = r / field_radius_m_;
  f.h2 = static_cast<float>(h * h);
  return f;
}

glm::dvec2 LensSampler::chief_slope(double x_m, double y_m) const {
  const glm::dvec2 at(x_m, y_m);
  const double r = glm::length(at);
  if (lens_.model == Lens::Model::prescription) {
    if (r == 0) return {0, 0};
    const double spacing = polynomials_.front().bounds.image_radius_mm * 1e-3 / (PupilBounds::kNodes - 1);
    return at * (interpolate_odd(chief_slopes_, spacing, r).value / r);
  }
  double ideal = 1;
  if (lens_.model == Lens::Model::aberrated) {
    const double h = r / field_radius_m_;
    ideal = 1 / (1 + lens_.aberrations.distortion(h * h));
  }
  return at * (ideal / lens_.thin.image_distance_m());
}

void LensSampler::split(const PixelFrame& f, const float p[kPacket], const float t[kPacket], float excess_slope,
                        const float weight[kPacket], LensPacket& out) const {
  const SplitPixel& split = lens_.split;
  const auto crosstalk = static_cast<float>(split.crosstalk);
  float offset = 0, left_gain = 1, right_gain = 1;
  if (lens_.model == Lens::Model::aberrated) {
    const Aberrations& a = lens_.aberrations;
    const double scale = 1 / field_radius_m_;
    offset = static_cast<float>(a.split_offset(f.x_m * scale, f.y_m * scale));
    left_gain = static_cast<float>(std::clamp(a.left_gain(f.x_m * scale, f.y_m * scale), 0.0, 1.0));
    right_gain = static_cast<float>(std::clamp(a.right_gain(f.x_m * scale, f.y_m * scale), 0.0, 1.0));
  }
  switch (split.kind) {
    case SplitPixel::Kind::hard:
      for (int i = 0; i < kPacket; ++i) {
        const float right = p[i] >= offset ? 1 - crosstalk : crosstalk;
        out.right[i] = right;
        out.left[i] = 1 - right;
      }
      break;
    case SplitPixel::Kind::ramp: {
      const auto slope = static_cast<float>(0.5 / split.k);
      for (int i = 0; i < kPacket; ++i) {
        const float s = std::clamp(0.5f + slope * (p[i] - offset), 0.0f, 1.0f);
        out.right[i] = s + crosstalk * (1 - 2 * s);
        out.left[i] = 1 - out.right[i];
      }
      break;
    }
    case SplitPixel::Kind::microlens:
    case SplitPixel::Kind::table: {
      const bool microlens = split.kind == SplitPixel::Kind::microlens;
      const auto rim = static_cast<float>(lens_.thin.rim_slope());
      for (int i = 0; i < kPacket; ++i) {
        const float at = microlens ? t[i] - offset * rim + excess_slope : p[i] - offset;
        const float u = std::clamp((at - table_.low) * table_.per_step, 0.0f, static_cast<float>(kTableSteps));
        const int k = static_cast<int>(u);
        const float fraction = u - static_cast<float>(k);
        out.left[i] = table_.left[k] + fraction * (table_.left[k + 1] - table_.left[k]);
        out.right[i] = table_.right[k] + fraction * (table_.right[k + 1] - table_.right[k]);
      }
      break;
    }
  }
  for (int i = 0; i < kPacket; ++i) {
    out.left[i] *= left_gain * weight[i];
    out.right[i] *= right_gain * weight[i];
  }
}

namespace {

/// No ray leaves flatter than this (89 degrees from the axis) or farther off (metres), and none that is not a number:
/// Embree would end the program.
constexpr float kSteepest = 100;

void block_stray(const LensPacket& packet, float weight[kPacket]) {
  for (int i = 0; i < kPacket; ++i) {
    const float steep = std::abs(packet.slope_x[i]) + std::abs(packet.slope_y[i]);
    const float far_m = std::abs(packet.origin_x[i]) + std::abs(packet.origin_y[i]);
    weight[i] = steep + far_m < kSteepest ? weight[i] : 0.0f;  // false for what is no number
  }
}

/// How much steeper the chief ray of an ideal lens is than the one the microlens was shifted for.
float excess_slope(const SplitPixel& split, float x_m, float chief_slope) {
  const double design_m = split.microlens.design_exit_pupil_mm * 1e-3;
  if (split.kind != SplitPixel::Kind::microlens || design_m == 0) return 0;
  return static_cast<float>(chief_slope - x_m / design_m);
}

}  // namespace

void LensSampler::sample_thin(const PixelFrame& f, const float s[4][kPacket], LensPacket& out) const {
  alignas(64) float p[2][kPacket], t[kPacket], weight[kPacket];
  concentric_disc(s[2], s[3], p[0], p[1]);
  const float per_m = 1 / image_distance_m_;
  const float rim = radius_m_ * per_m;
  for (int i = 0; i < kPacket; ++i) {
    out.origin_x[i] = p[0][i] * radius_m_;
    out.origin_y[i] = p[1][i] * radius_m_;
    out.slope_x[i] = (f.x_m + (s[0][i] - 0.5f) * f.pitch_m) * per_m - out.origin_x[i] * inverse_focus_;
    out.slope_y[i] = (f.y_m + (s[1][i] - 0.5f) * f.pitch_m) * per_m - out.origin_y[i] * inverse_focus_;
    t[i] = p[0][i] * rim;
    weight[i] = 1;
  }
  split(f, p[0], t, excess_slope(lens_.split, f.x_m, f.x_m * per_m), weight, out);
}

void LensSampler::sample_aberrated(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out) const {
  const Aberrations& a = lens_.aberrations;
  alignas(64) float p[2][kPacket], t[kPacket], weight[kPacket], along[kPacket], across[kPacket];
  concentric_disc(s[2], s[3], p[0], p[1]);
  const double h2 = std::min(f.h2, 1.0f);  // beyond the image radius the knobs stay what they are there
  const float per_m = 1 / image_distance_m_;
  const float rim = radius_m_ * per_m;
  const double color_um = color == 0 ? a.longitudinal_color_um[0] : color == 2 ? a.longitudinal_color_um[1] : 0;
  const double color_size = 1 + (color == 0 ? a.lateral_color[0] : color == 2 ? a.lateral_color[1] : 0);
  // transverse shifts of the rim's ray, metres on the sensor
  const double diopters = 1 / lens_.thin.focus_distance_m;
  const double focus_um = a.focus_um + a.focus_um_per_diopter * diopters + color_um;
  const double tangential_um = a.tangential_focus_um(h2) + a.tangential_focus_um_per_diopter(h2) * diopters;
  const double sagittal_um = a.sagittal_focus_um(h2) + a.sagittal_focus_um_per_diopter(h2) * diopters;
  const auto defocus_t = static_cast<float>(-1e-6 * (focus_um + tangential_um) * rim);
  const auto defocus_s = static_cast<float>(-1e-6 * (focus_um + sagittal_um) * rim);
  const auto pupil_t = static_cast<float>(1 + a.tangential_pupil(h2));
  const auto pupil_s = static_cast<float>(1 + a.sagittal_pupil(h2));
  // the ideal picture's place and its change within the photosite
  const double stretch = 1 / ((1 + a.distortion(f.h2)) * color_size);
  const double step = 1e-3;
  const double h = std::sqrt(f.h2);
  const double ahead = (h + step) / (1 + a.distortion((h + step) * (h + step)));
  const double behind = (h - step) / (1 + a.distortion((h - step) * (h - step)));
  const auto stretch_r = static_cast<float>((ahead - behind) / (2 * step) / color_size);
  const auto stretch_a = static_cast<float>(stretch);
  const float rx = f.radial_x, ry = f.radial_y;
  for (int i = 0; i < kPacket; ++i) {
    along[i] = p[0][i] * rx + p[1][i] * ry;
    across[i] = -p[0][i] * ry + p[1][i] * rx;
    const float dx = (s[0][i] - 0.5f) * f.pitch_m, dy = (s[1][i] - 0.5f) * f.pitch_m;
    const float image_r = f.radius_m * stretch_a + stretch_r * (dx * rx + dy * ry);
    const float image_a = stretch_a * (-dx * ry + dy * rx);
    const float rho2 = p[0][i] * p[0][i] + p[1][i] * p[1][i];
    float spherical = 0;
    for (auto c = a.spherical_um.rbegin(); c != a.spherical_um.rend(); ++c) {
      spherical = (spherical + 1e-6f * static_cast<float>(*c)) * rho2;
    }
    const float origin_r = along[i] * pupil_t * radius_m_, origin_a = across[i] * pupil_s * radius_m_;
    const float slope_r = (image_r - along[i] * (defocus_t + spherical)) * per_m - origin_r * inverse_focus_;
    const float slope_a = (image_a - across[i] * (defocus_s + spherical)) * per_m - origin_a * inverse_focus_;
    out.origin_x[i] = origin_r * rx - origin_a * ry;
    out.origin_y[i] = origin_r * ry + origin_a * rx;
    out.slope_x[i] = slope_r * rx - slope_a * ry;
    out.slope_y[i] = slope_r * ry + slope_a * rx;
    t[i] = p[0][i] * rim;
  }
  // Etendue: light from the pupil's area and the scene's solid angle that one photosite sees.
  const float chief = f.radius_m * stretch_a * per_m;
  const float cos2 = 1 / (1 + chief * chief);
  const float cos4 = cos2 * cos2 * pupil_t * pupil_s * stretch_r * stretch_a;
  for (int i = 0; i < kPacket; ++i) {
    weight[i] = a.falloff == Aberrations::Falloff::cos4 ? cos4 : 1.0f;
    if (a.falloff == Aberrations::Falloff::disc) {
      const float tx = f.x_m * per_m + p[0][i] * rim, ty = f.y_m * per_m + p[1][i] * rim;
      const float c2 = 1 / (1 + tx * tx + ty * ty);
      weight[i] = c2 * c2;
    }
  }
  for (const Aberrations::Rim& rim_disc : a.rims) {
    const auto shift = static_cast<float>(rim_disc.shift * h);
    const auto radius2 = static_cast<float>(rim_disc.radius * rim_disc.radius);
    for (int i = 0; i < kPacket; ++i) {
      const float d = along[i] - shift;
      weight[i] = d * d + across[i] * across[i] <= radius2 ? weight[i] : 0.0f;
    }
  }
  const double moved_m = image_distance_m_ - lens_.thin.focal_length_m;
  const double exit_pupil_m = a.exit_pupil_mm > 0 ? 1e-3 * a.exit_pupil_mm + moved_m : image_distance_m_;
  split(f, p[0], t, excess_slope(lens_.split, f.x_m, static_cast<float>(f.x_m / exit_pupil_m)), weight, out);
}

void LensSampler::sample_polynomials(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out) const {
  const RayPolynomials& lens = polynomials_[has_color_ ? color : 0];
  const double r_mm = f.radius_m * 1e3;
  const PupilEllipse ellipse = lens.bounds.at(r_mm);
  const RayPolynomial c = lens.at(r_mm);
  // the lens frame's y axis points from the axis to the photosite on the real, inverted sensor
  const float yx = -f.radial_x, yy = -f.radial_y, xx = yy, xy = -yx;
  alignas(64) float q[2][kPacket], x[kPacket], y[kPacket];
  concentric_disc(s[2], s[3], q[0], q[1]);
  for (int i = 0; i < kPacket; ++i) {
    x[i] = q[0][i] * xx + q[1][i] * xy;
    y[i] = q[0][i] * yx + q[1][i] * yy;
  }
  const PupilTerms terms(x, y);
  alignas(64) float origin_x[kPacket], origin_y[kPacket], slope_x[kPacket], slope_y[kPacket], stop_x[kPacket],
      stop_y[kPacket], rim[kPacket], weight[kPacket], p[kPacket], t[kPacket];
  terms.odd<kSlopeDegree - 1>(c.slope_x, slope_x);
  terms.even<kSlopeDegree>(c.slope_y, slope_y);
  terms.odd<kSmoothDegree - 1>(c.origin_x, origin_x);
  terms.even<kSmoothDegree>(c.origin_y, origin_y);
  terms.odd<kSmoothDegree - 1>(c.stop_x, stop_x);
  terms.even<kSmoothDegree>(c.stop_y, stop_y);
  const auto full = static_cast<float>(M_PI * ellipse.half_l * ellipse.half_m / axis_area_);
  for (int i = 0; i < kPacket; ++i) weight[i] = stop_x[i] * stop_x[i] + stop_y[i] * stop_y[i] <= 1 ? full : 0.0f;
  for (std::size_t k = 0; k < lens.rims.size(); ++k) {
    terms.even<kRimDegree>(c.rim[k], rim);
    for (int i = 0; i < kPacket; ++i) weight[i] = rim[i] <= 1 ? weight[i] : 0.0f;
  }
  // Within the photosite the whole bundle turns as the chief ray does.
  const double spacing = lens.bounds.image_radius_mm * 1e-3 / (PupilBounds::kNodes - 1);
  const Odd chief = interpolate_odd(chief_slopes_, spacing, f.radius_m);
  const auto turn_r = static_cast<float>(chief.slope);
  const auto turn_a = static_cast<float>(f.radius_m > 0 ? chief.value / f.radius_m : chief.slope);
  const auto chief_n = static_cast<float>(std::sqrt(std::max(1 - ellipse.chief_m * ellipse.chief_m, 1e-9)));
  const float chief_at_sensor = yx * static_cast<float>(ellipse.chief_m) / chief_n;
  const auto half_l = static_cast<float>(ellipse.half_l), half_m = static_cast<float>(ellipse.half_m);
  const auto centre_m = static_cast<float>(ellipse.centre_m);
  for (int i = 0; i < kPacket; ++i) {
    const float dx = (s[0][i] - 0.5f) * f.pitch_m, dy = (s[1][i] - 0.5f) * f.pitch_m;
    const float dr = turn_r * (dx * f.radial_x + dy * f.radial_y);
    const float da = turn_a * (-dx * f.radial_y + dy * f.radial_x);
    out.origin_x[i] = 1e-3f * (origin_x[i] * xx + origin_y[i] * yx);
    out.origin_y[i] = 1e-3f * (origin_x[i] * xy + origin_y[i] * yy);
    out.slope_x[i] = slope_x[i] * xx + slope_y[i] * yx + dr * f.radial_x - da * f.radial_y;
    out.slope_y[i] = slope_x[i] * xy + slope_y[i] * yy + dr * f.radial_y + da * f.radial_x;
    p[i] = stop_x[i] * xx + stop_y[i] * yx;
    const float l = half_l * x[i], m = centre_m + half_m * y[i];
    const float n = std::sqrt(std::max(1 - l * l - m * m, 1e-9f));
    t[i] = (l * xx + m * yx) / n - chief_at_sensor;
  }
  block_stray(out, weight);
  split(f, p, t, excess_slope(lens_.split, f.x_m, chief_at_sensor), weight, out);
}

void LensSampler::sample_traced(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out) const {
  const int index = has_color_ ? color : 0;
  const TracedLens<float>& lens = traced_[index];
  const PupilEllipse ellipse = polynomials_[index].bounds.at(f.radius_m * 1e3);
  const float yx = -f.radial_x, yy = -f.radial_y, xx = yy, xy = -yx;
  alignas(64) float q[2][kPacket], p[kPacket], t[kPacket], weight[kPacket];
  concentric_disc(s[2], s[3], q[0], q[1]);
  const auto half_l = static_cast<float>(ellipse.half_l), half_m = static_cast<float>(ellipse.half_m);
  const auto centre_m = static_cast<float>(ellipse.centre_m);
  const auto chief_n = static_cast<float>(std::sqrt(std::max(1 - ellipse.chief_m * ellipse.chief_m, 1e-9)));
  const float chief_at_sensor = yx * static_cast<float>(ellipse.chief_m) / chief_n;
  RayBatch<float, kPacket> rays;
  for (int i = 0; i < kPacket; ++i) {
    const float l = half_l * (q[0][i] * xx + q[1][i] * xy);
    const float m = centre_m + half_m * (q[0][i] * yx + q[1][i] * yy);
    rays.x[i] = -1e3f * (f.x_m + (s[0][i] - 0.5f) * f.pitch_m);
    rays.y[i] = -1e3f * (f.y_m + (s[1][i] - 0.5f) * f.pitch_m);
    rays.z[i] = static_cast<float>(lens.sensor_z_mm());
    rays.l[i] = l * xx + m * yx;
    rays.m[i] = l * xy + m * yy;
    const float rest = 1 - l * l - m * m;
    rays.n[i] = -std::sqrt(std::max(rest, 1e-6f));
    rays.end[i] = rest > 1e-6f ? 0.0f : 1.0f;
    t[i] = rays.l[i] / -rays.n[i] - chief_at_sensor;
  }
  lens.trace(rays);
  move_to_plane(rays, static_cast<float>(entrance_pupil_z_mm_));
  const auto full = static_cast<float>(M_PI * ellipse.half_l * ellipse.half_m / axis_area_);
  for (int i = 0; i < kPacket; ++i) {
    out.origin_x[i] = 1e-3f * rays.x[i];
    out.origin_y[i] = 1e-3f * rays.y[i];
    out.slope_x[i] = rays.l[i] / -rays.n[i];
    out.slope_y[i] = rays.m[i] / -rays.n[i];
    p[i] = rays.stop_x[i];
    weight[i] = rays.end[i] == 0 ? full : 0.0f;
  }
  block_stray(out, weight);
  split(f, p, t, excess_slope(lens_.split, f.x_m, chief_at_sensor), weight, out);
}

void LensSampler::sample(int x, int y, int color, const float s[4][kPacket], LensPacket& out) const {
  const PixelFrame f = frame(x, y);
  switch (lens_.model) {
    case Lens::Model::thin:
      return sample_thin(f, s, out);
    case Lens::Model::aberrated:
      return sample_aberrated(f, color, s, out);
    case Lens::Model::prescription:
      return lens_.exact_trace ? sample_traced(f, color, s, out) : sample_polynomials(f, color, s, out);
  }
}

void LensSampler::sample_ideal(int x, int y, const float s[4][kPacket], float aperture_scale, LensPacket& out) const {
  const PixelFrame f = frame(x, y);
  const double step_m = 0.5 * sensor_.pixel_pitch_m;
  const glm::dvec2 centre = chief_slope(f.x_m, f.y_m);
  const glm::dvec2 across = (chief_slope(f.x_m + step_m, f.y_m) - chief_slope(f.x_m - step_m, f.y_m));
  const glm::dvec2 down = (chief_slope(f.x_m, f.y_m + step_m) - chief_slope(f.x_m, f.y_m - step_m));
  alignas(64) float p[2][kPacket];
  concentric_disc(s[2], s[3], p[0], p[1]);
  const glm::vec2 c(centre), a(across), d(down);
  const float radius = radius_m_ * aperture_scale;
  for (int i = 0; i < kPacket; ++i) {
    const float u = s[0][i] - 0.5f, v = s[1][i] - 0.5f;
    out.origin_x[i] = p[0][i] * radius;
    out.origin_y[i] = p[1][i] * radius;
    out.slope_x[i] = c.x + u * a.x + v * d.x - out.origin_x[i] * inverse_focus_;
    out.slope_y[i] = c.y + u * a.y + v * d.y - out.origin_y[i] * inverse_focus_;
    out.left[i] = out.right[i] = 0.5f;
  }
}

}  // namespace dualpixel::simulator
