#include "simulator/lens/prescription/prescription_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

#include "capture/error.h"
#include "capture/lanes.h"
#include "simulator/lens/prescription/cubic.h"
#include "simulator/lens/prescription/ray_polynomials.h"
#include "simulator/lens/prescription/ray_trace.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

/// Value and derivative at r of a function given at evenly spaced nodes, odd about 0. Beyond the last node it is
/// extrapolated linearly: a search for the origin of a chief ray may leave the table.
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
    // beyond the image circle the last slope is extrapolated
    slopes.push_back(usable ? ray.m[0] / ray.n[0] : 2 * slopes[k - 1] - slopes[k - 2]);
  }
  return slopes;
}

// In registers by hand: compilers vectorize loops over plain arrays of terms along the wrong axis.
constexpr int kHalves = kPacket / kLanes;

/// All terms of RayPolynomial at the sixteen positions of a packet.
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

/// No ray leaves flatter than this (89 degrees from the axis) or farther off (meters), and none that is not a number:
/// Embree would end the program.
constexpr float kSteepest = 100;

void block_stray(const LensPacket& packet, float weight[kPacket]) {
  for (int i = 0; i < kPacket; ++i) {
    const float steep = std::abs(packet.slope_x[i]) + std::abs(packet.slope_y[i]);
    const float far_m = std::abs(packet.origin_x[i]) + std::abs(packet.origin_y[i]);
    weight[i] = steep + far_m < kSteepest ? weight[i] : 0.0f;  // false for what is not a number
  }
}

/// Axes of the lens frame on the upright picture: its y points from the axis to the photosite on the real, inverted
/// sensor.
struct LensAxes {
  float xx, xy;  ///< x
  float yx, yy;  ///< y
};
LensAxes axes_of(const PixelFrame& f) { return {-f.radial_y, f.radial_x, -f.radial_x, -f.radial_y}; }

}  // namespace

struct PrescriptionSampler::Tables {
  bool exact_trace = false, has_color = false;
  std::uint32_t band_samples = 1;
  // for each wavelength of R's band, G's and B's; one where the lens has no color
  std::vector<RayPolynomials> polynomials;
  std::vector<TracedLens<float>> traced;
  std::vector<PupilReaches> reaches;
  double entrance_pupil_z_mm = 0;
  /// Of a packet's filter and draw; 0 is the middle of the band.
  std::size_t index(int color, std::uint32_t draw) const {
    return has_color ? color * band_samples + (draw + band_samples / 2) % band_samples : 0;
  }
  double axis_area = 0;              ///< dL dM of the green pass region on the axis
  std::vector<double> chief_slopes;  ///< green, at the nodes of PupilBounds
};

PrescriptionSampler::PrescriptionSampler(const PrescriptionModel& model, const ThinLens&, const SensorGrid& sensor) {
  const Prescription& p = *model.prescription;
  Tables t;
  t.exact_trace = model.exact_trace;
  t.has_color = p.has_color();
  t.entrance_pupil_z_mm = paraxial(p).entrance_pupil_z;
  const glm::dvec2 corner =
      glm::max(sensor.principal_point_px, glm::dvec2(sensor.width_px, sensor.height_px) - sensor.principal_point_px);
  const double reach_mm = 1e3 * sensor.pixel_pitch_m * glm::length(corner) * 1.001;
  t.band_samples = p.band_samples;
  std::vector<double> wavelengths;
  for (int color = 0; color < 3 && t.has_color; ++color) {
    for (int i = 0; i < p.band_samples; ++i) wavelengths.push_back(p.wavelength_nm(color, i));
  }
  if (!t.has_color) wavelengths = {p.wavelengths_nm[1]};
  for (double nm : wavelengths) {
    const PupilBounds bounds = find_pupil(p, nm, reach_mm);
    t.polynomials.push_back(fit_ray_polynomials(p, nm, bounds, t.entrance_pupil_z_mm));
    t.traced.emplace_back(p, nm);
  }
  const RayPolynomials& green = t.polynomials[t.polynomials.size() / 2];
  t.axis_area = green.bounds.nodes[0].pass_area;
  if (!(t.axis_area > 0)) throw InputError("surfaces: no light passes the lens on its axis: some must");
  t.chief_slopes = trace_chief_slopes(p, p.wavelengths_nm[1], green.bounds);
  const auto tables = std::make_shared<Tables>(std::move(t));
  tables_ = tables;
  std::vector<PupilReaches> reaches(tables->polynomials.size());
  for (std::size_t i = 0; i < reaches.size(); ++i) reaches[i] = reaches_of(i);
  tables->reaches = std::move(reaches);
}

