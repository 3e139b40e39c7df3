#pragma once
#include <memory>
#include <string>

#include "simulator/lens/thin/thin_model.h"

namespace dualpixel::simulator {

struct Prescription;
class PrescriptionSampler;

/// A lens by its surfaces and glasses, stopped down and focused. Rendering uses polynomials that are fitted to its
/// traced rays, or, on request, traces every surface for every sample.
struct PrescriptionModel {
  std::shared_ptr<const Prescription> prescription;
  bool exact_trace = false;

  using Sampler = PrescriptionSampler;

  static PrescriptionModel read(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin);
  double radius_of_image_mm() const;
  void refocus(double focus_distance_m, ThinLens& thin);
};

}  // namespace dualpixel::simulator
