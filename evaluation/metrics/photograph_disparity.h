#pragma once
#include "capture/capture.h"

namespace dualpixel::evaluation {

/// The disparity that belongs to the true photograph's blur, DP px, over the full sensor. Through an ideal lens that is
/// Eq. 3 of Wadhwa et al. 2018 of each place's depth, by the camera's own alpha, focal length, f-number and focus
/// distance; the capture's own disparity has the field curvature of its lens in it, which that photograph has not.
/// Where the photograph was taken through another lens, or one of those numbers is unknown, the capture's own. Eq. 3
/// focuses by moving the sensor: where `focusing` is "power" its image distance is longer by f/z, .4 % at 1 m.
Image photograph_disparity(const Capture& capture);

}  // namespace dualpixel::evaluation
