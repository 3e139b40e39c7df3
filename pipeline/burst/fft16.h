#pragma once
#include "capture/lanes.h"

/// The two-dimensional discrete Fourier transform of 16 x 16 complex samples, eight columns at a time.
namespace dualpixel::pipeline::fft16 {

inline constexpr int kTile = 16;
inline constexpr int kHalves = kTile / kLanes;

/// Row by row; half h of a row holds its columns 8h to 8h + 7. Two real tiles travel as one complex tile: in a spectrum
/// Z of a + ib, with * for the conjugate,  A(k) = (Z(k) + Z*(-k)) / 2  and  i B(k) = (Z(k) - Z*(-k)) / 2.
struct ComplexTile {
  Lanes re[kTile][kHalves];
  Lanes im[kTile][kHalves];
};

/// Factors by which a spectrum is multiplied along one axis.
struct Phases {
  float re[kTile];
  float im[kTile];
};

/// X(k) = sum over x of t(x) exp(-2 pi i k x / 16) along both axes, times along_x(kx) along_y(ky), in place. The
/// spectrum is left transposed: rows are kx, columns ky.
void transform(ComplexTile& tile, const Phases& along_x, const Phases& along_y);
void transform(ComplexTile& tile);

/// Undoes transform() but for a factor of 256.
void transform_back(ComplexTile& spectrum);

}  // namespace dualpixel::pipeline::fft16
