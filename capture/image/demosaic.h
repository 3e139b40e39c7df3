#pragma once
#include <array>
#include <optional>
#include <string>

#include "capture/image/image.h"
#include "capture/matrix3.h"

/// From a Bayer mosaic to linear RGB of the same size.
namespace dualpixel {

/// Balanced white: the smallest of the gains, where the first of the three colors reaches its white level. Beyond it a
/// neutral highlight would turn pink.
double balanced_white(const std::array<double, 3>& gains);

/// The mosaic with each photosite multiplied by its color's gain, then clipped at balanced_white().
/// `cfa` names the colors of the top-left 2x2 photosites row by row ("RGGB"); `gains` are R, G, B.
Image white_balanced(Image mosaic, const std::string& cfa, const std::array<double, 3>& gains);

/// Gradient-corrected linear interpolation: Malvar, He, Cutler 2004, "High-Quality Linear Interpolation for Demosaicing
/// of Bayer-Patterned Color Images", Fig. 2. It takes colors to be balanced. The mosaic is mirrored about its
/// outermost photosites, which keeps the phase of the pattern. Values may overshoot the mosaic's range at edges.
Image demosaic(const Image& mosaic, const std::string& cfa);

/// Balanced camera colors as linear sRGB, by the matrix that their capture states; saturated colors may get negative.
Image in_srgb(Image rgb, const std::optional<Matrix3>& color_matrix);

}  // namespace dualpixel
