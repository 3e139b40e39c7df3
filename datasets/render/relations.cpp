#include "datasets/render/relations.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>

#include "capture/error.h"
#include "scenes/drawn/meter.h"
#include "simulator/render/pixel.h"
#include "simulator/render/truth.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/simulate.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;

constexpr int kDigits = 4;  // of what follows from rays

double short_number(double value) { return std::stod(fmt::format("{:.{}g}", value, kDigits)); }

void set_pose(json& scene_file, glm::vec3 position, glm::vec3 look_at) {
  json& camera = scene_file["camera"];
  if (camera.is_object()) camera.erase("node");
  camera["position_m"] = {position.x, position.y, position.z};
  camera["look_at_m"] = {look_at.x, look_at.y, look_at.z};
  camera["up"] = {0, 1, 0};
}

/// Whether the ray leaves a solid where it hits: by the corners' normals where there are any, as files' windings often
/// err; otherwise by the winding.
bool is_back(const simulator::Mesh& mesh, const simulator::Hit& hit, glm::vec3 direction) {
  const glm::uvec3 t = mesh.triangles[hit.triangle];
  if (!mesh.placements.empty()) {
    direction = glm::inverse(glm::mat3(mesh.placements[hit.placement].world_from_mesh)) * direction;
  }
  const glm::vec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
  const glm::vec3 normal =
      mesh.normals.empty() ? glm::cross(b - a, c - a) : mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
  return glm::dot(normal, direction) > 0;
}

