#pragma once
#include <string>

#include "capture/capture.h"
#include "pipeline/defocus/blur_radius.h"

/// Physically true blur: the radius that another lens would give, standing where the camera stood.
///
/// Disparity is proportional to blur (Wadhwa et al. 2018, Eq. 3 and supplement): a point of disparity d is blurred by a
/// disc of |d| / alpha DP pixels on the capture's own sensor, and k times that by a pupil k times as wide focused at
/// the same depth, whatever the lens's focal length: a picture keeps its field of view and takes over the other lens's
/// blur in proportion to its own width. Nothing is kept sharp beyond what the lens keeps sharp, and nothing is weaker
/// in front.
namespace dualpixel::pipeline {

/// kappa for a lens whose entrance pupil is `pupil_mm` wide. The capture is blurred already, by its own lens: discs of
/// sqrt(k^2 - 1) times its own add the variance that is missing, and none where the pupil is not wider than its own;
/// with `input_is_sharp` the disc is k times its own. The radius is capped at an eighth of the picture's width.
/// Throws InputError where the camera's alpha, focal length or f-number is unknown.
BlurMapping match_lens(const Camera& camera, double pupil_mm, double focus_dp_px, bool input_is_sharp = false);

/// The entrance pupil of a lens named as "f/1.4@50mm-equivalent": what a lens of that focal length and f-number has in
/// front of a full-frame sensor. Throws InputError, whose message begins with `field`, where it is not named so, or
/// outside f/0.5 to f/64 and 1 to 2000 mm.
double pupil_mm_of_lens(const std::string& field, const std::string& lens);

}  // namespace dualpixel::pipeline
