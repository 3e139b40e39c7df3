#include "evaluation/experiments/render_scaling.h"

#include <fmt/format.h>
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
#include "evaluation/report/svg_plot.h"
#include "simulator/render/pixel.h"
#include "simulator/render/ray_log.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::evaluation {
namespace {

using nlohmann::ordered_json;
using simulator::CameraView;
using simulator::Mesh;
using simulator::RenderScene;
using simulator::Scene;

constexpr int kRepeats = 4;

/// Of this process, now, what was freed handed back.
double resident_bytes() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  double all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// 2 m a side about `z_m`; 2 `side`^2 triangles of one and the same shape.
Mesh waves(unsigned side, float z_m) {
  Mesh mesh;
  mesh.positions.reserve(std::size_t{side + 1} * (side + 1));
  mesh.triangles.reserve(std::size_t{2} * side * side);
  for (unsigned i = 0; i <= side; ++i) {
    for (unsigned j = 0; j <= side; ++j) {
      const float x = 2 * static_cast<float>(j) / static_cast<float>(side) - 1;
      const float y = 2 * static_cast<float>(i) / static_cast<float>(side) - 1;
      mesh.positions.emplace_back(x, y, z_m + 0.02f * std::sin(30 * x) * std::sin(30 * y));
      if (i == side || j == side) continue;
      const unsigned at = i * (side + 1) + j;
      mesh.triangles.emplace_back(at, at + 1, at + side + 2);
      mesh.triangles.emplace_back(at, at + side + 2, at + side + 1);
    }
  }
  return mesh;
}

/// A grey one, under a sky.
Scene scene_of(Mesh mesh) {
  Scene scene;
  simulator::Material grey;
  grey.base_color = {0.5f, 0.5f, 0.5f, 1};
  grey.metallic = 0;
  scene.materials = {grey};
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

/// As large a wall of one tile that is placed `tiles`^2 times.
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

/// The same with a copy in each place.
Scene copied(const Scene& scene) {
  const Mesh& tile = scene.meshes[0];
  Mesh all;
  all.positions.reserve(tile.positions.size() * tile.placements.size());
  all.triangles.reserve(tile.triangles.size() * tile.placements.size());
  for (const simulator::Placement& placement : tile.placements) {
    const auto first = static_cast<unsigned>(all.positions.size());
    for (const glm::vec3& p : tile.positions) all.positions.push_back(placement.world_from_mesh * glm::vec4(p, 1));
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

/// CPU time of one camera sample, ns: the least of some renders on one thread.
double sample_ns(const RenderScene& world, const CameraView& camera, int samples) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  double best = 1e30;
  for (int i = 0; i < kRepeats; ++i) {
    best = std::min(best, cpu_seconds([&] { render_views(world, camera, {samples, 0, 1}); }));
  }
  return 1e9 * best / (samples * photosites(camera));
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

/// What `scene`, which has `count` triangles, takes.
ordered_json cost_of(const Scene& scene, double count) {
  const double before = resident_bytes();
  std::optional<RenderScene> world;
  const double build_s = cpu_seconds([&] { world.emplace(scene); });
  const double bytes = resident_bytes() - before;
  return {{"triangles", count},
          {"cpu_ns", sample_ns(*world, phone(128, 96), 64)},
          {"ray_ns", ray_ns(*world, phone(128, 96))},
          {"build_s", build_s},
          {"bytes_per_triangle", bytes / count}};
}

ordered_json with_triangles(double triangles) {
  const unsigned side = side_for(triangles);
  return cost_of(wall_of_waves(side), 2.0 * side * side);
}

ordered_json with_placements(double triangles) {
  const auto tiles = static_cast<unsigned>(std::lround(std::sqrt(triangles / kTileTriangles)));
  const double count = kTileTriangles * tiles * tiles;
  const Scene scene = wall_of_tiles(tiles);
  ordered_json row = cost_of(scene, count);
  const ordered_json of_copies = cost_of(copied(scene), count);
  row["placements"] = tiles * tiles;
  for (const char* key : {"cpu_ns", "ray_ns", "build_s", "bytes_per_triangle"}) {
    row[std::string("copied_") + key] = of_copies[key];
  }
  return row;
}

ordered_json with_threads(const RenderScene& world) {
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
  return {{"wall_time_ratio", wall_s[0] / wall_s[1]}, {"cpu_time_ratio", cpu_s[0] / cpu_s[1]}};
}

double deviation(const ordered_json& rows) {
  double low = 1e30, high = 0;
  for (const auto& row : rows) {
    low = std::min(low, row["cpu_ns"].get<double>());
    high = std::max(high, row["cpu_ns"].get<double>());
  }
  return (high - low) / (high + low);
}

using Lines = std::vector<std::pair<std::string, const char*>>;  ///< each one's name and key

std::string chart(const ordered_json& rows, const char* count, const std::string& title, const Lines& lines,
                  const char* y_label) {
  Plot plot;
  plot.title = title;
  plot.x_label = count;
  plot.y_label = y_label;
  plot.log_x = true;
  for (const auto& [name, key] : lines) {
    Series line{name, {}, false, false};
    for (const auto& row : rows) line.points.emplace_back(row[count], row[key]);
    plot.series.push_back(line);
  }
  return svg_plot(plot);
}

}  // namespace

ordered_json measure_scaling(double most_triangles, const std::function<void(double)>& progress) {
  ordered_json result;
  {
    const Scene scene = wall_of_waves(side_for(1e5));
    const RenderScene world(scene);
    for (int samples = 16; samples <= 1024; samples *= 4) {
      result["samples"].push_back({{"samples", samples}, {"cpu_ns", sample_ns(world, phone(96, 72), samples)}});
    }
    progress(0.2);
    for (int width = 64; width <= 512; width *= 2) {
      const CameraView camera = phone(width, width * 3 / 4);
      result["photosites"].push_back({{"photosites", photosites(camera)}, {"cpu_ns", sample_ns(world, camera, 32)}});
    }
    progress(0.5);
    result["threads"] = with_threads(world);
    progress(0.6);
  }
  for (double triangles = 1e4; triangles <= most_triangles; triangles *= 10) {
    result["triangles"].push_back(with_triangles(triangles));
    result["placements"].push_back(with_placements(triangles));
  }
  result["samples_deviation"] = deviation(result["samples"]);
  result["photosites_deviation"] = deviation(result["photosites"]);
  progress(1);
  return result;
}

std::string scaling_section(const ordered_json& scaling) {
  const auto& last = scaling["triangles"].back();
  std::string body = fmt::format(
      "<h2>Growth</h2><p>On a wall of waves made by code, one shadow ray a sample, CPU time of one thread: what a "
      "sample "
      "costs stays within ±{:.1f} % over its number, ±{:.1f} % over that of photosites. Two threads take {:.2f} times "
      "less time than one ({:.2f} of the CPU time). The acceleration structure of {:.1e} triangles takes {:.0f} bytes "
      "each.</p><div class=\"plots\">",
      100 * scaling["samples_deviation"].get<double>(), 100 * scaling["photosites_deviation"].get<double>(),
      scaling["threads"]["wall_time_ratio"].get<double>(), 1 / scaling["threads"]["cpu_time_ratio"].get<double>(),
      last["triangles"].get<double>(), last["bytes_per_triangle"].get<double>());
  const auto& placed = scaling["placements"].back();
  body.insert(
      body.rfind("</p>"),
      fmt::format(" As {} places of one tile they take {:.1f} bytes each, and a ray takes {:.2f} times as long as "
                  "among copies.",
                  placed["placements"].get<int>(), placed["bytes_per_triangle"].get<double>(),
                  placed["ray_ns"].get<double>() / placed["copied_ray_ns"].get<double>()));
  constexpr const char* kTime = "CPU time of a sample, ns";
  const Lines time = {{"measured", "cpu_ns"}};
  body += chart(scaling["samples"], "samples", "Samples of a photosite", time, kTime);
  body += chart(scaling["photosites"], "photosites", "Photosites", time, kTime);
  body += chart(scaling["triangles"], "triangles", "Triangles", time, kTime);
  body += chart(scaling["triangles"], "triangles", "Memory of the acceleration structure",
                {{"measured", "bytes_per_triangle"}}, "bytes of a triangle");
  body += chart(scaling["placements"], "triangles", "Places of a tile of 10082 triangles",
                {{"placed", "ray_ns"}, {"copied", "copied_ray_ns"}}, "CPU time of a ray in Embree, ns");
  return body + "</div>";
}

}  // namespace dualpixel::evaluation
