#pragma once
#include <vector>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/split/split_pixel.h"

namespace dualpixel::simulator {

/// The split pixel made ready for rendering: gives each ray its weights in the left and in the right view.
class SplitSampler {
 public:
  /// `rim_slope`: ThinLens::rim_slope() of the lens in front of it.
  SplitSampler(const SplitPixel& split, double rim_slope);

  /// Fills left and right of `rays`.
  void weigh(const PixelFrame& f, const PupilPacket& pupil, LensPacket& rays) const;

 private:
  void weigh_by_microlens(const PixelFrame& f, const PupilPacket& pupil, LensPacket& rays) const;
  void weigh_by_table(const PupilPacket& pupil, LensPacket& rays) const;

  SplitPixel split_;
  double rim_slope_;
  /// A table split's shares over p, evenly spaced, linear in between.
  struct Table {
    float low = 0, per_step = 0;  ///< first p; 1 / spacing
    std::vector<float> left, right;
  } table_;
};

}  // namespace dualpixel::simulator