/// What either form of the lens lets pass, so that both draw the same positions.
PupilReaches PrescriptionSampler::reaches_of(std::size_t index) const {
  constexpr float kMiddle[2][kPacket] = {};
  const auto passes = [&](double r_mm, const PupilPositions& at, bool passing[kPacket]) {
    // a photosite without extent at (0, -r), where the lens frame's axes are the picture's
    const auto radius_m = static_cast<float>(1e-3 * r_mm);
    const PixelFrame frame{
        .x_m = 0, .y_m = -radius_m, .pitch_m = 0, .radial_x = 0, .radial_y = -1, .radius_m = radius_m};
    LensPacket rays;
    PupilPacket by_polynomials, traced;
    sample_polynomials(frame, index, kMiddle, at, rays, by_polynomials);
    sample_traced(frame, index, kMiddle, at, rays, traced);
    for (int i = 0; i < kPacket; ++i) passing[i] = by_polynomials.weight[i] > 0 || traced.weight[i] > 0;
  };
  return find_reaches(tables_->polynomials[index].bounds, passes);
}

double PrescriptionSampler::lux_per_nit() const { return tables_->axis_area; }
bool PrescriptionSampler::has_color() const { return tables_->has_color; }

double PrescriptionSampler::chief_slope_per_m(double radius_m) const {
  if (radius_m == 0) return 0;
  const double spacing = tables_->polynomials.front().bounds.image_radius_mm * 1e-3 / (PupilBounds::kNodes - 1);
  return interpolate_odd(tables_->chief_slopes, spacing, radius_m).value / radius_m;
}

void PrescriptionSampler::sample_polynomials(const PixelFrame& f, std::size_t index, const float s[2][kPacket],
                                             const PupilPositions& at, LensPacket& out, PupilPacket& pupil) const {
  const RayPolynomials& lens = tables_->polynomials[index];
  const auto radius_m = static_cast<float>(f.radius_m);
  const double r_mm = radius_m * 1e3;
  const PupilEllipse ellipse = lens.bounds.at(r_mm);
  const RayPolynomial c = lens.at(r_mm);
  const auto [xx, xy, yx, yy] = axes_of(f);
  const PupilTerms terms(at.x, at.y);
  alignas(64) float origin_x[kPacket], origin_y[kPacket], slope_x[kPacket], slope_y[kPacket], stop_x[kPacket],
      stop_y[kPacket], rim[kPacket];
  terms.odd<kSlopeDegree - 1>(c.slope_x, slope_x);
  terms.even<kSlopeDegree>(c.slope_y, slope_y);
  terms.odd<kSmoothDegree - 1>(c.origin_x, origin_x);
  terms.even<kSmoothDegree>(c.origin_y, origin_y);
  terms.odd<kSmoothDegree - 1>(c.stop_x, stop_x);
  terms.even<kSmoothDegree>(c.stop_y, stop_y);
  const auto full = static_cast<float>(M_PI * ellipse.half_l * ellipse.half_m / tables_->axis_area);
  for (int i = 0; i < kPacket; ++i) {
    pupil.weight[i] = stop_x[i] * stop_x[i] + stop_y[i] * stop_y[i] <= 1 ? full * at.area[i] : 0.0f;
  }
  for (std::size_t k = 0; k < lens.rims.size(); ++k) {
    terms.even<kRimDegree>(c.rim[k], rim);
    for (int i = 0; i < kPacket; ++i) pupil.weight[i] = rim[i] <= 1 ? pupil.weight[i] : 0.0f;
  }
  // Within the photosite the whole bundle turns as the chief ray does.
  const double spacing = lens.bounds.image_radius_mm * 1e-3 / (PupilBounds::kNodes - 1);
  const Odd chief = interpolate_odd(tables_->chief_slopes, spacing, radius_m);
  const auto turn_r = static_cast<float>(chief.slope);
  const auto turn_a = static_cast<float>(radius_m > 0 ? chief.value / radius_m : chief.slope);
  const auto chief_n = static_cast<float>(std::sqrt(std::max(1 - ellipse.chief_m * ellipse.chief_m, 1e-9)));
  const float chief_at_sensor = yx * static_cast<float>(ellipse.chief_m) / chief_n;
  const auto half_l = static_cast<float>(ellipse.half_l), half_m = static_cast<float>(ellipse.half_m);
  const auto center_m = static_cast<float>(ellipse.center_m);
  for (int i = 0; i < kPacket; ++i) {
    const float dx = (s[0][i] - 0.5f) * f.pitch_m, dy = (s[1][i] - 0.5f) * f.pitch_m;
    const float dr = turn_r * (dx * f.radial_x + dy * f.radial_y);
    const float da = turn_a * (-dx * f.radial_y + dy * f.radial_x);
    out.origin_x[i] = 1e-3f * (origin_x[i] * xx + origin_y[i] * yx);
    out.origin_y[i] = 1e-3f * (origin_x[i] * xy + origin_y[i] * yy);
    out.slope_x[i] = slope_x[i] * xx + slope_y[i] * yx + dr * f.radial_x - da * f.radial_y;
    out.slope_y[i] = slope_x[i] * xy + slope_y[i] * yy + dr * f.radial_y + da * f.radial_x;
    pupil.p[i] = stop_x[i] * xx + stop_y[i] * yx;
    const float l = half_l * at.x[i], m = center_m + half_m * at.y[i];
    const float n = std::sqrt(std::max(1 - l * l - m * m, 1e-9f));
    pupil.t[i] = (l * xx + m * yx) / n - chief_at_sensor;
  }
  block_stray(out, pupil.weight);
  pupil.chief_slope = chief_at_sensor;
}

