#include "simulator/lens/prescription/ray_trace.h"

#include <limits>

namespace dualpixel::simulator {
namespace {

/// Surfaces follow their formula to the first of these times their clear radius, and continue smoothly to the second.
constexpr double kEdge = 1.05, kReach = 1.25;

template <class Real>
TraceSurface<Real> prepare(const LensSurface& surface, double z, double n_before, double n_after, bool clip) {
  TraceSurface<Real> s{};
  s.z = static_cast<Real>(z);
  s.curvature = static_cast<Real>(surface.curvature_per_mm);
  s.conic_plus_1 = static_cast<Real>(1 + surface.conic);
  s.eta = static_cast<Real>(n_before / n_after);
  for (const auto& [power, a] : surface.terms) {
    if (a == 0) continue;
    if (power % 2 == 0) {
      s.even[power / 2 - 1] += static_cast<Real>(a);
      s.even_terms = std::max(s.even_terms, power / 2);
    } else {
      s.odd[(power - 3) / 2] += static_cast<Real>(a);
      s.has_odd = true;
    }
  }
  const double clear = surface.semi_diameter_mm;
  const double reach = kReach * clear;
  if (surface.stop) s.inverse_stop_radius = static_cast<Real>(1 / clear);
  s.clear_radius2 = static_cast<Real>(clear * clear);
  // rays that are not to be clipped must find the middle of the stop, however small it is; a stop on glass continues
  // only as far as its surface does
  const bool plane = surface.curvature_per_mm == 0 && surface.terms.empty();
  const double free_radius = surface.stop && plane ? std::numeric_limits<double>::infinity() : reach;
  s.blocked_radius2 = static_cast<Real>(clip ? clear * clear : free_radius * free_radius);
  double edge = kEdge * clear;
  const double conic = (1 + surface.conic) * surface.curvature_per_mm * surface.curvature_per_mm;
  if (conic > 0) edge = std::min(edge, std::max(clear, 0.999 / std::sqrt(conic)));
  s.edge_radius2 = static_cast<Real>(edge * edge);
  s.reach_radius2 = static_cast<Real>(reach * reach);
  const double nearby = 1e-4 * edge;
  const double edge_sag = sag_mm(surface, edge);
  const double edge_slope = (edge_sag - sag_mm(surface, edge - nearby)) / (nearby * (2 * edge - nearby));
  s.edge_slope = static_cast<Real>(edge_slope);
  const double end_sag = edge_sag + edge_slope * (reach * reach - edge * edge);
  double low = std::min(0.0, end_sag), high = std::max(0.0, end_sag);
  constexpr int kSteps = 512;
  for (int i = 0; i <= kSteps; ++i) {
    const double sag = sag_mm(surface, edge * i / kSteps);
    low = std::min(low, sag);
    high = std::max(high, sag);
  }
  const double margin = 1e-3 * (high - low) + 1e-6 * clear;  // extremes between the steps
  s.sag_low = static_cast<Real>(low - margin);
  s.sag_high = static_cast<Real>(high + margin);
  return s;
}

}  // namespace

template <class Real>
TracedLens<Real>::TracedLens(const Prescription& lens, double wavelength_nm, bool clip) {
  double z = 0, n = 1;
  for (const LensSurface& surface : lens.surfaces) {
    const double after = refractive_index(surface.after, wavelength_nm);
    surfaces_.push_back(prepare<Real>(surface, z, n, after, clip));
    n = after;
    z += surface.thickness_mm;
  }
  sensor_z_mm_ = z;
}

template class TracedLens<float>;
template class TracedLens<double>;

}  // namespace dualpixel::simulator
