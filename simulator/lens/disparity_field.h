#pragma once
#include <algorithm>
#include <vector>

/// What a calibration of this camera should find: at every point x of the sensor a point at planar depth D has, to
/// first order exactly,
///     centroid disparity = slope_dp_px_m(x) / D + intercept_dp_px(x)    (S_z, I_z of Wadhwa et al. 2018, section 4.2)
///     signed blur        = blur_slope_px_m(x) / D + blur_intercept_px(x)
/// because a ray that reaches x from the pupil point o with slope m sees depth D at o + D m: what it misses the chief
/// ray by, turned into sensor length, is linear in 1/D. Each view's centroid is the mean over its rays.
namespace dualpixel::simulator {

class LensSampler;
struct Lens;

/// Disparity is in DP pixels of SensorGrid::dp_downsample_x photosites, blur in photosites.
struct DisparityCoefficients {
  double slope_dp_px_m = 0, intercept_dp_px = 0;
  double blur_slope_px_m = 0, blur_intercept_px = 0;
  double left_light = 0, right_light = 0;  ///< illumination of each view over that of the whole axis

  /// Whether enough light passes for the coefficients to be told; those that cannot are 0.
  bool has_disparity() const { return std::min(left_light, right_light) > kLeastLight / 2; }
  bool has_blur() const { return left_light + right_light > kLeastLight; }

 private:
  static constexpr double kLeastLight = 0.01;  ///< slivers of a pupil are no disc, and what they show is black
};

/// Whether all photosites see the pupil alike.
bool same_everywhere(const Lens& lens);

/// By `samples` rays (a multiple of 16) of photosite (x, y)'s center.
DisparityCoefficients trace_disparity(const LensSampler& lens, int x, int y, int samples = 4096);

/// The same over the whole sensor: a grid of traced field points, bilinear in between; a thin lens needs one. Where too
/// little light passes to tell, the coefficients are those of the nearest point that tells, so that all are finite.
class DisparityField {
 public:
  explicit DisparityField(const LensSampler& lens);
  DisparityCoefficients at(double x_px, double y_px) const;

 private:
  int columns_ = 1, rows_ = 1;
  double per_px_x_ = 0, per_px_y_ = 0;
  std::vector<DisparityCoefficients> nodes_;
};

}  // namespace dualpixel::simulator
