#include "evaluation/benchmarks/render_scaling.h"

#include <malloc.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/timing.h"
#include "simulator/render/pixel.h"
#include "simulator/render/ray_log.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::evaluation {
namespace {

using simulator::CameraView;
using simulator::Mesh;
using simulator::RenderScene;
using simulator::Scene;

constexpr int kRepeats = 4;

/// Memory of this process now; freed memory is returned to the system first.
double resident_bytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// 2 m a side about `z_m`; 2 `side`^2 triangles of one and the same shape, smooth as most meshes are.
Mesh waves(unsigned side, float z_m) {
  Mesh mesh;
  mesh.positions.reserve(std::size_t{side + 1} * (side + 1));
  mesh.normals.reserve(mesh.positions.capacity());
  mesh.triangles.reserve(std::size_t{2} * side * side);
  for (unsigned i = 0; i <= side; ++i) {
    for (unsigned j = 0; j <= side; ++j) {
      const float x = 2 * static_cast<float>(j) / static_cast<float>(side) - 1;
      const float y = 2 * static_cast<float>(i) / static_cast<float>(side) - 1;
      mesh.positions.emplace_back(x, y, z_m + 0.02f * std::sin(30 * x) * std::sin(30 * y));
      mesh.normals.push_back(glm::normalize(
          glm::vec3(0.6f * std::cos(30 * x) * std::sin(30 * y), 0.6f * std::sin(30 * x) * std::cos(30 * y), -1)));
      if (i == side || j == side) continue;
      const unsigned at = i * (side + 1) + j;
      mesh.triangles.emplace_back(at, at + 1, at + side + 2);
      mesh.triangles.emplace_back(at, at + side + 2, at + side + 1);
    }
  }
  return mesh;
}

/// The mesh in gray, under a sky.
Scene scene_of(Mesh mesh) {
  Scene scene;
  simulator::Material gray;
  gray.base_color = {0.5f, 0.5f, 0.5f, 1};
  gray.metallic = 0;
  scene.materials = {gray};
  scene.meshes = {std::move(mesh)};
  scene.environment = {64, 32, std::vector<glm::vec3>(std::size_t{64} * 32)};
  for (std::size_t i = 0; i < scene.environment.radiance_nits.size(); ++i) {
    scene.environment.radiance_nits[i] = glm::vec3(1000 + static_cast<float>(i));
  }
  return scene;
}

/// 1 m in front of the camera.
Scene wall_of_waves(unsigned side) { return scene_of(waves(side, 1)); }

constexpr unsigned kTileSide = 71;
constexpr double kTileTriangles = 2.0 * kTileSide * kTileSide;  // ten thousand

/// A wall of the same size from one tile that is placed `tiles`^2 times.
Scene wall_of_tiles(unsigned tiles) {
  Mesh tile = waves(kTileSide, 0);
  const float scale = 1 / static_cast<float>(tiles);
  for (unsigned i = 0; i < tiles * tiles; ++i) {
    const unsigned row = i / tiles, column = i % tiles;
    const float x = (2 * static_cast<float>(column) + 1) * scale - 1;
    const float y = (2 * static_cast<float>(row) + 1) * scale - 1;
    tile.placements.push_back({glm::mat4x3({scale, 0, 0}, {0, scale, 0}, {0, 0, scale}, {x, y, 1}), i + 1, false});
  }
  return scene_of(std::move(tile));
}

/// The same with a copy of the tile at each position.
Scene with_copies(const Scene& scene) {
  const Mesh& tile = scene.meshes[0];
  Mesh all;
  all.positions.reserve(tile.positions.size() * tile.placements.size());
  all.normals.reserve(all.positions.capacity());
  all.triangles.reserve(tile.triangles.size() * tile.placements.size());
  for (const simulator::Placement& placement : tile.placements) {
    const auto first = static_cast<unsigned>(all.positions.size());
    for (const glm::vec3& p : tile.positions) all.positions.push_back(placement.world_from_mesh * glm::vec4(p, 1));
    all.normals.insert(all.normals.end(), tile.normals.begin(), tile.normals.end());  // only scaled, all axes alike
    for (const glm::uvec3& t : tile.triangles) all.triangles.push_back(t + first);
  }
  return scene_of(std::move(all));
}

unsigned side_for(double triangles) { return static_cast<unsigned>(std::lround(std::sqrt(triangles / 2))); }

/// A phone's camera whose photosites are as large in all sizes, so that each sees as much of the wall.
CameraView phone(int width_px, int height_px) {
  simulator::Lens lens;
  lens.thin = {4.442e-3, 1.8, 0.8};
  constexpr double kPitch_m = 3.76e-3 / 512;
  return {glm::mat4(1),
          simulator::LensSampler(lens, {width_px, height_px, kPitch_m, {0.5 * width_px, 0.5 * height_px}})};
}

double photosites(const CameraView& camera) {
  return static_cast<double>(camera.lens.sensor().width_px) * camera.lens.sensor().height_px;
}

/// Renders with `samples` samples on one thread: the first makes points of light, the least of the others does not.
SampleCost sample_cost(RenderScene& world, const CameraView& camera, int samples, double count) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  world.light_cache = std::make_unique<simulator::LightCache>(simulator::LightCacheOptions{});
  const auto render_s = [&] { return cpu_seconds([&] { render_views(world, camera, {samples, 0, 1}); }); };
  const double first_s = render_s();
  double best_s = 1e30;
  for (int i = 0; i < kRepeats; ++i) best_s = std::min(best_s, render_s());
  const auto points = static_cast<double>(world.light_cache->table.points());
  return {count, 1e9 * best_s / (samples * photosites(camera)), {points, std::max(first_s - best_s, 0.0)}};
}

