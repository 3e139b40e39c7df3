#pragma once
#include "capture/image/image.h"
#include "pipeline/disparity/likelihood/options.h"
#include "pipeline/disparity/split/options.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::pipeline {
TileDisparity match_by_split(const Image& left, const Image& right, const SplitMatchOptions& options = {},
                             const LikelihoodMatchOptions& near_focus = {});
}  // namespace dualpixel::pipeline
