#include "simulator/plan/pilot_renders.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "capture/timing.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"

namespace dualpixel::simulator {
namespace {

constexpr int kTileColumns = 6, kTileRows = 4;

/// Parts of the sensor: the principal point moves, nothing else.
std::vector<SensorGrid> tile_grids(const SensorOptions& options, std::uint64_t seed) {
  const SensorGrid sensor = sensor_grid(options);
  // a tile begins at a DP pixel and at the mosaic's first photosite
  const int step_x = std::max(options.dp_downsample_x, 2), step_y = std::max(options.dp_downsample_y, 2);
  const LeastSensor window = least_sensor(options);
  const int tile_width = window.width_px + kWindowDpPx * options.dp_downsample_x, tile_height = window.height_px;
  const int cell_width = sensor.width_px / kTileColumns, cell_height = sensor.height_px / kTileRows;
  if (cell_width < tile_width || cell_height < tile_height) return {sensor};
  std::vector<SensorGrid> grids;
  for (int i = 0; i < kTileColumns * kTileRows; ++i) {
    const std::uint64_t key = hash(seed, i);
    const int x = i % kTileColumns * cell_width + static_cast<int>(key % (cell_width - tile_width + 1));
    const int y = i / kTileColumns * cell_height + static_cast<int>((key >> 32) % (cell_height - tile_height + 1));
    const glm::dvec2 corner(x / step_x * step_x, y / step_y * step_y);
    grids.push_back(
        {tile_width, tile_height, sensor.pixel_pitch_m, sensor.principal_point_px - corner, sensor.dp_downsample_x});
  }
  return grids;
}

std::vector<CameraView> tile_cameras(const Simulation& simulation, const Lens& lens, const Scene& scene,
                                     std::uint64_t seed) {
  const glm::mat4 pose = camera_pose(simulation, scene);
  const std::vector<SensorGrid> grids = tile_grids(simulation.sensor, seed);
  std::vector<std::optional<CameraView>> ready(grids.size());
  tbb::parallel_for(std::size_t{0}, grids.size(), [&](std::size_t i) {
    ready[i] = CameraView{pose, prepare_lens(simulation, lens, grids[i])};
  });
  std::vector<CameraView> cameras;
  for (std::optional<CameraView>& camera : ready) cameras.push_back(std::move(*camera));
  return cameras;
}

}  // namespace

LeastSensor least_sensor(const SensorOptions& sensor) {
  return {(kWindowDpPx + 2 * color_period(sensor)) * sensor.dp_downsample_x, kWindowDpPx * sensor.dp_downsample_y};
}

PilotRenders::PilotRenders(const Simulation& simulation, RenderScene& world, const Lens& lens, std::uint64_t seed)
    : simulation_(simulation),
      world_(world),
      cameras_(tile_cameras(simulation, lens, world.scene, hash(seed, 1))),
      seed_(hash(seed, 2)) {}

PilotRender PilotRenders::render(const PilotSettings& settings) const {
  PilotRender pilot;
  pilot.tiles.resize(cameras_.size());
  double photosites = 0;
  for (const CameraView& camera : cameras_) {
    photosites += static_cast<double>(camera.lens.sensor().width_px) * camera.lens.sensor().height_px;
  }
  LightCacheOptions light = simulation_.light;
  light.light_spacing_px = settings.light_spacing_px;
  world_.light_cache =
      light.light_spacing_px > 0 ? std::make_unique<LightCache>(light, settings.light_repeat) : nullptr;
  const auto render_all = [&] {
    tbb::parallel_for(std::size_t{0}, cameras_.size(), [&](std::size_t i) {
      const RenderOptions options{settings.samples, settings.bounces, hash(seed_, settings.repeat, i)};
      const Views views = render_views(world_, cameras_[i], options);
      pilot.tiles[i] =
          expected_dp_views(views, simulation_.sensor, simulation_.exposure, cameras_[i].lens.lux_per_nit());
    });
  };
  const double first_s = seconds(render_all);
  const double again_s = settings.timed ? seconds(render_all) : first_s;
  pilot.seconds_per_sample = again_s / (photosites * settings.samples);
  if (world_.light_cache) pilot.light_seconds = std::max(first_s - again_s, 0.0) / photosites;
  return pilot;
}

}  // namespace dualpixel::simulator
