#include "simulator/lens/disparity_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

#include "capture/image/bilinear.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/lens/pupil_rays.h"

namespace dualpixel::simulator {
namespace {

/// Sums over rays with one view's weight.
struct Sums {
  double light = 0;
  glm::dvec2 origin{0}, slope{0};
  void add(double weight, glm::dvec2 o, glm::dvec2 m) {
    light += weight;
    origin += weight * o;
    slope += weight * m;
  }
};

DisparityCoefficients closed_form(const LensSampler& lens) {
  const ThinLens& thin = lens.lens().thin;
  const double per_px = 1 / lens.sensor().pixel_pitch_m;
  const double dp_px_per_px = 1.0 / lens.sensor().dp_downsample_x;
  const double alpha = lens.lens().split.alpha(thin.rim_slope());
  DisparityCoefficients c;
  c.blur_intercept_px = thin.blur_diameter_m(std::numeric_limits<double>::infinity()) * per_px;
  c.blur_slope_px_m = -thin.pupil_diameter_m() * thin.image_distance_m() * per_px;
  c.intercept_dp_px = alpha * c.blur_intercept_px * dp_px_per_px;
  c.slope_dp_px_m = alpha * c.blur_slope_px_m * dp_px_per_px;
  const DisparityCoefficients traced = trace_disparity(lens, 0, 0);
  c.left_light = traced.left_light;
  c.right_light = traced.right_light;
  return c;
}

}  // namespace

bool same_everywhere(const Lens& lens) {
  return std::holds_alternative<ThinModel>(lens.model) && lens.split.microlens.design_exit_pupil_mm == 0;
}

DisparityCoefficients trace_disparity(const LensSampler& lens, int x, int y, int samples) {
  const PupilRays pupil = trace_pupil(lens, x, y, samples);
  Sums left, right;
  for (const PupilRay& ray : pupil.rays) {
    left.add(ray.left, ray.origin_m, ray.slope);
    right.add(ray.right, ray.origin_m, ray.slope);
  }
  DisparityCoefficients c;
  c.left_light = left.light / samples;
  c.right_light = right.light / samples;
  if (!c.has_blur()) return c;

  const glm::dmat2& px_per_slope = pupil.photosites_per_slope;
  if (c.has_disparity()) {
    const int dp_px = lens.sensor().dp_downsample_x;
    const glm::dvec2 origin_gap = right.origin / right.light - left.origin / left.light;
    const glm::dvec2 slope_gap = right.slope / right.light - left.slope / left.light;
    c.slope_dp_px_m = -(px_per_slope * origin_gap).x / dp_px;
    c.intercept_dp_px = -(px_per_slope * slope_gap).x / dp_px;
  }

  // the disc of the whole pupil that fits the rays' misses best
  const double light = left.light + right.light;
  const glm::dvec2 mean_origin = (left.origin + right.origin) / light;
  const glm::dvec2 mean_slope = (left.slope + right.slope) / light;
  double square = 0, from_origin = 0, from_slope = 0;
  for (const PupilRay& ray : pupil.rays) {
    const double weight = ray.left + ray.right;
    const glm::dvec2 o = ray.origin_m - mean_origin;
    square += weight * glm::dot(o, o);
    from_origin += weight * glm::dot(px_per_slope * o, o);
    from_slope += weight * glm::dot(px_per_slope * (ray.slope - mean_slope), o);
  }
  const double diameter = lens.lens().thin.pupil_diameter_m();
  c.blur_slope_px_m = -diameter * from_origin / square;
  c.blur_intercept_px = -diameter * from_slope / square;
  return c;
}

namespace {

/// Gives every node of the grid that cannot tell what the nearest one that can has.
void fill_dark_nodes(std::vector<DisparityCoefficients>& nodes, int columns, const DisparityCoefficients& otherwise) {
  using C = DisparityCoefficients;
  const auto fill = [&](bool (C::*tells)() const, const std::array<double C::*, 2>& fields) {
    const std::vector<C> traced = nodes;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if ((traced[i].*tells)()) continue;
      const C* best = &otherwise;
      int nearest = std::numeric_limits<int>::max();
      for (std::size_t k = 0; k < traced.size(); ++k) {
        if (!(traced[k].*tells)()) continue;
        const int x = static_cast<int>(k % columns) - static_cast<int>(i % columns);
        const int y = static_cast<int>(k / columns) - static_cast<int>(i / columns);
        if (x * x + y * y >= nearest) continue;
        nearest = x * x + y * y;
        best = &traced[k];
      }
      for (double C::*field : fields) nodes[i].*field = best->*field;
    }
  };
  fill(&C::has_disparity, {&C::slope_dp_px_m, &C::intercept_dp_px});
  fill(&C::has_blur, {&C::blur_slope_px_m, &C::blur_intercept_px});
}

}  // namespace

DisparityField::DisparityField(const LensSampler& lens) {
  if (same_everywhere(lens.lens())) {
    nodes_ = {closed_form(lens)};
    return;
  }
  const SensorGrid& sensor = lens.sensor();
  columns_ = std::min(65, sensor.width_px);
  rows_ = std::min(49, sensor.height_px);
  per_px_x_ = columns_ > 1 ? (columns_ - 1.0) / (sensor.width_px - 1) : 0;
  per_px_y_ = rows_ > 1 ? (rows_ - 1.0) / (sensor.height_px - 1) : 0;
  nodes_.resize(static_cast<std::size_t>(columns_) * rows_);
  tbb::parallel_for(0, columns_ * rows_, [&](int i) {
    const int column = i % columns_, row = i / columns_;
    const int x = columns_ > 1 ? static_cast<int>(std::lround(column / per_px_x_)) : 0;
    const int y = rows_ > 1 ? static_cast<int>(std::lround(row / per_px_y_)) : 0;
    nodes_[i] = trace_disparity(lens, x, y, 2048);
  });
  fill_dark_nodes(nodes_, columns_, closed_form(lens));
}

DisparityCoefficients DisparityField::at(double x_px, double y_px) const {
  if (nodes_.size() == 1) return nodes_.front();
  const BilinearTap u = bilinear_tap((x_px - 0.5) * per_px_x_, columns_);
  const BilinearTap v = bilinear_tap((y_px - 0.5) * per_px_y_, rows_);
  DisparityCoefficients c;
  for (double DisparityCoefficients::*field :
       {&DisparityCoefficients::slope_dp_px_m, &DisparityCoefficients::intercept_dp_px,
        &DisparityCoefficients::blur_slope_px_m, &DisparityCoefficients::blur_intercept_px,
        &DisparityCoefficients::left_light, &DisparityCoefficients::right_light}) {
    c.*field = bilinear(u, v, [&](int column, int row) { return nodes_[row * columns_ + column].*field; });
  }
  return c;
}

}  // namespace dualpixel::simulator
