#pragma once
#include "capture/image/image.h"
#include "pipeline/defocus/options.h"
#include "pipeline/option_field.h"

/// The blur where nothing but a person mask is known (Wadhwa et al. 2018, end of section 5.2).
namespace dualpixel::pipeline {

struct Defocused;

OptionFields fields(MaskBlurOptions& options);

/// The radius that suits a person whose face is so wide, in place of `radius_px`: the nearer a person, the more a lens
/// blurs what is far behind. Seen in the person's plane, the disc of a point at infinity is as wide as the pupil, so it
/// is pupil / face of a face's width: 12.3 mm, five times a phone's, over 0.15 m, an adult's from brow to chin, which
/// is what Face says. (dlib's frontal detector has boxes of 0.18 m.) At most 1.5 times the default, as r_max is in the
/// depth renderer. 0 and below: the default.
MaskBlurOptions blur_for_face(double face_width_px, int image_width_px, MaskBlurOptions options = {});

/// The background (1 - mask) [R, G, B, 1] is blurred by one disc, or the aperture's shape, at half resolution, and
/// divided by its alpha, so that the person's colors never bleed into it. The ground plane is imitated by mixing: the
/// blurred picture's share falls linearly from 1 at the top to 0 at the bottom (Aperture::transposed: left to right).
/// The person is laid over it. Defocused::radius_px is the background's radius times how much of the blurred picture
/// shows. `mask` is of the picture's size, 0..1. Throws InputError where their sizes differ.
Defocused blur_background(const Image& rgb, const Image& mask, const MaskBlurOptions& options = {},
                          const Bokeh& bokeh = {});

}  // namespace dualpixel::pipeline
