#pragma once
#include "capture/image/image.h"
#include "pipeline/defocus/options.h"
#include "pipeline/option_field.h"

/// Recovers clipped highlights before the blur. Ours; not in the paper.
///
/// A sensor clips bright lamps to white. A wide lens would have spread the lamp's true light over a bright disc;
/// blurring the clipped white gives a dull one. So clipped pixels are made brighter first, by a factor that is
/// estimated from the picture's other bright pixels.
namespace dualpixel::pipeline {

OptionFields fields(HighlightOptions& options);

/// The factor: the mean light of clipped pixels over the clipping level c = clipped * white.
///
/// Model: above half the white level, a pixel's largest channel v follows a power law, P(v > x) ~ x^-a. A clipped pixel
/// shows only that v is at least c. The maximum-likelihood estimate of a for such censored data (Hill 1975) is
///     a = (number of pixels that are not clipped) / (sum over all of ln(min(v, c) / (white / 2))),
/// over the pixels above half the white level, plus the prior. Under the model, the mean of v / c beyond c, with v cut
/// off at most * c, is
///     1 + (1 - most^(1 - a)) / (a - 1).
double highlight_gain(const Image& rgb, double white, const HighlightOptions& options = {});

/// How much the patch of clipped pixels that a pixel belongs to looks like a lamp, 0 to 1; 0 where nothing clips. Light
/// falls off steeply beside a lamp, whose own light is unknown. Beside what is just clipped, as skin in the sun, it
/// falls as gently as the surface turns away, and the light of the patch is hardly more than white: the factor would
/// burn blotches into it.
Image lamp_shares(const Image& rgb, double white, const HighlightOptions& options = {});

/// Multiplies the clipped pixels of linear `rgb` by that factor, less where they are no lamps, where `radius_px`, of
/// the picture's size, is `full_blur_px` or more. The effect falls linearly to none at half that radius: a lamp nearly
/// in focus is white with or without the factor, while noise that reaches white on a bright face would be amplified.
Image recover_highlights(Image rgb, const Image& radius_px, double white, const HighlightOptions& options = {});

}  // namespace dualpixel::pipeline
