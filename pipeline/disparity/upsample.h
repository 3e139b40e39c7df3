#pragma once
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// From one disparity a tile to one a pixel. The paper refers to Anderson et al. 2016, "Jump: Virtual Reality Video",
/// section 4, where each pixel weighs the flows of the tiles around it by how well the reference picture's structure
/// agrees. Here the weights are bilinear and know nothing of the picture: at edges they leave low confidence to the
/// solver of section 4.4, which follows the picture's edges with all tiles in view.
namespace dualpixel::pipeline {

struct TileDisparity;

struct PixelDisparity {
  Image disparity_dp_px;
  Image confidence;   ///< 0..1
  Image sigma_dp_px;  ///< predicted standard deviation of the error; empty where the tiles have none
};

struct UpsampleOptions {
  float spread_dp_px = 0.25f;  ///< disagreement (standard deviation, DP px) at which confidence falls to exp(-1/2)
};

OptionFields fields(UpsampleOptions& options);

/// Each pixel blends the four tiles whose centers surround it, by bilinear weight times confidence, so that a tile
/// of low confidence gives way to its neighbors. Its confidence is the bilinear mean of theirs, times
/// exp(-variance / (2 spread^2)) of their weighted disparities: between tiles that disagree lies an edge, and a blend
/// of two surfaces is on neither. The edge-aware solver decides there.
///
/// sigma_dp_px^2 is the variance of that blend, from each tile's sigma and the share of error that neighbors have in
/// common, plus the variance between the tiles beyond twice what their sigmas explain.
PixelDisparity upsample_tiles(const TileDisparity& tiles, int width, int height, const UpsampleOptions& options = {});

}  // namespace dualpixel::pipeline
