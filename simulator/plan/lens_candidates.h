#pragma once
#include <vector>

#include "simulator/plan/steps.h"

namespace dualpixel::simulator {

/// The lenses by which `lens` can be simulated, from the cheapest to what it is: the thin lens, then the versions of
/// its own model. A prescription has its aberrated twin (left out where none can be fitted), polynomials and exact
/// trace.
std::vector<LensCandidate> lens_candidates(const Lens& lens);

}  // namespace dualpixel::simulator
