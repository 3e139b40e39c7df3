#pragma once
#include <cstdint>
#include <vector>

#include "simulator/plan/match_error.h"
#include "simulator/render/render_scene.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// The least sensor of which a plan can be made, photosites: one matcher's window and its neighbors.
struct LeastSensor {
  int width_px = 0, height_px = 0;
};
LeastSensor least_sensor(const SensorOptions& sensor);

/// How the pilots are rendered. The same random numbers for the same `repeat` and `light_repeat`, whatever the rest.
struct PilotSettings {
  int bounces = 0;
  int samples = 16;  ///< of each pose
  double light_spacing_px = 0;
  int repeat = 0;              ///< of the camera samples
  int light_repeat = 0;        ///< of light at points
  bool timed = false;          ///< twice, the second time with all light at points known
  bool new_light = false;      ///< that was not found before, so that what it costs is known
  std::size_t first_tile = 0;  ///< those before it are left out
};

/// One render of the tiles.
struct PilotRender {
  std::vector<DpViews> tiles;     ///< of all; empty where left out
  double seconds_per_sample = 0;  ///< on all threads; of a timed one with light at points found
  double light_seconds = 0;       ///< of finding it, per photosite; of a timed one of new light
};

/// Renders tiles spread over the frame, or the whole sensor where it is small: the burst's first frame. Every pose of
/// its exposure takes the same random numbers, so that their mean has a single pose's noise, and what remains of the
/// difference is motion. Animated things stand still.
class PilotRenders {
 public:
  /// `simulation` must outlive the pilots; `world` is left with a light cache of theirs.
  PilotRenders(const Simulation& simulation, RenderScene& world, std::uint64_t seed);

  PilotRender render(const PilotSettings& settings) const;

  /// The same tiles and random numbers of another simulation.
  PilotRenders of(const Simulation& other) const { return {other, world_, seed_, grids()}; }
  /// Adds up to as many tiles again, where there is room beside the others; false where there is none.
  bool add_tiles();
  /// Keeps the tiles whose `wanted` is true; one entry for each.
  void keep_tiles(const std::vector<bool>& wanted);
  const Simulation& simulation() const { return simulation_; }
  std::size_t tiles() const { return tiles_.size(); }
  int poses() const { return static_cast<int>(tiles_[0].size()); }  ///< of each exposure

 private:
  PilotRenders(const Simulation& simulation, RenderScene& world, std::uint64_t seed,
               const std::vector<SensorGrid>& grids);
  std::vector<SensorGrid> grids() const;  ///< of the tiles
  void choose_light(const PilotSettings& settings) const;

  const Simulation& simulation_;
  RenderScene& world_;
  std::vector<std::vector<CameraView>> tiles_;  ///< of each, the poses in which the hand holds the camera
  std::uint64_t seed_;
  int next_ = 0;  ///< number of the tile to be drawn next; 0: there is but the whole sensor
};

}  // namespace dualpixel::simulator
