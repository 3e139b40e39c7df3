#pragma once
#include <array>
#include <vector>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/thin/thin_lens.h"

namespace dualpixel::simulator {

/// Diffraction at the stop by bending rays. Heisenberg uncertainty ray bending (Freniere, Gregory & Hassler 1999, "Edge
/// diffraction in Monte Carlo ray tracing", Proc. SPIE 3780) bends a ray that passes an edge at distance d by a normal
/// angle of standard deviation lambda / (4 pi d): here across the stop's edge by its distance along the radius, and
/// along it by that along the chord. Over a round pupil that pattern has the Airy pattern's scale but not its shape:
/// its width at half maximum is 0.52 of Airy's, with wider tails. So the bend's length is mapped as a quantile of the
/// one distribution to that of the other: a ray near the edge still bends most, and of the whole pupil, in focus, the
/// Airy pattern remains (share of light within r, in lambda times the f-number: 1 - J0(pi r)^2 - J1(pi r)^2).
///
/// The edge is that of the paraxial pupil: rays of a prescription that pass beyond it bend as those as far within.
///
/// Not modeled: interference between rays, which rings out of focus and at the rim of a half pupil.
class Diffraction {
 public:
  explicit Diffraction(const ThinLens& thin);

  /// Turns rays at the entrance pupil, by two uniform numbers each.
  void bend(double wavelength_m, const float u[kPacket], const float v[kPacket], LensPacket& rays) const;

  /// The Airy pattern's radius, in lambda times the f-number, over the bend's, of a bend whose length has that square.
  float stretch(float bend_squared) const;

 private:
  double pupil_radius_m_;
  std::vector<float> stretch_;  ///< over the logarithm of the bend
};

/// Wavelengths of the R, G and B filter where a lens states none, meters: those of the shipped prescriptions.
inline constexpr std::array<double, 3> kFilterWavelengths_m = {610e-9, 540e-9, 465e-9};

}  // namespace dualpixel::simulator
