#include "simulator/render/render_scene.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace dualpixel::simulator {
namespace {

/// Each reserves addresses for all that it may hold, which some machines bound: the least and the most samples of a
/// point are eight doublings apart, each once more to tell the error.
constexpr std::size_t kMostSpare = 18;

void drop_oldest(std::vector<std::unique_ptr<LightCache>>& spare, double most_bytes) {
  double bytes = 0;
  std::size_t kept = 0;
  while (kept < std::min(spare.size(), kMostSpare)) {
    bytes += static_cast<double>(spare[spare.size() - 1 - kept]->table.bytes());
    if (bytes > most_bytes) break;
    ++kept;
  }
  spare.erase(spare.begin(), spare.end() - static_cast<std::ptrdiff_t>(kept));
}

}  // namespace

void use_light(RenderScene& world, const LightCacheOptions& options, std::uint64_t scramble) {
  const auto wanted = [&](const std::unique_ptr<LightCache>& cache) {
    return cache && cache->options == options && cache->scramble == scramble;
  };
  if (wanted(world.light_cache)) return;
  auto& spare = world.spare_light;
  if (world.light_cache && world.light_cache->table.points() > 0) spare.push_back(std::move(world.light_cache));
  world.light_cache.reset();
  const auto found = std::find_if(spare.begin(), spare.end(), wanted);
  if (found != spare.end()) {
    world.light_cache = std::move(*found);
    spare.erase(found);
  }
  drop_oldest(spare, options.light_memory_mb * (1 << 20));
  if (!world.light_cache) world.light_cache = std::make_unique<LightCache>(options, scramble);
}

}  // namespace dualpixel::simulator
