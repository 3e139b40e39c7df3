#pragma once

/// Options of the blur: what a portrait holds without the steps that take them.
namespace dualpixel::pipeline {

/// The shape of the blur: aperture.h.
struct Aperture {
  int blades = 0;  ///< 0: round (the paper's disc); 3 to 16: a regular polygon
  /// Cat's eye of a lens that vignettes: share of the blur's radius, 0 to 0.9, that the lens's rims cut off on either
  /// side in the picture's corners; proportionally less towards the middle. The shape is cut by two circles through the
  /// blades' corners, shifted apart.
  double cats_eye = 0;
  bool transposed = false;  ///< the picture is stored with its axes exchanged: its x axis points down
};

/// Of highlights.h.
struct HighlightOptions {
  /// Share of the white level from which a channel counts as clipped. Below 1, as demosaicking blends clipped values
  /// with neighbors that are not.
  double clipped = 0.98;
  /// Prior for the exponent a of highlight_gain(): the estimate is as if `weight_px` more pixels had been seen that
  /// follow a = `expected`. So a picture with few bright pixels gets a = `expected`.
  double expected = 2, weight_px = 100;
  /// Blur radius, full-resolution px, from which the whole factor applies. Where brute force ends (layers.h).
  double full_blur_px = 5.5;
  double most = 16;  ///< brightest light that the estimate allows for, over the white level
  /// A clipped patch is a lamp where its surroundings, this share of the picture's width away from it, are darker than
  /// `lamp` of white on the mean, and a surface that just clips from `surface` on.
  double surroundings = 0.002, lamp = 0.5, surface = 0.75;
};

/// The look of blurred areas apart from their radius: aperture shape and clipped highlights.
struct Bokeh {
  Aperture aperture;
  /// Brighten clipped pixels before the blur (highlights.h). The blurred picture is clipped at white again; sharp
  /// pixels stay as they are.
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
