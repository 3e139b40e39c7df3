#pragma once
#include "capture/capture.h"

/// Lens shading taken out of pictures, as the gain maps of phones do (GainMap of DNG 1.3, lens shading map of Android).
/// It is for pictures to look at and to compare: matching wants views with the noise and the white level that the
/// capture states, and has its own ways with what differs between them.
namespace dualpixel {

/// Where less than an eighth of the light arrives, noise is all that more gain would show.
inline constexpr float kMostShadingGain = 8;

/// 1 / Camera::relative_light of each photosite, at most kMostShadingGain; empty where the camera states none.
Image shading_gain(const Camera& camera);

/// Multiplies a picture of that size, of any number of channels, by `gain`; an empty one changes nothing. No value gets
/// beyond `white`, where the picture clips, so that clipped highlights are as bright in its corners as on the axis.
void correct_shading(Image& picture, const Image& gain, float white);

}  // namespace dualpixel
