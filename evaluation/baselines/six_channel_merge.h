#pragma once
#include <vector>

#include "pipeline/burst/align.h"
#include "pipeline/burst/merge.h"

/// The merge as Wadhwa et al. 2018, section 4.1, describe it, to compare the pipeline's own with
/// (pipeline/burst/merge.h): the four Bayer planes and both views are merged as one picture of six channels, by the
/// formula of Hasinoff et al. 2016, section 5.
namespace dualpixel::evaluation {

/// The tiles, the window, the shifts and c are merge_burst()'s. What differs:
/// - The views are enlarged to the size of the Bayer planes, linearly along y: even rows are the view's, odd rows the
///   mean of their neighbors. Of the merged views the even rows are returned, so that a single frame returns as it is.
/// - All channels of a tile share one weight A at each frequency, with P and V summed over the six. V is what white
///   noise has there: in an enlarged view 2 W sigma^2 (1 + cos(2 pi ky / 16))^2 / 2, sigma^2 being that of the view's
///   own pixels.
/// - No tile is rejected as a whole, which is not in the paper.
///
/// `motions` are those of align_burst() against frame `base`. Throws as require_burst(), and InputError where the
/// frames lack a mosaic or views, or the views are not as wide as a Bayer plane and half as high.
pipeline::MergedBurst merge_six_channels(const std::vector<Frame>& frames, int base,
                                         const std::vector<pipeline::MotionField>& motions, const Exposure& exposure);

}  // namespace dualpixel::evaluation
