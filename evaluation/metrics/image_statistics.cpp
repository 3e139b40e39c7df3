#include "evaluation/metrics/image_statistics.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

namespace dualpixel::evaluation {
namespace {

using Spectrum = Eigen::MatrixXcf;

/// Rows of the discrete Fourier transform of n points.
Eigen::MatrixXcf fourier_matrix(int n) {
  Eigen::MatrixXcf matrix(n, n);
  for (int k = 0; k < n; ++k) {
    for (int x = 0; x < n; ++x)
      matrix(k, x) = std::complex<float>(std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k * x % n) / n));
  }
  return matrix;
}

/// Of the centered square of `side` pixels, mean taken off, under a Hann window that hides that its ends do not meet.
Spectrum windowed_spectrum(const Image& picture, const Eigen::MatrixXcf& fourier) {
  const int side = static_cast<int>(fourier.rows());
  const int left = (picture.width - side) / 2, top = (picture.height - side) / 2;
  const auto window = [&](int i) { return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 0.5) / side); };
  double mean = 0, weights = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      mean += window(x) * window(y) * picture.at(left + x, top + y);
      weights += window(x) * window(y);
    }
  }
  Eigen::MatrixXcf square(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x)
      square(y, x) = static_cast<float>(window(x) * window(y) * (picture.at(left + x, top + y) - mean / weights));
  }
  return fourier * square * fourier.transpose();
}

/// Mean of the products of two spectra over rings of frequency.
std::vector<double> ring_power(const Spectrum& a, const Spectrum& b) {
  const int n = static_cast<int>(a.rows());
  std::vector<double> power(static_cast<std::size_t>(n) / 2), count(power.size());
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const auto ring = static_cast<std::size_t>(std::lround(std::hypot(std::min(x, n - x), std::min(y, n - y))));
      if (ring >= power.size()) continue;
      power[ring] += std::real(std::conj(a(y, x)) * b(y, x));
      ++count[ring];
    }
  }
  for (std::size_t i = 0; i < power.size(); ++i) power[i] /= std::max(count[i], 1.0);
  return power;
}

}  // namespace

double amplitude_slope(const NoisyPictures& pictures) {
  const int side = std::min(pictures[0].width, pictures[0].height);
  const Eigen::MatrixXcf fourier = fourier_matrix(side);
  Spectrum halves[2];  // of sums of two, which are as independent as the four are
  for (int i = 0; i < 2; ++i)
    halves[i] = windowed_spectrum(pictures[2 * i], fourier) + windowed_spectrum(pictures[2 * i + 1], fourier);
  const std::vector<double> power = ring_power(halves[0], halves[1]);
  double sw = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int f = 4; f <= side / 4; ++f) {
    const double p = power[static_cast<std::size_t>(f)];
    if (!(p > 0)) continue;  // noise and nothing else
    const double w = 1.0 / f, x = std::log(f), y = 0.5 * std::log(p);
    sw += w, sx += w * x, sy += w * y, sxx += w * x * x, sxy += w * x * y;
  }
  const double spread = sw * sxx - sx * sx;
  return spread > 0 ? (sw * sxy - sx * sy) / spread : std::numeric_limits<double>::quiet_NaN();
}

double GradientMoments::deviation() const { return std::sqrt(std::max(square, 0.0)); }
double GradientMoments::kurtosis() const {
  return square > 0 ? fourth / (square * square) : std::numeric_limits<double>::quiet_NaN();
}

GradientMoments gradient_moments(const NoisyPictures& pictures) {
  GradientMoments sums;
  const int width = pictures[0].width, height = pictures[0].height;
  double count = 0;
  const auto add = [&](int x, int y, int dx, int dy) {
    double g[4];
    for (int i = 0; i < 4; ++i) g[i] = pictures[i].at(x + dx, y + dy) - pictures[i].at(x, y);
    // the mean of the six products of two, and the one of four
    const double sum = g[0] + g[1] + g[2] + g[3];
    sums.square += (sum * sum - g[0] * g[0] - g[1] * g[1] - g[2] * g[2] - g[3] * g[3]) / 12;
    sums.fourth += g[0] * g[1] * g[2] * g[3];
    ++count;
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width) add(x, y, 1, 0);
      if (y + 1 < height) add(x, y, 0, 1);
    }
  }
  return {sums.square / count, sums.fourth / count};
}

std::array<double, 5> quantiles(std::vector<double> values) {
  std::array<double, 5> found{};
  if (values.empty()) return found;
  std::sort(values.begin(), values.end());
  constexpr double kShares[] = {0.05, 0.25, 0.5, 0.75, 0.95};
  for (std::size_t i = 0; i < 5; ++i)
    found[i] = values[static_cast<std::size_t>(std::lround(kShares[i] * static_cast<double>(values.size() - 1)))];
  return found;
}

}  // namespace dualpixel::evaluation
