#include "tools/lens_ladder.h"

#include <stdexcept>

#include "simulator/lens/aberrated_twin.h"

namespace dualpixel::tools {

std::vector<LensModel> lens_ladder(const simulator::Lens& lens) {
  constexpr double kAberratedWork = 1.1, kPolynomialWork = 1.4, kTraceWork = 5.5;
  simulator::Lens thin = lens;
  thin.model = simulator::Lens::Model::thin;
  std::vector<LensModel> ladder = {{"thin lens", thin, 1}};
  if (lens.model == simulator::Lens::Model::aberrated) ladder.push_back({"aberrated lens", lens, kAberratedWork});
  if (lens.model == simulator::Lens::Model::prescription) {
    try {
      ladder.push_back({"aberrated twin", simulator::aberrated_twin(lens), kAberratedWork});
    } catch (const std::invalid_argument&) {  // the other models do without
    }
    simulator::Lens traced = lens;
    traced.exact_trace = false;
    ladder.push_back({"polynomials", traced, kPolynomialWork});
    traced.exact_trace = true;
    ladder.push_back({"exact trace", traced, kTraceWork});
  }
  return ladder;
}

}  // namespace dualpixel::tools
