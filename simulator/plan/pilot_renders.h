#pragma once
#include <cstdint>
#include <vector>

#include "simulator/plan/match_error.h"
#include "simulator/render/render_scene.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// The least sensor of which a plan can be made, photosites: one matcher's window and its neighbors.
inline constexpr int kLeastPlanWidth = (kWindowDpPx + 2) * kMatchDpPixelX,
                     kLeastPlanHeight = kWindowDpPx * kMatchDpPixelY;

/// One render of all tiles.
struct PilotRender {
  std::vector<DpViews> tiles;
  double seconds_per_sample = 0;  ///< on all threads
};

/// Renders tiles spread over the frame, or the whole sensor where it is small.
class PilotRenders {
 public:
  PilotRenders(const Simulation& simulation, const RenderScene& world, const Lens& lens, std::uint64_t seed);

  /// The same random numbers for the same `repeat`, whatever the bounces.
  PilotRender render(int bounces, int samples, int repeat) const;

 private:
  const Simulation& simulation_;
  const RenderScene& world_;
  std::vector<CameraView> cameras_;
  std::uint64_t seed_;
};

}  // namespace dualpixel::simulator