/// CPU time of one ray in Embree alone, ns: those of some photosites' samples again.
double ray_ns(const RenderScene& world, const CameraView& camera) {
  constexpr int kEvery = 7;
  simulator::RayLog log;
  simulator::PathOptions options;
  options.max_bounces = 0;
  options.log = &log;
  const int width = camera.lens.sensor().width_px;
  for (int i = 0; i < static_cast<int>(photosites(camera)); i += kEvery) {
    simulator::render_pixel(world, camera, options, i % width, i / width, 64, simulator::hash(7, i));
  }
  double rays = 0, best = 1e30;
  for (const simulator::LoggedRays& packet : log) {
    rays += static_cast<double>(simulator::kPacket - std::count(packet.active, packet.active + simulator::kPacket, 0));
  }
  for (int i = 0; i < kRepeats; ++i) {
    best =
        std::min(best, cpu_seconds([&] { simulator::replay(world.intersector, log, simulator::Intersector::kWidth); }));
  }
  return 1e9 * best / rays;
}

/// `scene` has `triangles` triangles.
SceneCost cost_of(const Scene& scene, double triangles) {
  const double before = resident_bytes();
  std::optional<RenderScene> world;
  const double build_s = cpu_seconds([&] { world.emplace(scene); });
  const double bytes = resident_bytes() - before;
  const SampleCost sample = sample_cost(*world, phone(128, 96), 64, 0);
  return {triangles, sample.cpu_ns, ray_ns(*world, phone(128, 96)), build_s, bytes / triangles, sample.light};
}

SceneCost with_triangles(double triangles) {
  const unsigned side = side_for(triangles);
  return cost_of(wall_of_waves(side), 2.0 * side * side);
}

InstancingCost with_placements(double triangles) {
  const auto tiles = static_cast<unsigned>(std::lround(std::sqrt(triangles / kTileTriangles)));
  const double count = kTileTriangles * tiles * tiles;
  const Scene scene = wall_of_tiles(tiles);
  InstancingCost cost;
  cost.placements = static_cast<int>(tiles * tiles);
  cost.placed = cost_of(scene, count);
  cost.copied = cost_of(with_copies(scene), count);
  return cost;
}

