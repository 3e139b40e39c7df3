#include "simulator/plan/lens_candidates.h"

#include <utility>

#include "capture/error.h"
#include "simulator/lens/aberrated/aberrated_twin.h"
#include "simulator/lens/models.h"

namespace dualpixel::simulator {
namespace {

/// A model comes in one version, itself, unless an overload below says otherwise.
template <class Model>
void add_versions(const Lens& lens, const Model&, std::vector<LensCandidate>& candidates) {
  candidates.push_back({std::string(name_of(kLensModels, lens.model.index())) + " lens", lens});
}

/// The thin lens is among the candidates already.
void add_versions(const Lens&, const ThinModel&, std::vector<LensCandidate>&) {}

void add_versions(const Lens& lens, const PrescriptionModel& model, std::vector<LensCandidate>& candidates) {
  try {
    candidates.push_back({"aberrated twin", aberrated_twin(lens)});
  } catch (const InputError&) {  // the other versions do without
  }
  const auto version = [&](bool exact_trace) {
    Lens traced = lens;
    traced.model = PrescriptionModel{model.prescription, exact_trace};
    return traced;
  };
  candidates.push_back({"polynomials", version(false)});
  candidates.push_back({"exact trace", version(true)});
}

}  // namespace

std::vector<LensCandidate> lens_candidates(const Lens& lens) {
  Lens thin = lens;
  thin.model = ThinModel{};
  std::vector<LensCandidate> candidates = {{"thin lens", std::move(thin)}};
  std::visit([&](const auto& model) { add_versions(lens, model, candidates); }, lens.model);
  return candidates;
}

}  // namespace dualpixel::simulator
