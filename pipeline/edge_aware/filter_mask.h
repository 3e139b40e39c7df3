#pragma once
#include "capture/image/image.h"
#include "pipeline/edge_aware/options.h"
#include "pipeline/option_field.h"

/// A coarse person mask made to follow the picture's edges (Wadhwa et al. 2018, section 3.4).
namespace dualpixel::pipeline {

struct FilterMaskOptions {
  int on = 1;             ///< 0: the mask is brought to the guide's size, bilinearly, and that is all
  float erosion = 0.05f;  ///< side of the square that erodes confidence, over the picture's larger side (section 3.4)
  float sigmoid_slope = 16;    ///< k of the sigmoid; the paper gives no value
  float blur_sigma_px = 1.0f;  ///< Gaussian against speckles, half-resolution pixels; the paper gives no value
  /// At half resolution; the paper gives none. Cells of 16 px bridge what erosion opens: on the portrait scene the
  /// mask's boundary F-score at 2 px rises from 0.57 to 0.63 over those of 8, from 0.49 to 0.63 for a mask that is 24
  /// px off, for two thirds of the time (`dualpixel bench edges CAPTURE`).
  /// They are not scaled with the picture: on the default person at 672 px, whose found mask has an IoU of .961, cells
  /// of 4, 8, 16 and 32 px filter it to .965, .980, .982 and .877; at 2688 px, from .973, to .964, .982, .984 and .984.
  BilateralGridOptions grid{16, 8, 8};
  BilateralSolverOptions solver;
  JointUpsampleOptions upsample;
};

OptionFields fields(FilterMaskOptions& options);

/// `mask` (one channel, 0..1, any size) filtered along the edges of `guide` (RGB, 0..255, guide.h). Returns a mask of
/// the guide's size. The solver runs at half the guide's resolution (section 3.4), so the mask is brought to that size
/// at once: enlarged bilinearly, or reduced where it is larger. Confidence is ((mask - 1/2) / (1/2))^2 (Eq. 1), eroded
/// there by the same square, as a share of the picture, as at full size. The result goes through a sigmoid (Eq. 2) and
/// a Gaussian, and is upsampled jointly with the guide. Switched off, nothing but the size changes.
Image filter_mask(const Image& mask, const Image& guide, const FilterMaskOptions& options = {});

/// The least value in the side x side window around each pixel, one channel; windows end at the picture's border.
/// `side` is odd.
Image erode(const Image& image, int side);

/// Gaussian blur, one channel, cut at 3 sigma, border pixels repeated outwards.
Image gaussian_blur(const Image& image, float sigma_px);

}  // namespace dualpixel::pipeline
