#pragma once
#include <vector>

#include "pipeline/segmentation/face.h"

/// What the face network says of a square picture, and the boxes that follow from it (after "Objects as Points", Zhou
/// et al. 2019). For each cell of 4 x 4 pixels:
///   score    the logit of a face's center being in the cell
///   dx, dy   from the cell's center to the face's, in sides of the face
///   size     log2 of the face's side over 32 px
namespace dualpixel::pipeline {

inline constexpr int kFaceCell_px = 4, kFaceChannels = 4;
inline constexpr double kFaceUnit_px = 32;

struct ScoredFace {
  Face face;         ///< square, in pixels of the network's picture
  double score = 0;  ///< 0..1
};

/// Area in common over area of either.
double overlap(const Face& a, const Face& b);

/// The faces of `map`, four planes of cells x cells values, of which `least_score` or more is certain; best first. Of
/// those that overlap by more than .3 the best is kept.
std::vector<ScoredFace> faces_of_map(const float* map, int cells, double least_score);

}  // namespace dualpixel::pipeline
