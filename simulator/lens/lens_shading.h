#pragma once
#include "capture/image/image.h"

namespace dualpixel::simulator {

class LensSampler;

/// Camera::relative_light of the camera, in green: the light of both halves together, at 17 x 13 places (as many as
/// phones' maps have) by 16384 rays each. Empty where it is 1 all over within .001, as behind a thin lens. Veiling
/// glare, which depends on the scene, is not in it.
Image relative_light(const LensSampler& lens);

}  // namespace dualpixel::simulator
