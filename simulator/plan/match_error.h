#pragma once
#include <vector>

#include "capture/capture.h"
#include "simulator/render/views.h"
#include "simulator/sensor/sensor.h"

/// How far a small change of the two views moves the disparity that a least-squares matcher finds.
///
/// A matcher shifts a window of the left view over the right one until the sum of squared differences, after gain and
/// offset were fitted, is least. Linearized about the reference picture B (Lucas & Kanade 1981), a view that becomes A
/// looks as if it had moved by
///     delta(A) = - sum (A - B) g / sum g^2,        g = dB/dx less its projections on 1 and B,
/// over the window, so that neither gain nor offset counts; the disparity moves by delta of the right view minus delta
/// of the left one. g is orthogonal to B: delta is a sum over A with fixed weights, and two pictures' disparities
/// differ by the difference of their sums, whatever noise or bias made it.
namespace dualpixel::simulator {

/// DP views without noise: digital numbers above black, as the sensor bins and clips the light.
struct DpViews {
  Image left, right;
  int color_period = 1;  ///< pixels from one to the next of the same color
};

/// 2 where DP pixels have the mosaic's pattern (1 x 1), otherwise 1.
int color_period(const SensorOptions& sensor);

/// `views` of a whole sensor, or of a part of it that begins at a DP pixel and at an even photosite.
DpViews expected_dp_views(const Views& views, const SensorOptions& sensor, const ExposureOptions& exposure,
                          double lux_per_nit);

inline constexpr int kWindowDpPx = 16;  ///< a side

struct MatchWindow {
  int x = 0, y = 0;                              ///< upper left corner, DP pixels
  std::vector<float> left_weight, right_weight;  ///< row by row
  double sensor_noise_dp_px = 0;                 ///< Cramer-Rao bound of the disparity under shot and read noise

  /// Disparity less that of the reference.
  double shift_dp_px(const DpViews& views) const;
  /// Of the pictures of two sources in this window, both views together, each rendered twice with independent noise,
  /// which cancels: 1 where a and b show the same but for gain and offset, 0 where one shows nothing.
  double correlation(const DpViews& a1, const DpViews& a2, const DpViews& b1, const DpViews& b2) const;
};

struct MatchWindows {
  std::vector<MatchWindow> textured;
  int total = 0;
};

/// The windows that fit into the picture, side by side from column offset_x on, after the neighbor of the same color
/// that dB/dx needs, and from row offset_y on. The reference is the mean of two renders with independent noise, so that
/// noise is not taken for texture. A window says something of its disparity where the sensor's noise, that of `frames`
/// frames merged, blurs it by no more than `most_sensor_noise_dp_px`.
MatchWindows match_windows(const DpViews& first, const DpViews& second, const Exposure& exposure, int frames,
                           double most_sensor_noise_dp_px, int offset_x = 0, int offset_y = 0);

}  // namespace dualpixel::simulator
