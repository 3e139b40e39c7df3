#include "evaluation/camera_fit/camera_figures.h"

#include <algorithm>
#include <cmath>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::evaluation {
namespace {

using simulator::kPacket;

/// Sums of weighted points.
struct Moments {
  double light = 0, third_x = 0;
  glm::dvec2 first{0}, second{0};

  void add(double weight, glm::dvec2 at) {
    light += weight;
    first += weight * at;
    second += weight * at * at;
    third_x += weight * at.x * at.x * at.x;
  }
  glm::dvec2 sigma() const {
    const glm::dvec2 mean = first / light;
    return glm::sqrt(glm::max(second / light - mean * mean, glm::dvec2(0)));
  }
  BlurKernel kernel(int samples) const {
    BlurKernel k;
    k.light = light / samples;
    if (light == 0) return k;
    k.centroid_m = first / light;
    k.sigma_m = sigma();
    const double mean = k.centroid_m.x, variance = k.sigma_m.x * k.sigma_m.x;
    const double third = third_x / light - 3 * mean * variance - mean * mean * mean;
    if (variance > 0) k.skew_x = third / (variance * k.sigma_m.x);
    return k;
  }
};

/// Meters on the sensor per slope in front of the lens, at a position on the sensor.
glm::dmat2 meters_per_slope(const simulator::LensSampler& lens, glm::dvec2 at_m) {
  const double step_m = lens.sensor().pixel_pitch_m;
  const auto per_m = [&](glm::dvec2 step) {
    const glm::dvec2 ahead = at_m + step, behind = at_m - step;
    return (lens.chief_slope(ahead.x, ahead.y) - lens.chief_slope(behind.x, behind.y)) / (2 * step_m);
  };
  return glm::inverse(glm::dmat2(per_m({step_m, 0}), per_m({0, step_m})));
}

}  // namespace

PointFigures trace_point(const simulator::LensSampler& lens, int x, int y, double depth_m, int samples) {
  const glm::dvec2 at_m = lens.sensor().middle_m(x, y);
  const glm::dvec2 chief = lens.chief_slope(at_m.x, at_m.y);
  const glm::dmat2 to_sensor = meters_per_slope(lens, at_m);
  Moments left, right, sum;
  alignas(64) float s[4][kPacket];
  simulator::LensPacket rays;
  for (int first = 0; first < samples; first += kPacket) {
    simulator::joint_samples(first, 0, s);
    std::fill(&s[0][0], &s[2][0], 0.5f);
    lens.sample(x, y, 1, s, rays);
    for (int i = 0; i < kPacket; ++i) {
      const glm::dvec2 origin(rays.origin_x[i], rays.origin_y[i]), slope(rays.slope_x[i], rays.slope_y[i]);
      // what the photosite gathers from beside the point, the point spreads to the other side
      const glm::dvec2 at = -(to_sensor * (origin / depth_m + slope - chief));
      left.add(rays.left[i], at);
      right.add(rays.right[i], at);
      sum.add(static_cast<double>(rays.left[i]) + rays.right[i], at);
    }
  }
  PointFigures figures{left.kernel(samples), right.kernel(samples)};
  if (sum.light > 0) figures.sum_sigma_m = sum.sigma();
  return figures;
}

}  // namespace dualpixel::evaluation