void PrescriptionSampler::sample_traced(const PixelFrame& f, std::size_t index, const float s[2][kPacket],
                                        const PupilPositions& at, LensPacket& out, PupilPacket& pupil) const {
  const TracedLens<float>& lens = tables_->traced[index];
  const auto radius_m = static_cast<float>(f.radius_m);
  const PupilBounds& bounds = tables_->polynomials[index].bounds;
  const double r_mm = 1e3 * radius_m, step_mm = 500.0 * std::max(static_cast<double>(f.pitch_m), 1e-9);
  const PupilEllipse ellipse = bounds.at(r_mm);
  const auto [xx, xy, yx, yy] = axes_of(f);
  // over the photosite the ellipse moves, and turns about the axis
  const double behind_mm = std::max(r_mm - step_mm, 0.0);
  const auto turn_r = static_cast<float>((bounds.at(r_mm + step_mm).center_m - bounds.at(behind_mm).center_m) /
                                         (r_mm + step_mm - behind_mm));
  const auto turn_a = static_cast<float>(r_mm > step_mm ? ellipse.center_m / r_mm : turn_r);
  const auto half_l = static_cast<float>(ellipse.half_l), half_m = static_cast<float>(ellipse.half_m);
  const auto center_m = static_cast<float>(ellipse.center_m);
  const auto chief_n = static_cast<float>(std::sqrt(std::max(1 - ellipse.chief_m * ellipse.chief_m, 1e-9)));
  const float chief_at_sensor = yx * static_cast<float>(ellipse.chief_m) / chief_n;
  RayBatch<float, kPacket> rays;
  for (int i = 0; i < kPacket; ++i) {
    const float dx_mm = 1e3f * (s[0][i] - 0.5f) * f.pitch_m, dy_mm = 1e3f * (s[1][i] - 0.5f) * f.pitch_m;
    const float l = half_l * at.x[i] + turn_a * (dx_mm * f.radial_y - dy_mm * f.radial_x);
    const float m = center_m + half_m * at.y[i] + turn_r * (dx_mm * f.radial_x + dy_mm * f.radial_y);
    rays.x[i] = -1e3f * f.x_m - dx_mm;
    rays.y[i] = -1e3f * f.y_m - dy_mm;
    rays.z[i] = static_cast<float>(lens.sensor_z_mm());
    rays.l[i] = l * xx + m * yx;
    rays.m[i] = l * xy + m * yy;
    const float rest = 1 - l * l - m * m;
    rays.n[i] = -std::sqrt(std::max(rest, 1e-6f));
    rays.end[i] = rest > 1e-6f ? 0.0f : 1.0f;
    pupil.t[i] = rays.l[i] / -rays.n[i] - chief_at_sensor;
  }
  lens.trace(rays);
  move_to_plane(rays, static_cast<float>(tables_->entrance_pupil_z_mm));
  const auto full = static_cast<float>(M_PI * ellipse.half_l * ellipse.half_m / tables_->axis_area);
  for (int i = 0; i < kPacket; ++i) {
    out.origin_x[i] = 1e-3f * rays.x[i];
    out.origin_y[i] = 1e-3f * rays.y[i];
    out.slope_x[i] = rays.l[i] / -rays.n[i];
    out.slope_y[i] = rays.m[i] / -rays.n[i];
    pupil.p[i] = rays.stop_x[i];
    pupil.weight[i] = rays.end[i] == 0 ? full * at.area[i] : 0.0f;
  }
  block_stray(out, pupil.weight);
  pupil.chief_slope = chief_at_sensor;
}

void PrescriptionSampler::sample(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out,
                                 PupilPacket& pupil) const {
  const std::size_t index = tables_->index(color, f.draw);
  const auto [xx, xy, yx, yy] = axes_of(f);
  alignas(64) float q[2][kPacket];
  concentric_disc(s[2], s[3], q[0], q[1]);
  PupilPositions at;
  for (int i = 0; i < kPacket; ++i) {
    at.x[i] = q[0][i] * xx + q[1][i] * xy;
    at.y[i] = q[0][i] * yx + q[1][i] * yy;
    at.area[i] = 1;
  }
  tables_->reaches[index].at(1e3 * f.radius_m, tables_->polynomials[index].bounds.image_radius_mm).draw_in(at);
  tables_->exact_trace ? sample_traced(f, index, s, at, out, pupil) : sample_polynomials(f, index, s, at, out, pupil);
}

}  // namespace dualpixel::simulator
