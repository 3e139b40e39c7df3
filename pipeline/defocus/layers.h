#pragma once
#include <vector>

#include "capture/image/image.h"
#include "pipeline/defocus/blur_radius.h"
#include "pipeline/defocus/options.h"
#include "pipeline/option_field.h"

/// The picture cut into bands of disparity that are blurred one by one (Wadhwa et al. 2018, section 5.2).
namespace dualpixel::pipeline {

OptionFields fields(LayerOptions& options);

struct Band {
  double low_dp_px = 0;    ///< d_{j-1}
  double high_dp_px = 0;   ///< d_j
  double taper_dp_px = 0;  ///< eta
  bool in_focus = false;

  /// Truncated tent: 1 in the band, falling to 0 within `taper` on either side.
  float alpha(float disparity_dp_px) const;
};

/// The bands from the farthest to the nearest. The in-focus one spans the disparities whose radius is below r_brute;
/// the others share what the picture's disparities [low, high] have beyond it: as many on either side as its length
/// deserves, at least one where there is anything, all of one side equally wide. Fewer bands where nothing is left. The
/// paper divides the whole range evenly; a band that reached across the focus would blur what is in front of it
/// together with what is behind.
std::vector<Band> make_bands(double low_dp_px, double high_dp_px, const BlurMapping& mapping,
                             const LayerOptions& options = {});

/// A sub-image at the blur's working resolution, half the picture's; odd last rows and columns count once.
struct Layer {
  Image rgba;                      ///< alpha [R, G, B, 1]
  Image radius_px;                 ///< working-resolution px
  bool in_front_of_focus = false;  ///< apertures show upside down there
};

/// How much of a pixel of radius r, full-resolution px, is the input's own: all up to 0.5 px, nothing from 1.5 px on.
float sharpness(float radius_px);

/// The sum of all bands' alphas at each pixel: 1 and more within the disparities that make_bands() was given.
Image sums_of_tents(const Image& disparity_dp_px, const std::vector<Band>& bands);

/// I_j = alpha_j [R, G, B, 1] of each pixel, then the mean of each 2 x 2 block; radii are means weighted by alpha_j.
/// Here alpha_j is the band's tent over the sum of all bands' tents (Eq. 9 has the tent itself), so that a pixel inside
/// one band and in the taper of the next has no more light than others. The in-focus band leaves out what is sharp, as
/// it is laid down at full resolution: its halved outline would show. `rgb`, `disparity`, `radius` and `tent_sums` are
/// of one size. Written to `layer`, whose memory is used again.
void cut_band(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px, const Image& tent_sums,
              const Band& band, Layer& layer);

/// The same with alpha = 1 - mask and one radius, full-resolution px.
Layer cut_background(const Image& rgb, const Image& mask, float radius_px);

}  // namespace dualpixel::pipeline
