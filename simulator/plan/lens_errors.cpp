#include "simulator/plan/lens_errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

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

/// By how much red lies farther along each axis than blue, as slopes; none where a tenth of either is blocked, since
/// what passes the rest of the pupil lies elsewhere. Behind a hard split, the light of a sample in the one view that
/// has it is the part of the pupil that it stands for, but for what all of them have in common; where rims cut the
/// pupil from one side, the largest is that of the other side.
std::optional<glm::dvec2> color_gap(const LensSampler& split_lens, const FieldPoint& point) {
  SplitPixel hard;
  hard.kind = SplitKind::hard;
  const LensSampler lens = split_lens.with_split(hard);
  constexpr int kRed = 0, kBlue = 2, kRays = 256;
  const auto mean_slope = [&](int color) -> std::optional<glm::dvec2> {
    alignas(64) float s[4][kPacket];
    LensPacket packet;
    glm::dvec2 sum(0);
    double light[2] = {}, most[2] = {};
    for (int first = 0; first < kRays; first += kPacket) {
      joint_samples(first, 1, s);
      lens.sample(point.x, point.y, color, s, packet);
      for (int i = 0; i < kPacket; ++i) {
        const double weight = packet.left[i] + packet.right[i];
        if (weight == 0) continue;  // blocked: where it would go may not be a number
        sum += weight * glm::dvec2(packet.slope_x[i], packet.slope_y[i]);
        const int view = packet.right[i] > 0 ? 1 : 0;
        light[view] += weight;
        most[view] = std::max(most[view], weight);
      }
    }
    double whole = 0;  // samples of a whole pupil that these stand for
    for (int view = 0; view < 2; ++view) whole += most[view] > 0 ? light[view] / most[view] : 0;
    if (whole < 0.9 * kRays) return {};
    return sum / (light[0] + light[1]);
  };
  const auto red = mean_slope(kRed), blue = mean_slope(kBlue);
  if (!red || !blue) return {};
  return *red - *blue;
}

/// Mean of squares over the points that have one.
struct SquareMean {
  double sum = 0, count = 0;
  void add(double value) { sum += value, count += 1; }
  double root() const { return std::sqrt(sum / count); }  // 0 / 0: not a number
};

LensDifferences differences_of(const LensSampler& lens, const std::vector<DisparityCoefficients>& traced,
                               const LensSampler& reference, const std::vector<DisparityCoefficients>& expected,
                               const std::vector<FieldPoint>& points) {
  const double px_per_slope = reference.lens().thin.image_distance_m() / reference.sensor().pixel_pitch_m;
  const auto light = [](const DisparityCoefficients& c) { return c.left_light + c.right_light; };
  SquareMean shift, color, blur, brightness, share;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const DisparityCoefficients &c = traced[i], &e = expected[i];
    const auto blur_px = [&](const DisparityCoefficients& of) {
      return std::abs(of.blur_slope_px_m * points[i].inverse_depth + of.blur_intercept_px);
    };
    const glm::dvec2 displaced = px_per_slope * (chief_slope(lens, points[i]) - chief_slope(reference, points[i]));
    shift.add(glm::dot(displaced, displaced));
    brightness.add(square(light(c) - light(e)));
    if (c.has_blur() && e.has_blur()) blur.add(square(blur_px(c) - blur_px(e)));
    if (c.has_disparity() && e.has_disparity()) share.add(square(c.left_light / light(c) - e.left_light / light(e)));
    const auto gap = color_gap(lens, points[i]), true_gap = color_gap(reference, points[i]);
    if (gap && true_gap) color.add(glm::dot(*gap - *true_gap, *gap - *true_gap) * square(px_per_slope));
  }
  return {shift.root(), color.root(), blur.root(), brightness.root(), share.root()};
}

void measure_step(const LensSampler& lens, const LensSampler& reference,
                  const std::vector<DisparityCoefficients>& expected, const std::vector<FieldPoint>& points,
                  LensStep& step) {
  const std::vector<DisparityCoefficients> traced = trace_points(lens, points);
  std::vector<double> errors, squares;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const DisparityCoefficients &c = traced[i], &e = expected[i];
    const bool seen = e.left_light > 0 && e.right_light > 0;
    errors.push_back(seen ? std::abs((c.slope_dp_px_m - e.slope_dp_px_m) * points[i].inverse_depth + c.intercept_dp_px -
                                     e.intercept_dp_px)
                          : 0);
    squares.push_back(square(errors.back()));
  }
  step.error_dp_px = upper_rms(squares);
  step.differences = differences_of(lens, traced, reference, expected, points);
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
