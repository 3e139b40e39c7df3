#include "simulator/plan/match_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulator/sampling/mosaic.h"

namespace dualpixel::simulator {
namespace {

constexpr int kPixels = kWindowDpPx * kWindowDpPx;

std::vector<double> pixels_of(const Image& view, const MatchWindow& window) {
  std::vector<double> values;
  for (int y = window.y; y < window.y + kWindowDpPx; ++y) {
    for (int x = window.x; x < window.x + kWindowDpPx; ++x) values.push_back(view.at(x, y));
  }
  return values;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void subtract_mean(std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  for (double& value : values) value -= sum / static_cast<double>(values.size());
}

/// dB/dx in a window, less its projections on 1 and B. `step`: to the neighbors of the same color.
std::vector<double> texture(const Image& view, const MatchWindow& window, int step) {
  std::vector<double> g;
  for (int y = window.y; y < window.y + kWindowDpPx; ++y) {
    for (int x = window.x; x < window.x + kWindowDpPx; ++x) {
      g.push_back((view.at(x + step, y) - view.at(x - step, y)) / (2.0 * step));
    }
  }
  std::vector<double> b = pixels_of(view, window);
  subtract_mean(g);
  subtract_mean(b);
  const double square = dot(b, b);
  const double share = square > 0 ? dot(g, b) / square : 0;
  for (int i = 0; i < kPixels; ++i) g[i] -= share * b[i];
  return g;
}

/// The weights of one view from its two renders; returns the variance of the shift under the sensor's noise, infinite
/// without texture.
double fit_weights(const Image& first, const Image& second, const MatchWindow& window, int step,
                   const NoiseProfile& noise, int frames, std::vector<float>& weights) {
  const std::vector<double> g1 = texture(first, window, step), g2 = texture(second, window, step);
  const double energy = dot(g1, g2);
  if (!(energy > 0)) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < kPixels; ++i) weights.push_back(static_cast<float>(-0.5 * (g1[i] + g2[i]) / energy));
  double light = 0;
  for (double value : pixels_of(first, window)) light += value / kPixels;
  return (noise.shot_dn * light + noise.read_dn2) / frames / energy;
}

double weighted_sum(const Image& view, const MatchWindow& window, const std::vector<float>& weights) {
  double sum = 0;
  for (int y = 0; y < kWindowDpPx; ++y) {
    for (int x = 0; x < kWindowDpPx; ++x) {
      sum += static_cast<double>(weights[y * kWindowDpPx + x]) * view.at(window.x + x, window.y + y);
    }
  }
  return sum;
}

double covariance(const DpViews& a, const DpViews& b, const MatchWindow& window) {
  double sum = 0;
  for (const Image DpViews::*view : {&DpViews::left, &DpViews::right}) {
    std::vector<double> first = pixels_of(a.*view, window);
    subtract_mean(first);
    sum += dot(first, pixels_of(b.*view, window));
  }
  return sum;
}

}  // namespace

int color_period(const SensorOptions& sensor) { return sensor.dp_downsample_x * sensor.dp_downsample_y == 1 ? 2 : 1; }

DpViews expected_dp_views(const Views& views, const SensorOptions& sensor, const ExposureOptions& exposure,
                          double lux_per_nit) {
  const Image electrons = expected_electrons(views.left, views.right, sensor, exposure, lux_per_nit);
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const double white = std::exp2(sensor.bits) - 1 - sensor.black_level_dn;
  const int dp_x = sensor.dp_downsample_x, dp_y = sensor.dp_downsample_y;
  const bool dense = dp_x * dp_y == 1;  // a DP pixel is a photosite of any color, otherwise the mean of its green ones
  const double share = gain / (dense ? 1 : dp_x * dp_y / 2);
  DpViews dp;
  dp.color_period = color_period(sensor);
  dp.left = dp.right = Image(electrons.width / dp_x, electrons.height / dp_y);
  for (int y = 0; y < electrons.height; ++y) {
    for (int x = 0; x < electrons.width; ++x) {
      if (!dense && cfa_color(x, y) != 1) continue;
      double left = electrons.at(x, y, 0), right = electrons.at(x, y, 1);
      fill_wells(sensor, left, right);
      dp.left.at(x / dp_x, y / dp_y) += static_cast<float>(share * left);
      dp.right.at(x / dp_x, y / dp_y) += static_cast<float>(share * right);
    }
  }
  for (Image* view : {&dp.left, &dp.right}) {
    for (float& value : view->data) value = static_cast<float>(std::min<double>(value, white));
  }
  return dp;
}

double MatchWindow::shift_dp_px(const DpViews& views) const {
  return weighted_sum(views.right, *this, right_weight) - weighted_sum(views.left, *this, left_weight);
}

double MatchWindow::correlation(const DpViews& a1, const DpViews& a2, const DpViews& b1, const DpViews& b2) const {
  const double between = 0.5 * (covariance(a1, b2, *this) + covariance(a2, b1, *this));
  const double within = covariance(a1, a2, *this) * covariance(b1, b2, *this);
  return within > 0 ? between / std::sqrt(within) : 0;
}

MatchWindows match_windows(const DpViews& first, const DpViews& second, const Exposure& exposure, int frames,
                           double most_sensor_noise_dp_px, int offset_x, int offset_y) {
  MatchWindows windows;
  const int step = first.color_period;
  const NoiseProfile& noise = exposure.dp_noise;
  for (int y = offset_y; y + kWindowDpPx <= first.left.height; y += kWindowDpPx) {
    for (int x = step + offset_x; x + kWindowDpPx + step <= first.left.width; x += kWindowDpPx) {
      MatchWindow window{x, y, {}, {}, 0};
      const double left = fit_weights(first.left, second.left, window, step, noise, frames, window.left_weight);
      const double right = fit_weights(first.right, second.right, window, step, noise, frames, window.right_weight);
      window.sensor_noise_dp_px = std::sqrt(left + right);
      ++windows.total;
      if (window.sensor_noise_dp_px <= most_sensor_noise_dp_px) windows.textured.push_back(std::move(window));
    }
  }
  return windows;
}

}  // namespace dualpixel::simulator
