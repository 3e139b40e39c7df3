#include "evaluation/metrics/image_metrics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "capture/image/image_io.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kWindow = 11;
constexpr double kSigmaPx = 1.5;
constexpr float kC1 = 0.01f * 0.01f;
constexpr float kC2 = 0.03f * 0.03f;

std::array<float, kWindow> gaussian_window() {
  std::array<double, kWindow> exact;
  for (int i = 0; i < kWindow; ++i) exact[i] = std::exp(-0.5 * std::pow((i - kWindow / 2) / kSigmaPx, 2));
  const double sum = std::accumulate(exact.begin(), exact.end(), 0.0);
  std::array<float, kWindow> window;
  for (int i = 0; i < kWindow; ++i) window[i] = static_cast<float>(exact[i] / sum);
  return window;
}

/// Calls row(y) for each row, on all cores.
template <typename Row>
void for_each_row(int count, const Row& row) {
  tbb::parallel_for(0, count, row);
}

template <typename Value>
Image each_value(const Image& image, const Value& value) {
  Image out(image.width, image.height, image.channels);
  const int values = image.width * image.channels;
  for_each_row(image.height, [&](int y) { std::transform(image.row(y), image.row(y) + values, out.row(y), value); });
  return out;
}

Image luminance(const Image& image) {
  if (image.channels == 1) return image;
  Image out(image.width, image.height);
  for_each_row(image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      const float* rgb = &image.at(x, y);
      out.at(x, y) = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    }
  });
  return out;
}

/// Sum of the similarity over the windows centered on one row, of which `top` is the first row.
double ssim_of_row(const Image& a, const Image& b, int top, const std::array<float, kWindow>& window) {
  // The five moments of each column under the window, then of each whole window.
  enum { kA, kB, kAA, kBB, kAB, kMoments };
  const int columns = a.width - kWindow + 1;
  std::array<std::vector<float>, kMoments> column, whole;
  for (std::vector<float>& moment : column) moment.assign(a.width, 0);
  for (std::vector<float>& moment : whole) moment.assign(columns, 0);
  for (int k = 0; k < kWindow; ++k) {
    const float* row_a = a.row(top + k);
    const float* row_b = b.row(top + k);
    for (int x = 0; x < a.width; ++x) {
      const float wa = window[k] * row_a[x], wb = window[k] * row_b[x];
      column[kA][x] += wa;
      column[kB][x] += wb;
      column[kAA][x] += wa * row_a[x];
      column[kBB][x] += wb * row_b[x];
      column[kAB][x] += wa * row_b[x];
    }
  }
  for (int i = 0; i < kMoments; ++i) {
    const float* from = column[i].data();
    float* to = whole[i].data();
    for (int k = 0; k < kWindow; ++k) {
      for (int x = 0; x < columns; ++x) to[x] += window[k] * from[x + k];
    }
  }
  double sum = 0;
  for (int x = 0; x < columns; ++x) {
    const float mean_product = whole[kA][x] * whole[kB][x];
    const float mean_squares = whole[kA][x] * whole[kA][x] + whole[kB][x] * whole[kB][x];
    const float variances = whole[kAA][x] + whole[kBB][x] - mean_squares;
    const float covariance = whole[kAB][x] - mean_product;
    sum += (2 * mean_product + kC1) * (2 * covariance + kC2) / ((mean_squares + kC1) * (variances + kC2));
  }
  return sum;
}

}  // namespace

Image clipped(const Image& linear) {
  return each_value(linear, [](float v) { return v > 0 ? std::min(v, 1.0f) : 0.0f; });
}

Image displayed(const Image& linear, float gain) {
  return each_value(linear, [gain](float v) { return srgb_from_linear(v * gain); });
}

std::optional<double> psnr_db(const Image& a, const Image& b) {
  std::vector<double> row_sums(a.height);
  for_each_row(a.height, [&](int y) {
    const float* row_a = a.row(y);
    const float* row_b = b.row(y);
    for (int i = 0; i < a.width * a.channels; ++i) {
      const double difference = static_cast<double>(row_a[i]) - row_b[i];
      row_sums[y] += difference * difference;
    }
  });
  const double mean_square =
      std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / static_cast<double>(a.data.size());
  if (mean_square == 0) return std::nullopt;
  return -10 * std::log10(mean_square);
}

std::optional<double> ssim(const Image& a, const Image& b) {
  if (a.width < kWindow || a.height < kWindow) return std::nullopt;
  const Image luminance_a = luminance(a), luminance_b = luminance(b);
  const std::array<float, kWindow> window = gaussian_window();
  const int rows = a.height - kWindow + 1, columns = a.width - kWindow + 1;
  std::vector<double> row_sums(rows);
  for_each_row(rows, [&](int top) { row_sums[top] = ssim_of_row(luminance_a, luminance_b, top, window); });
  return std::accumulate(row_sums.begin(), row_sums.end(), 0.0) / (static_cast<double>(rows) * columns);
}

}  // namespace dualpixel::evaluation
