#include "simulator/lens/diffraction.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "simulator/sampling/packet.h"

namespace dualpixel::simulator {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kStretchSteps = 512;
constexpr double kLeastBend = 1e-2, kMostBend = 1e3;  // the table's ends, lambda times the f-number
constexpr double kFarthest = 100;                     // of the pattern, likewise
constexpr double kOctaves = 16.6096404744368;         // log2(kMostBend / kLeastBend)
constexpr float kLowestOctave = -6.64385619f;         // log2(kLeastBend)

/// log2 of a positive normal number, to 2e-5; without branches, so that loops over it become vectors.
inline float log2_of(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const float mantissa = std::bit_cast<float>((bits & 0x7fffff) | 0x3f800000);
  const float t = (mantissa - 1) / (mantissa + 1), t2 = t * t;
  constexpr float kScale = 2 / std::numbers::ln2_v<float>;
  const float fraction = kScale * t * (1 + t2 * (1.0f / 3 + t2 * (1.0f / 5 + t2 * (1.0f / 7))));
  return static_cast<float>((bits >> 23) - 127) + fraction;
}

/// Share of the light that bends by less than `bend`, over a round pupil.
double bent_share(double bend) {
  constexpr int kRings = 300, kAngles = 8;
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

float Diffraction::stretch(float bend_squared) const {
  constexpr auto kStepsPerOctave = static_cast<float>(kStretchSteps / kOctaves);
  const float octaves = 0.5f * log2_of(std::max(bend_squared, 1e-20f)) - kLowestOctave;
  const float at = std::clamp(octaves * kStepsPerOctave, 0.0f, kStretchSteps - 1e-3f);
  const int k = static_cast<int>(at);
  return stretch_[k] + (at - static_cast<float>(k)) * (stretch_[k + 1] - stretch_[k]);
}

void Diffraction::bend(double wavelength_m, const float u[kPacket], const float v[kPacket], LensPacket& rays) const {
  constexpr float kNearestEdge = 1e-4f;  // pupil radii
  constexpr auto kTurn = static_cast<float>(2 * kPi), kLn2 = std::numbers::ln2_v<float>;
  const auto radius = static_cast<float>(pupil_radius_m_);
  const auto slope_unit = static_cast<float>(wavelength_m / (2 * pupil_radius_m_));  // lambda N, as a slope
  alignas(64) float px[kPacket], py[kPacket];
  concentric_disc(u, v, px, py);
  for (int i = 0; i < kPacket; ++i) {
    const float x = rays.origin_x[i], y = rays.origin_y[i], r = std::sqrt(x * x + y * y) + 1e-12f;
    const float rho = 1 - std::max(std::abs(1 - r / radius), kNearestEdge);
    // two normal numbers from a point of the disc (Marsaglia 1962)
    const float s = std::clamp(px[i] * px[i] + py[i] * py[i], 1e-12f, 1.0f);
    const float normal = std::sqrt(-2 * kLn2 * log2_of(s) / s);
    const float across = px[i] * normal / (kTurn * (1 - rho));
    const float along = py[i] * normal / (kTurn * std::sqrt(1 - rho * rho));
    const float bend_squared = across * across + along * along + 1e-20f;
    const auto farthest = static_cast<float>(kFarthest) / std::sqrt(bend_squared);
    const float turn = slope_unit * std::min(stretch(bend_squared), farthest) / r;
    rays.slope_x[i] += turn * (across * x - along * y);
    rays.slope_y[i] += turn * (across * y + along * x);
  }
}

}  // namespace dualpixel::simulator
