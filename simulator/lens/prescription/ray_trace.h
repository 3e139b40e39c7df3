#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "simulator/lens/prescription/prescription.h"

/// Real rays through a prescription, many at a time, in double for figures and in float for rendering; no branch
/// depends on a ray. Lens frame, mm. Towards the sensor or back towards the scene by the sign of the rays' n.
namespace dualpixel::simulator {

/// What became of a ray. Everything but `through` carries no light and keeps finite coordinates.
enum class RayEnd : int {
  through = 0,
  clipped = 1,    ///< outside a clear aperture
  missed = 2,     ///< no intersection with a surface
  reflected = 3,  ///< total internal reflection
};

template <class Real, int N>
struct RayBatch {
  alignas(64) Real x[N], y[N], z[N];      ///< a point of the ray
  alignas(64) Real l[N], m[N], n[N];      ///< its direction cosines
  alignas(64) Real stop_x[N], stop_y[N];  ///< where it crossed the stop, in stop radii
  alignas(64) Real end[N];                ///< RayEnd, in Real so that lanes stay of one width; set to 0 before tracing
};

/// A surface with everything that does not depend on the ray worked out.
template <class Real>
struct TraceSurface {
  static constexpr int kEven = 15;  ///< r^2 ... r^30
  Real z, curvature, conic_plus_1;
  Real eta;                      ///< index before over index after, in the direction of light
  Real even[kEven], odd[kEven];  ///< coefficients of r^(2 i + 2) and of r^(2 i + 3)
  int even_terms = 0;            ///< 0 and no odd ones: a conic, met in closed form
  bool has_odd = false;
  Real clear_radius2;
  Real blocked_radius2;  ///< beyond it rays end: the clear aperture, or a little more where nothing is clipped
  /// Beyond edge_radius2 the surface continues as a paraboloid with the edge's height and slope, beyond reach_radius2
  /// flat: every ray meets it somewhere, and what an asphere does outside its aperture can't get in the way.
  Real edge_radius2, edge_slope, reach_radius2;
  Real sag_low, sag_high;        ///< all of the surface lies between
  Real inverse_stop_radius = 0;  ///< 0: not the stop
};

template <class Real>
class TracedLens {
 public:
  /// For light of one wavelength. `clip` false lets rays pass outside clear apertures, up to 1.25 times their radius,
  /// and a plane stop everywhere.
  TracedLens(const Prescription& lens, double wavelength_nm, bool clip = true);

  /// Traces rays with n > 0 from any plane before the lens to its last surface, rays with n < 0 from behind it to its
  /// first. `largest_r2`, where given, receives for each surface and lane (r / clear radius)^2.
  template <int N>
  void trace(RayBatch<Real, N>& rays, Real (*largest_r2)[N] = nullptr) const;

  const std::vector<TraceSurface<Real>>& surfaces() const { return surfaces_; }
  double sensor_z_mm() const { return sensor_z_mm_; }