/// No wall or thing right at the camera, no solid around it, and nothing just before it on the way to the middle.
bool is_free(const simulator::ReadyScene& ready, glm::vec3 position, glm::vec3 middle) {
  constexpr float kClearance = 0.1f, kFreeWay = 0.3f;  // of the distance to the middle
  const glm::vec3 way = middle - position;
  const float distance = glm::length(way);
  int hits = 0, backs = 0;
  for (int i = 0; i < 27; ++i) {
    const glm::vec3 direction(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (direction == glm::vec3(0)) continue;
    const auto hit = ready.world.intersector.intersect({position, glm::normalize(direction)});
    if (!hit) continue;
    if (hit->t < kClearance * distance) return false;
    ++hits;
    backs += is_back(ready.scene.meshes[hit->mesh], *hit, direction) ? 1 : 0;
  }
  if (2 * backs > hits) return false;  // most of what it sees is the inside of things
  const auto hit = ready.world.intersector.intersect({position, way / distance});
  return !hit || hit->t >= kFreeWay * distance;
}

/// On the line's place of the shell, or else further around: the golden angle apart.
void place_on_shell(const json& shell, const simulator::ReadyScene& ready, const std::string& path, json& scene_file) {
  constexpr double kRadians = std::numbers::pi / 180, kGoldenAngle = 137.50776405003785;
  constexpr int kPlaces = 24;
  const auto bounds = ready.world.intersector.bounds();
  const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
  const double radius = 0.5 * glm::length(bounds.high - bounds.low);
  const double distance = radius * shell.at("distance").get<double>();
  const double up = kRadians * shell.at("elevation_deg").get<double>();
  for (int i = 0; i < kPlaces; ++i) {
    const double around = kRadians * (shell.at("azimuth_deg").get<double>() + i * kGoldenAngle);
    const glm::vec3 position = middle + glm::vec3(distance * std::cos(up) * std::sin(around), distance * std::sin(up),
                                                  distance * std::cos(up) * std::cos(around));
    if (is_free(ready, position, middle)) return set_pose(scene_file, position, middle);
  }
  throw InputError(printable(path) + ": camera_shell: no free place was found around the scene");
}

/// Depth that the camera sees through a pinhole, at the place of the picture that is nearest to `at` and sees anything.
double depth_at(const json& at, const simulator::Simulation& s, const simulator::ReadyScene& ready) {
  constexpr int kWidth = 64;
  simulator::SensorGrid grid = simulator::sensor_grid(s.sensor);
  const double reduction = static_cast<double>(grid.width_px) / kWidth;
  const int height = std::max(4, static_cast<int>(std::lround(grid.height_px / reduction)));
  grid = {kWidth, height, grid.pixel_pitch_m * reduction, {0.5 * kWidth, 0.5 * height}};
  simulator::Lens lens;
  lens.thin = s.lens.thin;
  const simulator::CameraView camera{simulator::camera_pose(s, ready.scene), simulator::LensSampler(lens, grid)};
  const Truth truth = simulator::trace_truth(ready.world, camera);
  const double x = at.at(0).get<double>() * kWidth, y = at.at(1).get<double>() * height;
  double nearest = std::numeric_limits<double>::infinity(), depth = 0;
  for (int py = 0; py < height; ++py) {
    for (int px = 0; px < kWidth; ++px) {
      const double away = std::hypot(px + 0.5 - x, py + 0.5 - y);
      if (truth.valid.at(px, py) == 0 || away >= nearest) continue;
      nearest = away;
      depth = truth.depth_m.at(px, py);
    }
  }
  if (depth == 0) throw InputError(printable(s.path) + ": focus_at: the camera sees no surface");
  return depth;
}

/// Green signal over the white level at 1 s and ISO 100, of one photosite in each cell of a grid.
std::vector<double> metered(const simulator::Simulation& s, const simulator::RenderScene& world,
                            const simulator::CameraView& camera) {
  constexpr int kColumns = 48, kRows = 36;
  constexpr std::uint32_t kSamples = 4;
  constexpr std::uint64_t kStream = 0x6d65746572;
  const simulator::PathOptions paths{s.render.max_bounces, {}, s.render.sampling};
  const double signal_per_nit = camera.lens.lux_per_nit() * s.sensor.electrons_per_lux_s[1] / s.sensor.full_well_e;
  std::vector<double> signals(std::size_t{kColumns} * kRows);
  tbb::parallel_for(std::size_t{0}, signals.size(), [&](std::size_t i) {
    const int column = static_cast<int>(i) % kColumns, row = static_cast<int>(i) / kColumns;
    int x = (2 * column + 1) * s.sensor.width_px / (2 * kColumns);
    const int y = (2 * row + 1) * s.sensor.height_px / (2 * kRows);
    if (simulator::cfa_color(x, y) != 1) x ^= 1;
    const auto seen =
        simulator::render_pixel(world, camera, paths, x, y, kSamples, simulator::hash(s.render.seed, kStream, i));
    signals[i] = signal_per_nit * (seen.left[1] + seen.right[1]);
  });
  return signals;
}

/// The factor by which the mean of the clipped signals becomes `mean`, by bisection of its logarithm.
double exposure_factor(const std::vector<double>& signals, double mean) {
  double low = std::log(1e-12), high = std::log(1e12);
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high), factor = std::exp(middle);
    double sum = 0;
    for (const double signal : signals) sum += std::min(1.0, factor * signal);
    (sum < mean * static_cast<double>(signals.size()) ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

void stand_in_for_relations(const SampleLine& line, json& scene_file) {
  if (line.relations.contains("camera_shell")) set_pose(scene_file, {0, 0, 1}, {0, 0, 0});
}

void resolve_geometry(const SampleLine& line, const simulator::ReadyScene& ready, const std::string& path,
                      json& scene_file) {
  const json& r = line.relations;
  if (r.contains("camera_shell")) place_on_shell(r.at("camera_shell"), ready, path, scene_file);
  if (!r.contains("focus_at")) return;
  constexpr double kNearest_m = 0.08, kFarthest_m = 1000;
  const double depth = depth_at(r.at("focus_at"), simulator::read_simulation(scene_file, path), ready);
  scene_file["camera"]["focus_distance_m"] = short_number(std::clamp(depth, kNearest_m, kFarthest_m));
}

void resolve_exposure(double mean, const json& set, const simulator::Simulation& s, simulator::ReadyScene& ready,
                      const simulator::CameraView& camera, json& scene_file) {
  // without the light that other samples left, of which there may be more or less
  std::unique_ptr<simulator::LightCache> kept;
  kept.swap(ready.world.light_cache);
  const std::vector<double> signals = metered(s, ready.world, camera);
  kept.swap(ready.world.light_cache);
  const double seconds = exposure_factor(signals, mean);  // at ISO 100
  if (seconds > 1e11) throw InputError(printable(s.path) + ": exposure_mean: the camera sees no light");
  json& exposure = scene_file["exposure"];
  if (set.contains("exposure.iso")) {
    exposure["time_s"] = short_number(seconds * 100 / s.exposure.iso);
  } else if (set.contains("exposure.time_s")) {
    exposure["iso"] = short_number(seconds * 100 / s.exposure.time_s);
  } else {
    scenes::set_exposure(scene_file, seconds, kDigits);
  }
}

}  // namespace dualpixel::datasets
