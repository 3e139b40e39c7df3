#include "simulator/plan/pilot_renders.h"

#include <tbb/parallel_for.h>

#include <optional>
#include <utility>

#include "capture/timing.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"

namespace dualpixel::simulator {
namespace {

constexpr int kTileColumns = 6, kTileRows = 4;
constexpr int kTileWidth = (2 * kWindowDpPx + 2) * kMatchDpPixelX;  ///< two windows and their neighbors
constexpr int kTileHeight = kWindowDpPx * kMatchDpPixelY;

/// Parts of the sensor: the principal point moves, nothing else.
std::vector<SensorGrid> tile_grids(const SensorGrid& sensor, std::uint64_t seed) {
  const int cell_width = sensor.width_px / kTileColumns, cell_height = sensor.height_px / kTileRows;
  if (cell_width < kTileWidth || cell_height < kTileHeight) return {sensor};
  std::vector<SensorGrid> grids;
  for (int i = 0; i < kTileColumns * kTileRows; ++i) {
    const std::uint64_t key = hash(seed, i);
    const int x = i % kTileColumns * cell_width + static_cast<int>(key % (cell_width - kTileWidth + 1));
    const int y = i / kTileColumns * cell_height + static_cast<int>((key >> 32) % (cell_height - kTileHeight + 1));
    const glm::dvec2 corner(x / kMatchDpPixelX * kMatchDpPixelX, y / kMatchDpPixelY * kMatchDpPixelY);
    grids.push_back(
        {kTileWidth, kTileHeight, sensor.pixel_pitch_m, sensor.principal_point_px - corner, sensor.dp_downsample_x});
  }
  return grids;
}

std::vector<CameraView> tile_cameras(const Simulation& simulation, const Lens& lens, const Scene& scene,
                                     std::uint64_t seed) {
  const glm::mat4 pose = camera_pose(simulation, scene);
  const std::vector<SensorGrid> grids = tile_grids(sensor_grid(simulation.sensor), seed);
  std::vector<std::optional<CameraView>> ready(grids.size());
  tbb::parallel_for(std::size_t{0}, grids.size(), [&](std::size_t i) {
    ready[i] = CameraView{pose, prepare_lens(simulation, lens, grids[i])};
  });
  std::vector<CameraView> cameras;
  for (std::optional<CameraView>& camera : ready) cameras.push_back(std::move(*camera));
  return cameras;
}

}  // namespace

PilotRenders::PilotRenders(const Simulation& simulation, const RenderScene& world, const Lens& lens, std::uint64_t seed)
    : simulation_(simulation),
      world_(world),
      cameras_(tile_cameras(simulation, lens, world.scene, hash(seed, 1))),
      seed_(hash(seed, 2)) {}

PilotRender PilotRenders::render(int bounces, int samples, int repeat) const {
  PilotRender pilot;
  pilot.tiles.resize(cameras_.size());
  double photosites = 0;
  for (const CameraView& camera : cameras_) {
    photosites += static_cast<double>(camera.lens.sensor().width_px) * camera.lens.sensor().height_px;
  }
  const double time_s = seconds([&] {
    tbb::parallel_for(std::size_t{0}, cameras_.size(), [&](std::size_t i) {
      const Views views = render_views(world_, cameras_[i], {samples, bounces, hash(seed_, repeat, i)});
      pilot.tiles[i] =
          expected_dp_views(views, simulation_.sensor, simulation_.exposure, cameras_[i].lens.lux_per_nit());
    });
  });
  pilot.seconds_per_sample = time_s / (photosites * samples);
  return pilot;
}

}  // namespace dualpixel::simulator
