#include "simulator/plan/lens_errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "capture/timing.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/plan/error_statistics.h"
#include "simulator/render/camera_rays.h"
#include "simulator/render/glass_paths.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"
#include "simulator/simulate.h"

namespace dualpixel::simulator {
namespace {

constexpr int kColumns = 24, kRows = 18;  ///< of the grid of field points
constexpr int kRaysPerPoint = 2048;

struct FieldPoint {
  int x = 0, y = 0;          ///< photosite
  double inverse_depth = 0;  ///< 1/m, along the reference's chief ray
};

glm::dvec2 chief_slope(const LensSampler& lens, const FieldPoint& point) {
  const glm::dvec2 at = lens.sensor().middle_m(point.x, point.y);
  return lens.chief_slope(at.x, at.y);
}

/// One point in each cell of a grid over the sensor.
std::vector<FieldPoint> stratified_points(const RenderScene& world, const CameraView& camera, std::uint64_t seed) {
  const SensorGrid& sensor = camera.lens.sensor();
  std::vector<FieldPoint> points;
  for (int i = 0; i < kColumns * kRows; ++i) {
    const std::uint64_t key = hash(seed, i);
    const double u = unit_float(static_cast<std::uint32_t>(key));
    const double v = unit_float(static_cast<std::uint32_t>(key >> 32));
    const auto row = i / kColumns;
    FieldPoint point{static_cast<int>((i % kColumns + u) / kColumns * sensor.width_px),
                     static_cast<int>((row + v) / kRows * sensor.height_px)};
    const auto hit = seen_surface(world, chief_ray(camera, point.x, point.y));
    if (hit) point.inverse_depth = 1 / static_cast<double>(hit->t);
    points.push_back(point);
  }
  return points;
}

std::vector<DisparityCoefficients> trace_points(const LensSampler& lens, const std::vector<FieldPoint>& points) {
  std::vector<DisparityCoefficients> traced(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(),
                    [&](std::size_t i) { traced[i] = trace_disparity(lens, points[i].x, points[i].y, kRaysPerPoint); });
  return traced;
}

/// Time of a sample through the lens alone, all threads at work.
double sampling_seconds(const LensSampler& lens, const std::vector<FieldPoint>& points) {
  constexpr int kSamples = 1024;
  const auto sample_all = [&] {
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
      alignas(64) float s[4][kPacket];
      LensPacket packet;
      for (int first = 0; first < kSamples; first += kPacket) {
        joint_samples(first, i, s);
        lens.sample(points[i].x, points[i].y, 1, s, packet);
      }
    });
  };
  sample_all();
  return std::min(seconds(sample_all), seconds(sample_all)) / (static_cast<double>(points.size()) * kSamples);
}

/// Disparity errors at each point; 0 where the reference sees nothing.
std::vector<double> disparity_errors(const LensSampler& lens, const std::vector<DisparityCoefficients>& expected,
                                     const std::vector<FieldPoint>& points) {
  std::vector<double> errors(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const DisparityCoefficients& e = expected[i];
    if (e.left_light == 0 || e.right_light == 0) return;
    const auto c = trace_disparity(lens, points[i].x, points[i].y, kRaysPerPoint);
    errors[i] =
        std::abs((c.slope_dp_px_m - e.slope_dp_px_m) * points[i].inverse_depth + c.intercept_dp_px - e.intercept_dp_px);
  });
  return errors;
}

void measure_step(const LensSampler& lens, const LensSampler& reference,
                  const std::vector<DisparityCoefficients>& expected, const std::vector<FieldPoint>& points,
                  LensStep& step) {
  const double px_per_slope = reference.lens().thin.image_distance_m() / reference.sensor().pixel_pitch_m;
  std::vector<double> errors = disparity_errors(lens, expected, points);
  std::vector<double> squares;
  double shifts2 = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    squares.push_back(square(errors[i]));
    const glm::dvec2 gap = chief_slope(lens, points[i]) - chief_slope(reference, points[i]);
    shifts2 += glm::dot(gap, gap) * square(px_per_slope);
  }
  step.error_dp_px = upper_rms(squares);
  step.picture_shift_px = std::sqrt(shifts2 / static_cast<double>(points.size()));
  step.seconds_per_sample = sampling_seconds(lens, points);
  std::sort(errors.begin(), errors.end());
  step.error_95_dp_px = errors[errors.size() * 95 / 100];
}

}  // namespace

void measure_lens_errors(const Simulation& simulation, const RenderScene& world, std::uint64_t seed,
                         std::vector<LensStep>& steps) {
  const auto lens_of = [&](const LensStep& step) {
    return prepare_lens(simulation, step.candidate.lens, sensor_grid(simulation.sensor));
  };
  const CameraView reference{camera_pose(simulation, world.scene), lens_of(steps.back())};
  const std::vector<FieldPoint> points = stratified_points(world, reference, seed);
  const std::vector<DisparityCoefficients> expected = trace_points(reference.lens, points);
  steps.back().seconds_per_sample = sampling_seconds(reference.lens, points);
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    measure_step(lens_of(steps[i]), reference.lens, expected, points, steps[i]);
  }
}

}  // namespace dualpixel::simulator
