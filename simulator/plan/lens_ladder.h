#pragma once
#include <string>
#include <vector>

#include "simulator/lens/lens.h"

namespace dualpixel::simulator {

struct LensModel {
  std::string name;
  Lens lens;
  double work = 1;  ///< of a sample, over a thin lens's; as `dualpixel bench lens` measures it
};

/// The models that `lens` can be drawn with, from the cheapest to what it is: thin; aberrated, or for a prescription
/// its aberrated twin (left out where none can be fitted), polynomials and exact trace.
std::vector<LensModel> lens_ladder(const Lens& lens);

}  // namespace dualpixel::simulator
