#include "simulator/render/views.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <mutex>

#include "simulator/sampling/hash.h"

namespace dualpixel::simulator {
namespace {

void set_pixel(Views& views, int x, int y, const HalfRadiance& r) {
  for (int c = 0; c < 3; ++c) {
    views.left.at(x, y, c) = r.left[c];
    views.right.at(x, y, c) = r.right[c];
  }
}

void render_tile(const RenderScene& world, const CameraView& camera, const PathOptions& paths, std::uint64_t seed,
                 const Tile& tile, Views& views) {
  const auto key = [&](int x, int y) {
    return hash(seed, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x));
  };
  for (int y = tile.y0; y < tile.y1; ++y) {
    int x = tile.x0;
    for (; tile.samples <= kMostSharedSamples && x + 1 < tile.x1; x += 2) {
      const auto pair = render_pixel_pair(world, camera, paths, x, y, tile.samples, {key(x, y), key(x + 1, y)});
      for (int k = 0; k < 2; ++k) set_pixel(views, x + k, y, pair[k]);
    }
    for (; x < tile.x1; ++x) set_pixel(views, x, y, render_pixel(world, camera, paths, x, y, tile.samples, key(x, y)));
  }
}

}  // namespace

Views render_views(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
                   const ProgressCallback& progress) {
  const SensorGrid& sensor = camera.lens.sensor();
  return render_views(world, camera, options, uniform_map(sensor.width_px, sensor.height_px, options.samples_per_pixel),
                      progress);
}

Views render_views(const RenderScene& world, const CameraView& camera, const RenderOptions& options,
                   const SampleMap& map, const ProgressCallback& progress) {
  const int width = camera.lens.sensor().width_px, height = camera.lens.sensor().height_px;
  Views views{Image(width, height, 3), Image(width, height, 3)};
  const PathOptions paths{options.max_bounces, options.ideal_aperture_scale, options.sampling, options.color};
  const double all = map.total_samples();
  std::atomic<std::uint64_t> done = 0;
  std::mutex progress_mutex;
  for_tiles(map, [&](const Tile& tile) {
    if (tile.y0 < options.first_row || tile.y0 >= options.end_row) return;
    const std::uint64_t render = hash(options.seed, tile.samples);
    const bool known = options.store && options.store->restore(render, tile, views);
    if (!known) render_tile(world, camera, paths, options.seed, tile, views);
    if (options.store && !known) options.store->add(render, tile, views);
    done += std::uint64_t{tile.samples} * (tile.x1 - tile.x0) * (tile.y1 - tile.y0);
    if (progress && progress_mutex.try_lock()) {
      progress(static_cast<double>(done) / all);
      progress_mutex.unlock();
    }
  });
  return views;
}

void add_share(const Views& views, int count, Views& mean) {
  const double share = 1.0 / count;
  for (Image Views::*side : {&Views::left, &Views::right}) {
    const Image& view = views.*side;
    Image& sum = mean.*side;
    if (sum.empty()) sum = Image(view.width, view.height, view.channels);
    for (std::size_t i = 0; i < view.data.size(); ++i) sum.data[i] += static_cast<float>(view.data[i] * share);
  }
}

Image undivided(Views views) {
  for (std::size_t i = 0; i < views.left.data.size(); ++i) views.left.data[i] += views.right.data[i];
  return std::move(views.left);
}

}  // namespace dualpixel::simulator
