#include "simulator/plan/lens_errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
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

/// By how much red lies farther along each axis than blue, as slopes; 0 where no light passes.
glm::dvec2 color_gap(const LensSampler& lens, const FieldPoint& point) {
  constexpr int kRed = 0, kBlue = 2;
  const auto mean_slope = [&](int color) {
    constexpr int kRays = 256;
    alignas(64) float s[4][kPacket];
    LensPacket packet;
    glm::dvec2 sum(0);
    double weights = 0;
    for (int first = 0; first < kRays; first += kPacket) {
      joint_samples(first, 1, s);
      lens.sample(point.x, point.y, color, s, packet);
      for (int i = 0; i < kPacket; ++i) {
        const double weight = packet.left[i] + packet.right[i];
        if (weight == 0) continue;  // blocked: where it would go may not be a number
        sum += weight * glm::dvec2(packet.slope_x[i], packet.slope_y[i]);
        weights += weight;
      }
    }
    return weights > 0 ? sum / weights : glm::dvec2(0);
  };
  return mean_slope(kRed) - mean_slope(kBlue);
}

/// Squares of what differs at one point, in the order of LensDifferences.
std::array<double, 5> squared_differences(const LensSampler& lens, const LensSampler& reference,
                                          const DisparityCoefficients& c, const DisparityCoefficients& e,
                                          const FieldPoint& point) {
  const double px_per_slope = reference.lens().thin.image_distance_m() / reference.sensor().pixel_pitch_m;
  const glm::dvec2 shift = px_per_slope * (chief_slope(lens, point) - chief_slope(reference, point));
  const glm::dvec2 color = px_per_slope * (color_gap(lens, point) - color_gap(reference, point));
  const auto blur = [&](const DisparityCoefficients& of) {
    return std::abs(of.blur_slope_px_m * point.inverse_depth + of.blur_intercept_px);
  };
  const auto light = [](const DisparityCoefficients& of) { return of.left_light + of.right_light; };
  const auto share = [&](const DisparityCoefficients& of) { return light(of) > 0 ? of.left_light / light(of) : 0.5; };
  const bool blurs = c.has_blur() && e.has_blur(), splits = c.has_disparity() && e.has_disparity();
  return {glm::dot(shift, shift), glm::dot(color, color), blurs ? square(blur(c) - blur(e)) : 0,
          square(light(c) - light(e)), splits ? square(share(c) - share(e)) : 0};
}

void measure_step(const LensSampler& lens, const LensSampler& reference,
                  const std::vector<DisparityCoefficients>& expected, const std::vector<FieldPoint>& points,
                  LensStep& step) {
  const std::vector<DisparityCoefficients> traced = trace_points(lens, points);
  std::vector<double> errors, squares;
  std::array<double, 5> sums{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const DisparityCoefficients &c = traced[i], &e = expected[i];
    const bool seen = e.left_light > 0 && e.right_light > 0;
    errors.push_back(seen ? std::abs((c.slope_dp_px_m - e.slope_dp_px_m) * points[i].inverse_depth + c.intercept_dp_px -
                                     e.intercept_dp_px)
                          : 0);
    squares.push_back(square(errors.back()));
    const std::array<double, 5> differences = squared_differences(lens, reference, c, e, points[i]);
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += differences[k];
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(points.size())); };
  step.error_dp_px = upper_rms(squares);
  step.differences = {rms(sums[0]), rms(sums[1]), rms(sums[2]), rms(sums[3]), rms(sums[4])};
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
