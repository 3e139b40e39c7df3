#include "evaluation/calibration_sweep/traced_skew.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/glm.hpp>
#include <numbers>
#include <vector>

#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "pipeline/disparity/split/options.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/pupil_rays.h"

namespace dualpixel::evaluation {
namespace {

using Complex = std::complex<double>;

/// Where both views' rays of a point land, DP px from the middle between their centroids; x along the baseline, y in
/// the same unit.
struct Kernels {
  struct Point {
    double x = 0, y = 0, left = 0, right = 0;  // the weights of each view add up to 1
  };
  std::vector<Point> points;
  double disparity = 0;
};

/// A wave's transform, and that of x times the kernel, for each view.
struct Transforms {
  Complex left, right, left_x, right_x;
  double least() const { return std::min(std::abs(left), std::abs(right)); }
};

Transforms transform(const Kernels& kernels, double frequency_x, double frequency_y) {
  Transforms t;
  for (const Kernels::Point& p : kernels.points) {
    const Complex wave = std::polar(1.0, -(frequency_x * p.x + frequency_y * p.y));
    t.left += p.left * wave;
    t.right += p.right * wave;
    t.left_x += p.left * p.x * wave;
    t.right_x += p.right * p.x * wave;
  }
  return t;
}

/// What each ray of a pupil adds: its landing point is intercept + slope / depth.
class PupilKernels {
 public:
  PupilKernels(const simulator::LensSampler& lens, int x, int y) {
    constexpr int kRays = 2048;
    constexpr double kLeastLight = 0.005, kLeastSlope = 0.2;  // of the axis
    const simulator::PupilRays pupil = trace_pupil(lens, x, y, kRays);
    double left = 0, right = 0;
    for (const simulator::PupilRay& ray : pupil.rays) left += ray.left, right += ray.right;
    const double dp_px = lens.sensor().dp_downsample_x;
    for (const simulator::PupilRay& ray : pupil.rays) {
      const glm::dvec2 slope = -(pupil.photosites_per_slope * ray.origin_m) / dp_px;
      const glm::dvec2 intercept = -(pupil.photosites_per_slope * ray.slope) / dp_px;
      rays_.push_back({slope, intercept, ray.left / left, ray.right / right});
      const double gap = ray.right / right - ray.left / left;
      slope_ += gap * slope.x;
      intercept_ += gap * intercept.x;
    }
    const simulator::ThinLens& thin = lens.lens().thin;
    const double axis_slope = -lens.lens().split.alpha(thin.rim_slope()) * thin.pupil_diameter_m() *
                              thin.image_distance_m() / (lens.sensor().pixel_pitch_m * dp_px);
    tells_ = std::min(left, right) > kLeastLight * kRays && slope_ / axis_slope >= kLeastSlope;
  }

  /// Whether there is enough light, and disparity that changes with depth.
  bool tells() const { return tells_; }

  /// At the depth where the centroids lie `disparity` apart.
  Kernels at(double disparity) const {
    const double inverse_depth = (disparity - intercept_) / slope_;
    Kernels kernels{{}, disparity};
    glm::dvec2 middle(0);
    for (const Ray& ray : rays_) {
      const glm::dvec2 at = ray.slope * inverse_depth + ray.intercept;
      kernels.points.push_back({at.x, at.y, ray.left, ray.right});
      middle += (ray.left + ray.right) / 2 * at;
    }
    for (Kernels::Point& point : kernels.points) point.x -= middle.x, point.y -= middle.y;
    return kernels;
  }

