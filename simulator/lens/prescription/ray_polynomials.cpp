#include "simulator/lens/prescription/ray_polynomials.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "simulator/lens/prescription/cubic.h"

namespace dualpixel::simulator {
namespace {

constexpr int kFitLanes = 16;

/// Rays of one node with their positions in the ellipse: what a polynomial is fitted to.
struct Bundle {
  std::vector<double> x, y;
  std::vector<double> origin_x, origin_y, slope_x, slope_y, stop_x, stop_y;
  std::vector<std::vector<double>> rim2;  ///< for each surface, its own stop included
  std::vector<double> largest_rim2;       ///< of all surfaces
};

/// Positions on rings out to the rim of the unit disc; its right half, since the left one follows by symmetry.
std::vector<std::pair<double, double>> fitting_positions() {
  std::vector<std::pair<double, double>> positions;
  constexpr int kRings = 16;
  for (int ring = 0; ring <= kRings; ++ring) {
    const double rho = std::sin(0.5 * M_PI * ring / kRings);  // denser towards the rim, where polynomials err
    const int around = std::max(1, 2 * ring);
    for (int i = 0; i < around; ++i) {
      const double phi = M_PI * ((i + 0.5) / around - 0.5);
      positions.emplace_back(rho * std::cos(phi), rho * std::sin(phi));
    }
  }
  return positions;
}

Bundle trace_bundle(const TracedLens<double>& unclipped, double r, const PupilEllipse& ellipse, double pupil_z) {
  const auto count = unclipped.surfaces().size();
  Bundle bundle;
  bundle.rim2.resize(count);
  const std::vector<std::pair<double, double>> positions = fitting_positions();
  RayBatch<double, kFitLanes> rays;
  std::vector<double> storage(count * kFitLanes);
  auto* rim2 = reinterpret_cast<double(*)[kFitLanes]>(storage.data());
  for (std::size_t first = 0; first < positions.size(); first += kFitLanes) {
    for (std::size_t i = 0; i < kFitLanes; ++i) {
      const auto& [x, y] = positions[std::min(first + i, positions.size() - 1)];
      rays.x[i] = 0, rays.y[i] = r, rays.z[i] = unclipped.sensor_z_mm();
      rays.l[i] = ellipse.half_l * x;
      rays.m[i] = ellipse.center_m + ellipse.half_m * y;
      const double rest = 1 - rays.l[i] * rays.l[i] - rays.m[i] * rays.m[i];
      rays.n[i] = -std::sqrt(std::max(rest, 1e-9));
      rays.end[i] = rest > 1e-6 ? 0 : 1;
    }
    unclipped.trace(rays, rim2);
    move_to_plane(rays, pupil_z);
    for (std::size_t i = 0; i < kFitLanes && first + i < positions.size(); ++i) {
      if (rays.end[i] != 0 || -rays.n[i] < 0.02) continue;
      bundle.x.push_back(positions[first + i].first);
      bundle.y.push_back(positions[first + i].second);
      bundle.origin_x.push_back(rays.x[i]);
      bundle.origin_y.push_back(rays.y[i]);
      bundle.slope_x.push_back(rays.l[i] / -rays.n[i]);
      bundle.slope_y.push_back(rays.m[i] / -rays.n[i]);
      bundle.stop_x.push_back(rays.stop_x[i]);
      bundle.stop_y.push_back(rays.stop_y[i]);
      double largest = 0;
      for (std::size_t s = 0; s < count; ++s) {
        bundle.rim2[s].push_back(rim2[s][i]);
        largest = std::max(largest, rim2[s][i]);
      }
      bundle.largest_rim2.push_back(largest);
    }
  }
  return bundle;
}

/// One least-squares problem over the rays that come within `reach` of every rim: beyond it the fit does not
/// matter, and strong aspheres send such rays anywhere.
class Fit {
 public:
  Fit(const Bundle& bundle, double reach, int degree, bool odd) {
    for (std::size_t i = 0; i < bundle.x.size(); ++i) {
      if (bundle.largest_rim2[i] <= reach) rows_.push_back(i);
    }
    const int terms = count_terms(degree);
    Eigen::MatrixXd a(rows_.size(), terms);
    for (Eigen::Index row = 0; row < a.rows(); ++row) {
      const double x = bundle.x[rows_[row]], y = bundle.y[rows_[row]];
      int column = 0;
      for (int i = 0; 2 * i <= degree; ++i) {
        for (int j = 0; 2 * i + j <= degree; ++j)
          a(row, column++) = std::pow(x, 2 * i + (odd ? 1 : 0)) * std::pow(y, j);
      }
    }
    enough_ = static_cast<int>(rows_.size()) >= terms + terms / 2;
    if (enough_) qr_.compute(a);
  }
  bool enough() const { return enough_; }

