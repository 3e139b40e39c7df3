#pragma once
#include <vector>

#include "simulator/lens/prescription/pupil_bounds.h"

/// The fast form of a prescription: for each distance from the axis, polynomials from the position in the pupil ellipse
/// to the ray in front of the lens. The lens has an axis, so a sensor point is turned into (0, r) of the lens frame
/// first; there the lens is symmetric about x = 0, and each output is an even or an odd function of the ellipse's x.
namespace dualpixel::simulator {

/// Terms x^(2 i) y^j with 2 i + j <= degree, i by i. An odd function is x times an even one of a degree less.
constexpr int count_terms(int degree) {
  int count = 0;
  for (int i = 0; 2 * i <= degree; ++i) count += degree - 2 * i + 1;
  return count;
}
/// Slopes hold the aberrations, to the twelfth order and beyond in phone lenses; the rest is smooth.
inline constexpr int kSlopeDegree = 16;
inline constexpr int kSmoothDegree = 8;
inline constexpr int kRimDegree = 6;
inline constexpr int kMostRims = 8;

/// Polynomials at one distance from the axis. Origins in mm where the ray crosses the entrance pupil's plane, slopes
/// per unit of camera z, stop in stop radii; rims: (r / clear radius)^2 on each surface that ever clips.
struct RayPolynomial {
  float slope_x[count_terms(kSlopeDegree - 1)];  ///< odd
  float slope_y[count_terms(kSlopeDegree)];
  float origin_x[count_terms(kSmoothDegree - 1)];  ///< odd
  float origin_y[count_terms(kSmoothDegree)];
  float stop_x[count_terms(kSmoothDegree - 1)];  ///< odd
  float stop_y[count_terms(kSmoothDegree)];
  float rim[kMostRims][count_terms(kRimDegree)];
};

struct RayPolynomials {
  PupilBounds bounds;
  std::vector<int> rims;  ///< the surfaces of RayPolynomial::rim, at most kMostRims
  std::vector<RayPolynomial> nodes;

  RayPolynomial at(double r_mm) const;
};

RayPolynomials fit_ray_polynomials(const Prescription& lens, double wavelength_nm, const PupilBounds& bounds,
                                   double entrance_pupil_z_mm);

}  // namespace dualpixel::simulator
