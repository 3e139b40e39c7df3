#pragma once
#include <string>
#include <vector>

#include "simulator/lens/lens.h"

namespace dualpixel::simulator {

/// A lens that may replace another one.
struct LensCandidate {
  std::string name;
  Lens lens;
  double work = 1;  ///< of a sample, over a thin lens's; as `dualpixel bench lens` measures it
};

/// The lenses by which `lens` can be simulated, from the cheapest to what it is: the thin lens, then the versions of
/// its own model. A prescription has its aberrated twin (left out where none can be fitted), polynomials and exact
/// trace.
std::vector<LensCandidate> lens_candidates(const Lens& lens);

}  // namespace dualpixel::simulator
