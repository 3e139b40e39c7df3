#include "simulator/plan/lens_ladder.h"

#include <stdexcept>

#include "simulator/lens/aberrated_twin.h"

namespace dualpixel::simulator {

std::vector<LensModel> lens_ladder(const Lens& lens) {
  constexpr double kAberratedWork = 1.1, kPolynomialWork = 1.4, kTraceWork = 5.5;
  Lens thin = lens;
  thin.model = Lens::Model::thin;
  std::vector<LensModel> ladder = {{"thin lens", thin, 1}};
  if (lens.model == Lens::Model::aberrated) ladder.push_back({"aberrated lens", lens, kAberratedWork});
  if (lens.model == Lens::Model::prescription) {
    try {
      ladder.push_back({"aberrated twin", aberrated_twin(lens), kAberratedWork});
    } catch (const std::invalid_argument&) {  // the other models do without
    }
    Lens traced = lens;
    traced.exact_trace = false;
    ladder.push_back({"polynomials", traced, kPolynomialWork});
    traced.exact_trace = true;
    ladder.push_back({"exact trace", traced, kTraceWork});
  }
  return ladder;
}

}  // namespace dualpixel::simulator
