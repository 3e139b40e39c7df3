#pragma once
#include <memory>
#include <string>

#include "simulator/lens/aberrations.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/split_pixel.h"
#include "simulator/lens/thin_lens.h"

namespace dualpixel::simulator {

/// A lens, focused, and the split pixel behind it. `thin` is always set: of a prescription it is the ideal lens with
/// the same focal length, pupils and focus, which also takes the truth's wide-aperture photograph.
struct Lens {
  enum class Model { thin, aberrated, prescription } model = Model::thin;
  std::string name = "thin lens";
  std::string source;   ///< where its figures come from
  std::string derived;  ///< which of them are not the source's
  ThinLens thin;
  Aberrations aberrations;                           ///< model aberrated
  std::shared_ptr<const Prescription> prescription;  ///< model prescription: stopped down and focused
  bool exact_trace = false;  ///< trace every surface for every sample instead of the fitted polynomials
  SplitPixel split;
};

/// The lens focused on another distance. Throws std::invalid_argument where it cannot be.
Lens refocused(Lens lens, double focus_distance_m);

}  // namespace dualpixel::simulator