 private:
  struct Ray {
    glm::dvec2 slope, intercept;
    double left = 0, right = 0;
  };
  std::vector<Ray> rays_;
  double slope_ = 0, intercept_ = 0;
  bool tells_ = false;
};

/// The highest frequency of which both kernels leave enough; radians a DP px.
double frequency(const Kernels& kernels, bool along) {
  constexpr double kHighest = 2 * std::numbers::pi * 0.15, kLowest = 0.1 * kHighest, kLeastLeft = 0.4;
  double f = kHighest;
  while (f > kLowest && transform(kernels, along ? f : 0, along ? 0 : f).least() < kLeastLeft) f *= 0.8;
  return f;
}

/// xxx that would shift waves along the baseline as the kernels do.
double skew_along(const Kernels& kernels) {
  const double f = frequency(kernels, true);
  const Transforms t = transform(kernels, f, 0);
  return -3 * (-std::arg(t.right / t.left) / f - kernels.disparity) / (f * f);
}

/// xyy that would shift waves as the kernels do that are all but across the baseline.
double skew_across(const Kernels& kernels) {
  const double f = frequency(kernels, false);
  const Transforms t = transform(kernels, 0, f);
  return -((t.right_x / t.right - t.left_x / t.left).real() - kernels.disparity) / (f * f);
}

}  // namespace

pipeline::SkewCurve trace_skew(const simulator::LensSampler& lens, double pixel_height, int x, int y) {
  const double alpha = std::abs(lens.lens().split.alpha(lens.lens().thin.rim_slope()));
  pipeline::SkewCurve curve = pipeline::skew_of_split(alpha, pixel_height);
  const PupilKernels pupil(lens, x, y);
  if (!pupil.tells()) return curve;
  constexpr int kDisparities = 9;
  constexpr int kCoefficients = std::tuple_size_v<pipeline::SkewCurve::Coefficients>;
  Eigen::Matrix<double, kDisparities, kCoefficients> powers;
  Eigen::Matrix<double, kDisparities, 2> skews;
  for (int i = 0; i < kDisparities; ++i) {
    const double disparity = curve.farthest_dp_px * (2.0 * i / (kDisparities - 1) - 1);
    const Kernels kernels = pupil.at(disparity);
    for (int k = 0; k < kCoefficients; ++k) powers(i, k) = std::pow(disparity, k);
    skews(i, 0) = skew_along(kernels);
    skews(i, 1) = skew_across(kernels) / (pixel_height * pixel_height);
  }
  const Eigen::Matrix<double, kCoefficients, 2> fit = powers.colPivHouseholderQr().solve(skews);
  if (!fit.allFinite()) return curve;
  for (int k = 0; k < kCoefficients; ++k) {
    curve.xxx[k] = static_cast<float>(fit(k, 0));
    curve.xyy[k] = static_cast<float>(fit(k, 1));
  }
  return curve;
}

pipeline::SkewField trace_skew(const simulator::LensSampler& lens, double pixel_height) {
  const simulator::SensorGrid& sensor = lens.sensor();
  if (same_everywhere(lens.lens())) {
    return {1, 1, {trace_skew(lens, pixel_height, sensor.width_px / 2, sensor.height_px / 2)}};
  }
  constexpr int kColumns = 11, kRows = 8;  // linear in between: that errs by .013 DP px^3, or .004 DP px of shift
  pipeline::SkewField field{kColumns, kRows,
                            std::vector<pipeline::SkewCurve>(static_cast<std::size_t>(kColumns) * kRows)};
  tbb::parallel_for(0, kColumns * kRows, [&](int i) {
    const int x = i % kColumns * sensor.width_px / (kColumns - 1), y = i / kColumns * sensor.height_px / (kRows - 1);
    field.nodes[i] =
        trace_skew(lens, pixel_height, std::min(x, sensor.width_px - 1), std::min(y, sensor.height_px - 1));
  });
  return field;
}

void add_traced_skew(const simulator::Simulation& simulation, pipeline::Calibration& calibration) {
  const simulator::SensorOptions& sensor = simulation.sensor;
  const double pixel_height = static_cast<double>(sensor.dp_downsample_y) / sensor.dp_downsample_x;
  if (!(pipeline::alpha_of_camera(static_cast<float>(describe_camera(simulation).alpha)) > 0)) return;
  for (pipeline::FocusCalibration& focus : calibration.focuses) {
    focus.skew = trace_skew(focused_lens(simulation, focus.focus_distance_m), pixel_height);
  }
}

}  // namespace dualpixel::evaluation