void measure_threads(const RenderScene& world, RenderScaling& scaling) {
  const CameraView camera = phone(256, 192);
  double wall_s[2] = {1e30, 1e30}, cpu_s[2] = {1e30, 1e30};
  for (int repeat = 0; repeat < 2 * kRepeats; ++repeat) {
    for (int two : {0, 1}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1 + two);
      double wall = 0;
      const double cpu = cpu_seconds([&] { wall = seconds([&] { render_views(world, camera, {32, 0, 1}); }); });
      wall_s[two] = std::min(wall_s[two], wall);
      cpu_s[two] = std::min(cpu_s[two], cpu);
    }
  }
  scaling.wall_time_ratio = wall_s[0] / wall_s[1];
  scaling.cpu_time_ratio = cpu_s[0] / cpu_s[1];
}

nlohmann::ordered_json to_json(const SceneCost& cost) {
  return {{"triangles", cost.triangles},
          {"cpu_ns", cost.cpu_ns},
          {"ray_ns", cost.ray_ns},
          {"build_s", cost.build_s},
          {"bytes_per_triangle", cost.bytes_per_triangle},
          {"points_of_light", cost.light.points},
          {"points_cpu_s", cost.light.cpu_s}};
}

nlohmann::ordered_json to_json(const InstancingCost& cost) {
  nlohmann::ordered_json json = to_json(cost.placed);
  json["placements"] = cost.placements;
  const nlohmann::ordered_json copies = to_json(cost.copied);
  for (const char* key : {"cpu_ns", "ray_ns", "build_s", "bytes_per_triangle"}) {
    json[std::string("copied_") + key] = copies[key];
  }
  return json;
}

}  // namespace

RenderScaling measure_scaling(double most_triangles, const std::function<void(double)>& progress) {
  RenderScaling scaling;
  {
    const Scene scene = wall_of_waves(side_for(1e5));
    RenderScene world(scene);
    for (int samples = 16; samples <= 1024; samples *= 4) {
      scaling.samples.push_back(sample_cost(world, phone(96, 72), samples, samples));
    }
    progress(0.2);
    for (int width = 64; width <= 512; width *= 2) {
      const CameraView camera = phone(width, width * 3 / 4);
      scaling.photosites.push_back(sample_cost(world, camera, 32, photosites(camera)));
    }
    progress(0.5);
    measure_threads(world, scaling);
    progress(0.6);
  }
  for (double triangles = 1e4; triangles <= most_triangles; triangles *= 10) {
    scaling.triangles.push_back(with_triangles(triangles));
    scaling.instancing.push_back(with_placements(triangles));
  }
  progress(1);
  return scaling;
}

double relative_spread(const std::vector<SampleCost>& costs) {
  const auto [low, high] = std::minmax_element(
      costs.begin(), costs.end(), [](const SampleCost& a, const SampleCost& b) { return a.cpu_ns < b.cpu_ns; });
  return (high->cpu_ns - low->cpu_ns) / (high->cpu_ns + low->cpu_ns);
}

nlohmann::ordered_json to_json(const RenderScaling& scaling) {
  nlohmann::ordered_json json;
  for (const SampleCost& c : scaling.samples) {
    json["samples"].push_back({{"samples", static_cast<int>(c.count)}, {"cpu_ns", c.cpu_ns}});
  }
  for (const SampleCost& c : scaling.photosites) {
    json["photosites"].push_back({{"photosites", c.count},
                                  {"cpu_ns", c.cpu_ns},
                                  {"points_of_light", c.light.points},
                                  {"points_cpu_s", c.light.cpu_s}});
  }
  json["threads"] = {{"wall_time_ratio", scaling.wall_time_ratio}, {"cpu_time_ratio", scaling.cpu_time_ratio}};
  for (const SceneCost& cost : scaling.triangles) json["triangles"].push_back(to_json(cost));
  for (const InstancingCost& cost : scaling.instancing) json["placements"].push_back(to_json(cost));
  json["samples_deviation"] = relative_spread(scaling.samples);
  json["photosites_deviation"] = relative_spread(scaling.photosites);
  return json;
}

}  // namespace dualpixel::evaluation
