#pragma once
#include <array>
#include <functional>

#include "simulator/lens/prescription/pupil_bounds.h"
#include "simulator/sampling/packet.h"

/// How far the region that the rims leave of a pupil ellipse reaches from the ellipse's center, direction by direction.
/// Samples are spread within it. Else one in 25 would meet a rim, and by how many of few do, the brightness of a
/// photosite would differ from the next one's: noise that both views share, which pulls disparity to 0.
namespace dualpixel::simulator {

/// Sixteen positions in the ellipse, whose half axes are 1, in the lens frame.
struct PupilPositions {
  alignas(64) float x[kPacket], y[kPacket];
  alignas(64) float area[kPacket];  ///< that each stands for, over the whole ellipse's
};

/// At one distance from the axis.
struct PupilReach {
  static constexpr int kDirections = 33;   ///< from -y to +y: the region is symmetric about x = 0
  std::array<float, kDirections> reach{};  ///< over the ellipse's half axes

  /// Draws positions of the whole ellipse, spread evenly, into the region.
  void draw_in(PupilPositions& positions) const;
};

/// At the nodes of PupilBounds.
struct PupilReaches {
  std::array<PupilReach, PupilBounds::kNodes> nodes;

  PupilReach at(double r_mm, double image_radius_mm) const;
};

/// Which of sixteen positions in the ellipse at (0, r_mm) of the lens frame light passes.
using PassesPupil = std::function<void(double r_mm, const PupilPositions& at, bool passes[kPacket])>;

/// Not short of the region at the nodes and halfway between them, and hardly beyond it; `passes` is called from many
/// threads. A corner of the region that lies at a quarter of the way is cut by a third of its height.
PupilReaches find_reaches(const PupilBounds& bounds, const PassesPupil& passes);

}  // namespace dualpixel::simulator
