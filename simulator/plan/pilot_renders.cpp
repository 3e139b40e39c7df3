#include "simulator/plan/pilot_renders.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "capture/timing.h"
#include "simulator/held_camera.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"

namespace dualpixel::simulator {
namespace {

constexpr int kTileColumns = 6, kTileRows = 4, kTiles = kTileColumns * kTileRows;

/// Parts of the sensor: the principal point moves, nothing else. One in each cell, numbered from `first`; the whole
/// sensor where it is small.
std::vector<SensorGrid> tile_grids(const SensorOptions& options, std::uint64_t seed, int first) {
  const SensorGrid sensor = sensor_grid(options);
  // a tile begins at a DP pixel and at the mosaic's first photosite
  const int step_x = std::max(options.dp_downsample_x, 2), step_y = std::max(options.dp_downsample_y, 2);
  const LeastSensor window = least_sensor(options);
  const int tile_width = window.width_px + kWindowDpPx * options.dp_downsample_x, tile_height = window.height_px;
  const int cell_width = sensor.width_px / kTileColumns, cell_height = sensor.height_px / kTileRows;
  if (cell_width < tile_width || cell_height < tile_height) return {sensor};
  std::vector<SensorGrid> grids;
  for (int i = first; i < first + kTiles; ++i) {
    const std::uint64_t key = hash(hash(seed, 1), i);
    const int x = i % kTileColumns * cell_width + static_cast<int>(key % (cell_width - tile_width + 1));
    const int y =
        i / kTileColumns % kTileRows * cell_height + static_cast<int>((key >> 32) % (cell_height - tile_height + 1));
    const glm::dvec2 corner(x / step_x * step_x, y / step_y * step_y);
    grids.push_back(
        {tile_width, tile_height, sensor.pixel_pitch_m, sensor.principal_point_px - corner, sensor.dp_downsample_x});
  }
  return grids;
}

/// A tile's camera, as the hand holds it during the first frame's exposure; `whole` is that of the whole sensor.
std::vector<CameraView> poses_of_tile(const Simulation& s, const CameraView& whole, const SensorGrid& tile) {
  const CameraView camera{whole.world_from_camera, whole.lens.over(tile)};
  const auto first_row = std::lround(sensor_grid(s.sensor).principal_point_px.y - tile.principal_point_px.y);
  const int count = poses_of(s);
  std::vector<CameraView> poses;
  for (int pose = 0; pose < count; ++pose) {
    const double time_s = ((pose + 0.5) / count - 0.5) * s.exposure.time_s;
    poses.push_back(held_at(s, camera, time_s, static_cast<int>(first_row)));
  }
  return poses;
}

bool overlap(const SensorGrid& a, const SensorGrid& b) {
  const glm::dvec2 apart = glm::abs(a.principal_point_px - b.principal_point_px);
  return apart.x < a.width_px && apart.y < a.height_px;
}

}  // namespace

LeastSensor least_sensor(const SensorOptions& sensor) {
  return {(kWindowDpPx + 2 * color_period(sensor)) * sensor.dp_downsample_x, kWindowDpPx * sensor.dp_downsample_y};
}

PilotRenders::PilotRenders(const Simulation& simulation, RenderScene& world, std::uint64_t seed,
                           const std::vector<SensorGrid>& grids)
    : simulation_(simulation), world_(world), seed_(seed), next_(grids.size() == 1 ? 0 : kTiles) {
  const CameraView camera = place_camera(simulation, world.scene);
  for (const SensorGrid& grid : grids) tiles_.push_back(poses_of_tile(simulation, camera, grid));
}

PilotRenders::PilotRenders(const Simulation& simulation, RenderScene& world, std::uint64_t seed)
    : PilotRenders(simulation, world, seed, tile_grids(simulation.sensor, seed, 0)) {}

std::vector<SensorGrid> PilotRenders::grids() const {
  std::vector<SensorGrid> grids;
  for (const std::vector<CameraView>& poses : tiles_) grids.push_back(poses[0].lens.sensor());
  return grids;
}

bool PilotRenders::add_tiles() {
  constexpr int kTries = 8;  // in each cell
  if (next_ == 0) return false;
  const std::size_t before = tiles_.size();
  std::vector<SensorGrid> all = grids();
  const CameraView camera = place_camera(simulation_, world_.scene);
  for (int tries = 0; tries < kTries; ++tries, next_ += kTiles) {
    for (const SensorGrid& grid : tile_grids(simulation_.sensor, seed_, next_)) {
      const auto meets = [&](const SensorGrid& other) { return overlap(grid, other); };
      if (tiles_.size() == 2 * before || std::any_of(all.begin(), all.end(), meets)) continue;
      all.push_back(grid);
      tiles_.push_back(poses_of_tile(simulation_, camera, grid));
    }
  }
  return tiles_.size() > before;
}

void PilotRenders::keep_tiles(const std::vector<bool>& wanted) {
  std::vector<std::vector<CameraView>> kept;
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    if (wanted[i]) kept.push_back(std::move(tiles_[i]));
  }
  tiles_ = std::move(kept);
}

void PilotRenders::choose_light(const PilotSettings& settings) const {
  LightCacheOptions light = simulation_.light;
  light.light_spacing_px = settings.light_spacing_px;
  if (light.light_spacing_px == 0) {
    world_.light_cache.reset();
    return;
  }
  use_light(world_, light, settings.light_repeat);
  if (settings.new_light) world_.light_cache = std::make_unique<LightCache>(light, settings.light_repeat);
}

PilotRender PilotRenders::render(const PilotSettings& settings) const {
  PilotRender pilot;
  pilot.tiles.resize(tiles_.size());
  double photosites = 0;  // of all poses
  for (std::size_t i = settings.first_tile; i < tiles_.size(); ++i) {
    const std::vector<CameraView>& poses = tiles_[i];
    const SensorGrid& tile = poses[0].lens.sensor();
    photosites += static_cast<double>(poses.size()) * tile.width_px * tile.height_px;
  }
  choose_light(settings);
  const auto render_all = [&] {
    tbb::parallel_for(settings.first_tile, tiles_.size(), [&](std::size_t i) {
      const RenderOptions options{settings.samples, settings.bounces, hash(hash(seed_, 2), settings.repeat, i)};
      const std::vector<CameraView>& poses = tiles_[i];
      Views mean;
      for (const CameraView& pose : poses) {
        add_share(render_views(world_, pose, options), static_cast<int>(poses.size()), mean);
      }
      pilot.tiles[i] = expected_dp_views(mean, simulation_.sensor, simulation_.exposure, poses[0].lens.lux_per_nit());
    });
  };
  const double first_s = seconds(render_all);
  const double again_s = settings.timed ? seconds(render_all) : first_s;
  pilot.seconds_per_sample = again_s / (photosites * settings.samples);
  if (settings.new_light && world_.light_cache) pilot.light_seconds = std::max(first_s - again_s, 0.0) / photosites;
  return pilot;
}

}  // namespace dualpixel::simulator
