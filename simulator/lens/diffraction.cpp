#include "simulator/lens/diffraction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dualpixel::simulator {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kStretchSteps = 128;
constexpr double kLeastBend = 1e-2, kMostBend = 1e3;  // the table's ends, lambda times the f-number
constexpr double kFarthest = 100;                     // of the pattern, likewise

/// Share of the light that bends by less than `bend`, over a round pupil.
double bent_share(double bend) {
  constexpr int kRings = 400, kAngles = 16;
  double share = 0;
  for (int ring = 0; ring < kRings; ++ring) {
    const double rho = std::sqrt((ring + 0.5) / kRings);
    // standard deviations in lambda N: 2 N lambda / (4 pi d), d in pupil radii
    const double across = 1 / (2 * kPi * (1 - rho)), along = 1 / (2 * kPi * std::sqrt(1 - rho * rho));
    for (int i = 0; i < kAngles; ++i) {
      const double angle = (i + 0.5) / kAngles * kPi / 2;
      const double curvature = std::pow(std::cos(angle) / across, 2) + std::pow(std::sin(angle) / along, 2);
      share += -std::expm1(-0.5 * bend * bend * curvature) / (curvature * across * along);
    }
  }
  return share / (kRings * kAngles);
}

double airy_share(double r) {
  const double x = kPi * r, j0 = std::cyl_bessel_j(0.0, x), j1 = std::cyl_bessel_j(1.0, x);
  return 1 - j0 * j0 - j1 * j1;
}

/// The radius that holds a share of the Airy pattern's light.
double airy_radius(double share) {
  double low = 0, high = kFarthest;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (airy_share(middle) < share ? low : high) = middle;
  }
  return low;
}

}  // namespace

Diffraction::Diffraction(const ThinLens& thin) : pupil_radius_m_(0.5 * thin.pupil_diameter_m()) {
  for (int i = 0; i <= kStretchSteps; ++i) {
    const double bend = kLeastBend * std::pow(kMostBend / kLeastBend, static_cast<double>(i) / kStretchSteps);
    stretch_.push_back(static_cast<float>(airy_radius(bent_share(bend)) / bend));
  }
}

double Diffraction::stretch(double bend) const {
  constexpr double kStepsPerOctave = kStretchSteps / 16.6096404744368;  // log2 of the table's range
  const double at =
      std::clamp(std::log2(std::max(bend, 1e-9) / kLeastBend) * kStepsPerOctave, 0.0, kStretchSteps - 1e-6);
  const auto k = static_cast<std::size_t>(at);
  return stretch_[k] + (at - static_cast<double>(k)) * (stretch_[k + 1] - stretch_[k]);
}

void Diffraction::bend(double wavelength_m, const float u[kPacket], const float v[kPacket], LensPacket& rays) const {
  constexpr double kNearestEdge = 1e-4;                            // pupil radii
  const double slope_unit = wavelength_m / (2 * pupil_radius_m_);  // lambda times the f-number, as a slope
  for (int i = 0; i < kPacket; ++i) {
    const double x = rays.origin_x[i], y = rays.origin_y[i], r = std::hypot(x, y);
    const double rho = std::min(r / pupil_radius_m_, 1 - kNearestEdge);
    const double radial_x = r > 0 ? x / r : 1, radial_y = r > 0 ? y / r : 0;
    const double length = std::sqrt(-2 * std::log(1 - static_cast<double>(u[i]))), angle = 2 * kPi * v[i];
    const double across = length * std::cos(angle) / (2 * kPi * (1 - rho));
    const double along = length * std::sin(angle) / (2 * kPi * std::sqrt(1 - rho * rho));
    const double bend = std::hypot(across, along);
    const double turn = slope_unit * std::min(stretch(bend), kFarthest / std::max(bend, 1e-9));
    rays.slope_x[i] += static_cast<float>(turn * (across * radial_x - along * radial_y));
    rays.slope_y[i] += static_cast<float>(turn * (across * radial_y + along * radial_x));
  }
}

}  // namespace dualpixel::simulator
