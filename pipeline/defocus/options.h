#pragma once

/// Options of the blur: what a portrait holds without the steps that take them.
namespace dualpixel::pipeline {

/// The shape of the blur: aperture.h.
struct Aperture {
  int blades = 0;  ///< 0: round (the paper's disc); 3 to 16: a regular polygon
  /// 0 to 0.9: how much of the blur's radius the lens's rims cut off on either side in the picture's corners,
  /// proportionally less towards the middle: the cat's eye of a lens that vignettes. Two circles through the blades'
  /// corners, shifted apart, bound it.
  double cats_eye = 0;
  bool lying = false;  ///< the picture lies on its side, transposed: its x axis points down
};

/// Of highlights.h.
struct HighlightOptions {
  double clipped = 0.98;  ///< share of the white level from which a channel counts as clipped; demosaicking smears
  /// The guess leans on exponent `expected` as if this many pixels had been seen to follow it, so that a picture with
  /// few bright pixels has one.
  double expected = 2, weight_px = 100;
  double full_blur_px = 5.5;  ///< radius, full-resolution px: where brute force ends (layers.h)
  double most = 16;           ///< brightest light that is reckoned with, times white
};

/// How what is out of focus looks, beyond how large its blur is.
struct Bokeh {
  Aperture aperture;
  /// Clipped pixels are blurred as bright as they may have been; where the blurred picture shows, it is then cut off at
  /// white. What is sharp is never touched.
  bool recover_highlights = false;
  HighlightOptions highlights;
  double white = 1;  ///< the linear picture's clipping level
};

/// Of layers.h.
struct LayerOptions {
  int bands = 5;            ///< the in-focus one among them (section 5.2)
  double overlap = 0.25;    ///< eta over the width of the band (section 5.2: 25 %)
  double r_brute_px = 5.5;  ///< radius at the in-focus band's ends, full-resolution px (supplement: 2.75 at half size)
};

/// Of mask_blur.h.
struct MaskBlurOptions {
  double radius_px = 20;             ///< of the background, full-resolution px; the paper gives no value
  double reference_width_px = 2688;  ///< width for which that is meant; the radius grows in proportion
};

/// Of every method of methods.h.
struct DefocusOptions {
  LayerOptions layers;        ///< layers
  MaskBlurOptions mask_blur;  ///< mask, and baselines that blur by one radius
  Bokeh bokeh;
};

}  // namespace dualpixel::pipeline