 private:
  std::vector<TraceSurface<Real>> surfaces_;
  double sensor_z_mm_;
};

template <class Real, int N>
void move_to_plane(RayBatch<Real, N>& rays, Real z) {
  for (int i = 0; i < N; ++i) {
    const Real t = (z - rays.z[i]) / rays.n[i];
    rays.x[i] += t * rays.l[i];
    rays.y[i] += t * rays.m[i];
    rays.z[i] = z;
  }
}

namespace detail {

template <class Real>
struct Sag {
  Real z, slope;  ///< and dz / d(r^2)
};

/// Height at r2, continued beyond the edge. `Even` coefficients, compile-time so that lanes vectorise.
template <int Even, bool Odd, bool Slope, class Real>
inline Sag<Real> sag_at(const TraceSurface<Real>& s, Real r2) {
  const Real rr = std::min(r2, s.edge_radius2);
  const Real root = std::sqrt(std::max(Real(1) - s.conic_plus_1 * s.curvature * s.curvature * rr, Real(0)));
  Real poly = 0, dpoly = 0;
  for (int k = Even - 1; k >= 0; --k) {
    if (Slope) dpoly = dpoly * rr + poly;
    poly = poly * rr + s.even[k];
  }
  Sag<Real> sag{s.curvature * rr / (1 + root) + rr * poly, 0};
  if (Slope) sag.slope = s.curvature / (2 * std::max(root, Real(1e-6))) + poly + rr * dpoly;
  if (Odd) {
    const Real r = std::sqrt(rr);
    Real odd = 0, dodd = 0;
    for (int k = TraceSurface<Real>::kEven - 1; k >= 0; --k) {
      if (Slope) dodd = dodd * rr + odd;
      odd = odd * rr + s.odd[k];
    }
    sag.z += rr * r * odd;
    if (Slope) sag.slope += Real(1.5) * r * odd + rr * r * dodd;
  }
  sag.z += s.edge_slope * (std::min(r2, s.reach_radius2) - rr);
  if (Slope) {
    sag.slope = r2 <= s.edge_radius2 ? sag.slope : r2 <= s.reach_radius2 ? s.edge_slope : Real(0);
  }
  return sag;
}

/// Moves rays from the vertex plane (z relative to it) to the first intersection with an aspheric surface:
/// the slab that holds the surface is searched for the first change of sign, which Newton's method then cannot leave
/// for another root (a plain Newton from the conic does, on the strong aspheres of phone lenses).
template <int Even, bool Odd, class Real, int N>
void meet_asphere(const TraceSurface<Real>& s, RayBatch<Real, N>& rays, Real slope[N]) {
  constexpr int kSearch = sizeof(Real) == 4 ? 9 : 12;
  constexpr int kNewton = sizeof(Real) == 4 ? 4 : 7;
  alignas(64) Real enter[N], step[N], low[N], high[N], t[N];
  const bool forward = rays.n[0] > 0;
  const Real side = forward ? Real(1) : Real(-1);  // the sign of f behind the surface, as the ray sees it
  for (int i = 0; i < N; ++i) {
    const Real inverse = 1 / rays.n[i];
    enter[i] = (forward ? s.sag_low : s.sag_high) * inverse;
    high[i] = (forward ? s.sag_high : s.sag_low) * inverse;
    step[i] = (high[i] - enter[i]) / kSearch;
  }
  for (int k = kSearch - 1; k >= 1; --k) {  // what remains at the end is the first point behind the surface
    for (int i = 0; i < N; ++i) {
      const Real here = enter[i] + k * step[i];
      const Real x = rays.x[i] + here * rays.l[i], y = rays.y[i] + here * rays.m[i];
      const Real f = here * rays.n[i] - sag_at<Even, Odd, false>(s, x * x + y * y).z;
      high[i] = f * side >= 0 ? here : high[i];
    }
  }
  for (int i = 0; i < N; ++i) {
    low[i] = high[i] - step[i];
    t[i] = high[i] - step[i] / 2;
  }
  for (int k = 0; k < kNewton; ++k) {
    for (int i = 0; i < N; ++i) {
      const Real x = rays.x[i] + t[i] * rays.l[i], y = rays.y[i] + t[i] * rays.m[i];
      const Sag<Real> sag = sag_at<Even, Odd, true>(s, x * x + y * y);
      const Real f = t[i] * rays.n[i] - sag.z;
      const Real df = rays.n[i] - 2 * sag.slope * (x * rays.l[i] + y * rays.m[i]);
      const bool behind = f * side >= 0;
      high[i] = behind ? t[i] : high[i];
      low[i] = behind ? low[i] : t[i];
      const Real newton = t[i] - f / (std::abs(df) > Real(1e-12) ? df : Real(1e-12));
      t[i] = newton >= low[i] && newton <= high[i] ? newton : (low[i] + high[i]) / 2;
    }
  }
  for (int i = 0; i < N; ++i) {
    rays.x[i] += t[i] * rays.l[i];
    rays.y[i] += t[i] * rays.m[i];
    rays.z[i] = t[i] * rays.n[i];
    slope[i] = sag_at<Even, Odd, true>(s, rays.x[i] * rays.x[i] + rays.y[i] * rays.y[i]).slope;
  }
}

/// The same for a conic, in closed form: of the two roots the one that lies on the vertex's branch.
template <class Real, int N>
void meet_conic(const TraceSurface<Real>& s, RayBatch<Real, N>& rays, Real slope[N]) {
  const Real c = s.curvature;
  for (int i = 0; i < N; ++i) {
    const Real l = rays.l[i], m = rays.m[i], n = rays.n[i], x = rays.x[i], y = rays.y[i];
    const Real a = c * (l * l + m * m + s.conic_plus_1 * n * n);
    const Real b = n - c * (x * l + y * m);
    const Real d = c * (x * x + y * y);
    const Real discriminant = b * b - a * d;
    const Real root = std::sqrt(std::max(discriminant, Real(0)));
    const Real denominator = n > 0 ? b + root : b - root;
    const Real t = d / (std::abs(denominator) > Real(1e-12) ? denominator : Real(1e-12));
    const bool met = discriminant >= 0 && denominator * n > 0;
    rays.end[i] = met || rays.end[i] != 0 ? rays.end[i] : Real(RayEnd::missed);
    const Real step = met ? t : Real(0);
    rays.x[i] = x + step * l;
    rays.y[i] = y + step * m;
    rays.z[i] = step * n;
    const Real r2 = rays.x[i] * rays.x[i] + rays.y[i] * rays.y[i];
    const Real under = 1 - s.conic_plus_1 * c * c * r2;
    slope[i] = c / (2 * std::sqrt(std::max(under, Real(1e-6))));
  }
}

template <class Real, int N>
void meet(const TraceSurface<Real>& s, RayBatch<Real, N>& rays, Real slope[N]) {
  if (s.even_terms == 0 && !s.has_odd) return meet_conic(s, rays, slope);
  if (s.has_odd) return meet_asphere<TraceSurface<Real>::kEven, true>(s, rays, slope);
  if (s.even_terms <= 5) return meet_asphere<5, false>(s, rays, slope);
  if (s.even_terms <= 8) return meet_asphere<8, false>(s, rays, slope);
  if (s.even_terms <= 10) return meet_asphere<10, false>(s, rays, slope);
  meet_asphere<TraceSurface<Real>::kEven, false>(s, rays, slope);
}

/// Snell's law in vector form; `eta` is the index where the ray is over the index where it goes.
template <class Real, int N>
void refract(Real eta, const Real slope[N], RayBatch<Real, N>& rays) {
  for (int i = 0; i < N; ++i) {
    Real nx = -2 * rays.x[i] * slope[i], ny = -2 * rays.y[i] * slope[i], nz = 1;
    const Real scale = (rays.n[i] > 0 ? Real(1) : Real(-1)) / std::sqrt(nx * nx + ny * ny + 1);
    nx *= scale;
    ny *= scale;
    nz *= scale;
    const Real cosine = nx * rays.l[i] + ny * rays.m[i] + nz * rays.n[i];
    const Real squared = 1 - eta * eta * (1 - cosine * cosine);
    const bool passes = squared > 0 && cosine > 0;
    const Real along = std::sqrt(std::max(squared, Real(0))) - eta * cosine;
    rays.end[i] = passes || rays.end[i] != 0 ? rays.end[i] : Real(RayEnd::reflected);
    const Real l = eta * rays.l[i] + along * nx;
    const Real m = eta * rays.m[i] + along * ny;
    const Real n = eta * rays.n[i] + along * nz;
    // a ray that turns round is numerically lost: keep it as it was, it is blocked
    const bool keeps_on = passes && n * rays.n[i] > 0;
    rays.end[i] = keeps_on || rays.end[i] != 0 ? rays.end[i] : Real(RayEnd::missed);
    rays.l[i] = keeps_on ? l : rays.l[i];
    rays.m[i] = keeps_on ? m : rays.m[i];
    rays.n[i] = keeps_on ? n : rays.n[i];
  }
}

}  // namespace detail

template <class Real>
template <int N>
void TracedLens<Real>::trace(RayBatch<Real, N>& rays, Real (*largest_r2)[N]) const {
  const bool forward = rays.n[0] > 0;
  const int count = static_cast<int>(surfaces_.size());
  alignas(64) Real slope[N];
  for (int step = 0; step < count; ++step) {
    const int index = forward ? step : count - 1 - step;
    const TraceSurface<Real>& s = surfaces_[index];
    move_to_plane(rays, s.z);
    detail::meet(s, rays, slope);
    for (int i = 0; i < N; ++i) {
      const Real r2 = rays.x[i] * rays.x[i] + rays.y[i] * rays.y[i];
      rays.end[i] = r2 <= s.blocked_radius2 || rays.end[i] != 0 ? rays.end[i] : Real(RayEnd::clipped);
      if (largest_r2) largest_r2[index][i] = r2 / s.clear_radius2;
    }
    if (s.inverse_stop_radius != 0) {
      for (int i = 0; i < N; ++i) {
        rays.stop_x[i] = rays.x[i] * s.inverse_stop_radius;
        rays.stop_y[i] = rays.y[i] * s.inverse_stop_radius;
      }
    }
    for (int i = 0; i < N; ++i) rays.z[i] += s.z;
    if (s.eta != 1) detail::refract<Real, N>(forward ? s.eta : 1 / s.eta, slope, rays);
  }
}

}  // namespace dualpixel::simulator
