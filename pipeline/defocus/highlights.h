#pragma once
#include "capture/image/image.h"
#include "pipeline/defocus/options.h"
#include "pipeline/option_field.h"

/// Light beyond what the sensor could hold, guessed before the blur: a lamp that is blurred as if it were merely white
/// gives a dull disc where a lens would have given a bright one.
namespace dualpixel::pipeline {

OptionFields fields(HighlightOptions& options);

/// How much brighter than they look clipped pixels are on average. A picture's largest channels v are taken to follow a
/// power law from half the white level on, P(v > x) ~ x^-a, of which clipped pixels show only that they lie beyond the
/// level c = clipped * white: the likeliest a is the number of the others over the sum of ln(min(v, c) / (white / 2))
/// over all (Hill's estimator, censored). Beyond c the mean over c, cut off at `most`, is 1 + (1 - most^(1 - a)) /
/// (a - 1).
double highlight_gain(const Image& rgb, double white, const HighlightOptions& options = {});

/// Clipped pixels of linear `rgb` multiplied by that gain where they are to be blurred by `full_blur_px` or more, by
/// less down to half of it, and as they are below: a lamp nearly in focus is white either way, but noise that reaches
/// white here and there, on a bright face, would be made much of. `radius_px` is of the picture's size.
Image recover_highlights(Image rgb, const Image& radius_px, double white, const HighlightOptions& options = {});

}  // namespace dualpixel::pipeline