  template <int Count>
  void solve(const std::vector<double>& values, float (&coefficients)[Count]) const {
    Eigen::VectorXd b(rows_.size());
    for (Eigen::Index i = 0; i < b.size(); ++i) b[i] = values[rows_[i]];
    const Eigen::VectorXd c = qr_.solve(b);
    for (int i = 0; i < Count; ++i) coefficients[i] = static_cast<float>(c[i]);
  }

 private:
  std::vector<std::size_t> rows_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
  bool enough_ = false;
};

/// A ray that no surface passes: used where no polynomial can be fitted.
RayPolynomial blocked() {
  RayPolynomial p{};
  p.stop_y[0] = 2;
  return p;
}

}  // namespace

RayPolynomial RayPolynomials::at(double r_mm) const {
  const double u =
      std::clamp(r_mm / bounds.image_radius_mm * (PupilBounds::kNodes - 1), 0.0, PupilBounds::kNodes - 1.0);
  const int i = std::min(static_cast<int>(u), PupilBounds::kNodes - 2);
  const auto t = static_cast<float>(u - i);
  std::array<float, 4> w = cubic_weights(t);  // beyond the ends the last slope is extrapolated
  const int before = std::max(i - 1, 0), after = std::min(i + 2, PupilBounds::kNodes - 1);
  if (i == 0) w[1] += 2 * w[0], w[2] -= w[0], w[0] = 0;
  if (i + 2 == PupilBounds::kNodes) w[2] += 2 * w[3], w[1] -= w[3], w[3] = 0;
  const auto* a = reinterpret_cast<const float*>(&nodes[before]);
  const auto* b = reinterpret_cast<const float*>(&nodes[i]);
  const auto* c = reinterpret_cast<const float*>(&nodes[i + 1]);
  const auto* d = reinterpret_cast<const float*>(&nodes[after]);
  RayPolynomial result;
  auto* out = reinterpret_cast<float*>(&result);
  const auto used = (offsetof(RayPolynomial, rim) + rims.size() * sizeof(RayPolynomial::rim[0])) / sizeof(float);
  for (std::size_t k = 0; k < used; ++k) out[k] = w[0] * a[k] + w[1] * b[k] + w[2] * c[k] + w[3] * d[k];
  return result;
}

RayPolynomials fit_ray_polynomials(const Prescription& lens, double wavelength_nm, const PupilBounds& bounds,
                                   double entrance_pupil_z_mm) {
  const TracedLens<double> unclipped(lens, wavelength_nm, false);
  RayPolynomials result;
  result.bounds = bounds;
  result.nodes.assign(PupilBounds::kNodes, blocked());
  std::vector<Bundle> bundles(PupilBounds::kNodes);
  tbb::parallel_for(0, PupilBounds::kNodes, [&](int k) {
    const double r = bounds.image_radius_mm * k / (PupilBounds::kNodes - 1);
    if (bounds.nodes[k].half_m > 0) bundles[k] = trace_bundle(unclipped, r, bounds.nodes[k], entrance_pupil_z_mm);
  });

  // The surfaces that clip most rays, in that order.
  std::vector<std::pair<int, int>> clipping;
  for (std::size_t s = 0; s < lens.surfaces.size(); ++s) {
    if (lens.surfaces[s].stop) continue;
    int clipped = 0;
    for (const Bundle& bundle : bundles) {
      for (std::size_t i = 0; i < bundle.x.size(); ++i) {
        clipped += bundle.rim2[s][i] > 1 && bundle.rim2[s][i] == bundle.largest_rim2[i] ? 1 : 0;
      }
    }
    if (clipped > 0) clipping.emplace_back(clipped, static_cast<int>(s));
  }
  std::sort(clipping.rbegin(), clipping.rend());
  for (std::size_t i = 0; i < clipping.size() && i < kMostRims; ++i) result.rims.push_back(clipping[i].second);

  tbb::parallel_for(0, PupilBounds::kNodes, [&](int k) {
    const Bundle& bundle = bundles[k];
    constexpr double kNear = 1.05, kAround = 1.4;
    const Fit slope_odd(bundle, kNear, kSlopeDegree - 1, true), slope_even(bundle, kNear, kSlopeDegree, false);
    const Fit odd(bundle, kAround, kSmoothDegree - 1, true), even(bundle, kAround, kSmoothDegree, false);
    const Fit rims(bundle, kAround, kRimDegree, false);
    if (!slope_even.enough() || !slope_odd.enough() || !even.enough() || !odd.enough()) return;
    RayPolynomial& p = result.nodes[k];
    slope_odd.solve(bundle.slope_x, p.slope_x);
    slope_even.solve(bundle.slope_y, p.slope_y);
    odd.solve(bundle.origin_x, p.origin_x);
    even.solve(bundle.origin_y, p.origin_y);
    odd.solve(bundle.stop_x, p.stop_x);
    even.solve(bundle.stop_y, p.stop_y);
    for (std::size_t i = 0; i < result.rims.size(); ++i) rims.solve(bundle.rim2[result.rims[i]], p.rim[i]);
  });
  return result;
}

}  // namespace dualpixel::simulator
