#pragma once
#include <string>

#include "simulator/lens/thin/thin_lens.h"

namespace dualpixel {
class Fields;
}

namespace dualpixel::simulator {

class ThinSampler;

/// The ideal lens: all that it needs are the first-order figures.
struct ThinModel {
  using Sampler = ThinSampler;

  static ThinModel read(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin);
  double radius_of_image_mm() const { return 0; }
  void refocus(double, ThinLens&) {}
};

/// Reads focal length, f-number and the way of focusing, for the models that build on an ideal lens.
void read_thin_lens(Fields& lens, double focus_distance_m, ThinLens& thin);

/// Throws InputError where the lens cannot focus so near.
void set_focus(ThinLens& thin, double focus_distance_m);

}  // namespace dualpixel::simulator
