#pragma once
#include <vector>

#include "evaluation/failures/atlas_camera.h"
#include "evaluation/failures/failure_row.h"

namespace dualpixel::evaluation {

/// Scenes made by code, rendered through `camera`, exposed as a burst and merged. The truth is the simulator's: the
/// centroid disparity of what the chief ray in the middle of a pixel meets, also beside depth edges.
std::vector<FailureRow> rendered_failure_rows(const AtlasCamera& camera);

}  // namespace dualpixel::evaluation
