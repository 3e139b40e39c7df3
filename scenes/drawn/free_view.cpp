#include "scenes/drawn/free_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/image/resample.h"

namespace dualpixel::scenes {
namespace {

using glm::vec3;

constexpr float kNearest_m = 0.03f;      ///< of anything, in any direction
constexpr double kMostEnclosed = 0.6;    ///< of all directions that meet something nearer than Shooting::clear_m
constexpr double kMostNear = 0.25;       ///< of the picture that may be nearer than that
constexpr double kLeastSeen = 0.1;       ///< of the picture that shows a surface
constexpr double kLeastContrast = 0.06;  ///< deviation of log luminance over blocks of the picture
constexpr float kSubjectFrom = 0.6f;     ///< of the way to the subject that must be free
constexpr float kSubjectInside = 0.85f;  ///< of the half picture within which the subject must lie

/// How near things are around the camera.
struct Surroundings {
  float nearest_m = 1e9f;
  double enclosed = 0;  ///< share of directions that meet something within `clear_m`
};

/// Directions of a Fibonacci lattice: each stands for the same solid angle.
Surroundings look_around(const Look& look, float clear_m) {
  constexpr int kDirections = 512;
  const float golden = std::numbers::pi_v<float> * (3 - std::sqrt(5.0f));
  Surroundings around;
  for (int i = 0; i < kDirections; ++i) {
    const float y = 1 - 2 * (static_cast<float>(i) + 0.5f) / kDirections, r = std::sqrt(1 - y * y),
                phi = golden * static_cast<float>(i);
    const simulator::Ray ray{vec3(look.camera.world_from_camera[3]), {r * std::cos(phi), y, r * std::sin(phi)}};
    const auto hit = look.world.intersector.intersect(ray);
    if (!hit) continue;
    around.nearest_m = std::min(around.nearest_m, hit->t);
    if (hit->t < clear_m) around.enclosed += 1.0 / kDirections;
  }
  return around;
}

template <typename Counts>
double share_of_picture(const Truth& truth, const Counts& counts) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < truth.valid.data.size(); ++i) n += counts(truth.valid.data[i] > 0, truth.depth_m.data[i]);
  return static_cast<double>(n) / static_cast<double>(truth.valid.data.size());
}

/// Deviation of log luminance over blocks that are larger than rendering noise and texture.
double contrast(const Image& picture) {
  const Image blocks = resize_area(picture, 16, 12);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < blocks.pixel_count(); ++i) {
    const float* p = &blocks.data[3 * i];
    const double log_luminance = std::log(std::max(0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2], 1e-6f));
    sum += log_luminance, squares += log_luminance * log_luminance;
  }
  const auto n = static_cast<double>(blocks.pixel_count());
  return std::sqrt(std::max(squares / n - sum / n * (sum / n), 0.0));
}

std::string subject_fault(const Look& look, vec3 subject) {
  const vec3 eye(look.camera.world_from_camera[3]);
  const vec3 seen = glm::transpose(glm::mat3(look.camera.world_from_camera)) * (subject - eye);
  const auto& sensor = look.camera.lens.sensor();
  const glm::vec2 corner = glm::abs(look.camera.lens.chief_slope(sensor.middle_m(0, 0).x, sensor.middle_m(0, 0).y));
  if (seen.z <= 0 || std::abs(seen.x) > kSubjectInside * corner.x * seen.z ||
      std::abs(seen.y) > kSubjectInside * corner.y * seen.z)
    return "the subject is out of the picture";
  const auto hit = look.world.intersector.intersect({eye, subject - eye});
  if (hit && hit->t < kSubjectFrom) return "something hides the subject";
  return "";
}

}  // namespace

std::string view_fault(const Look& look, const Shooting& shooting) {
  const Surroundings around = look_around(look, shooting.clear_m);
  if (around.nearest_m < kNearest_m)
    return fmt::format("something is {:.3g} m from the camera, nearer than {}", around.nearest_m, kNearest_m);
  if (around.enclosed > kMostEnclosed)
    return fmt::format("the camera is shut in: {:.0f} % of all directions end within {:.2g} m", 100 * around.enclosed,
                       shooting.clear_m);
  const double near =
      share_of_picture(look.truth, [&](bool seen, float depth_m) { return seen && depth_m < shooting.clear_m; });
  if (near > kMostNear)
    return fmt::format("{:.0f} % of the picture are nearer than {:.2g} m", 100 * near, shooting.clear_m);
  const double seen = share_of_picture(look.truth, [](bool valid, float) { return valid; });
  if (seen < kLeastSeen) return fmt::format("only {:.0f} % of the picture show anything", 100 * seen);
  if (contrast(look.picture) < kLeastContrast) return "the picture shows an even surface and nothing else";
  return shooting.subject ? subject_fault(look, *shooting.subject) : "";
}

}  // namespace dualpixel::scenes
