#pragma once
#include <string>

#include "simulator/lens/lens_model.h"
#include "simulator/lens/split/split_pixel.h"

namespace dualpixel::simulator {

/// A lens, focused, and the split pixel behind it.
struct Lens {
  std::string name = "thin lens";
  std::string source;   ///< where its figures come from
  std::string derived;  ///< which of them are not the source's
  /// First-order figures. Of a prescription, the ideal lens with the same focal length, pupils and focus; it also takes
  /// the truth's wide-aperture photograph.
  ThinLens thin;
  LensModel model;
  SplitPixel split;
  bool diffraction = false;  ///< rays bend at the stop (diffraction.h)
  double veiling_glare = 0;  ///< share of the light that the lens spreads evenly over the picture (ISO 9358)
  std::string json;          ///< its fields as they were read, those of all its files laid over each other; or empty
};

/// The lens focused on another distance. Throws InputError where it cannot be.
Lens refocused(Lens lens, double focus_distance_m);

/// Radius of the image circle, focused on infinity; 0: not limited, as that of a thin lens.
double image_radius_mm(const Lens& lens);

/// The surfaces of a lens whose model is a prescription, otherwise nullptr.
const Prescription* prescription_of(const Lens& lens);

}  // namespace dualpixel::simulator
