#include "pipeline/defocus/scatter.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "pipeline/burst/lanes.h"
#include "pipeline/defocus/rgba.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kSteps = 16;  // of a radius, a pixel
constexpr int kStripRows = 64;

int step_of(float radius_px) { return static_cast<int>(std::floor(radius_px * kSteps + 0.5f)); }

/// A row of a kernel: pairs of weights for neighbouring pixels, the first at `first` from the disc's middle.
struct Pairs {
  int first = 0;
  Lanes weights{};  ///< the left pixel's four times, then the right one's
};

/// What one pixel adds to the rows -reach ... reach around it: `row_pairs` pairs to each.
struct Kernel {
  int reach = 0;
  int row_pairs = 0;
  std::vector<Pairs> pairs;
};

Lanes pair_of(float left, float right) { return Lanes{left, left, left, left, right, right, right, right}; }

/// Every pixel's weight.
Kernel antialiased_disc(float radius) {
  const int reach = static_cast<int>(std::ceil(radius + 0.5f)) - 1;
  const auto weight = [&](int dx, int dy) {
    return std::clamp(radius + 0.5f - std::sqrt(static_cast<float>(dx * dx + dy * dy)), 0.0f, 1.0f);
  };
  double total = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) total += weight(dx, dy);
  }
  const auto scale = static_cast<float>(1 / total);
  Kernel kernel{reach, reach + 1, {}};
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; dx += 2) {
      const float right = dx < reach ? weight(dx + 1, dy) : 0;
      kernel.pairs.push_back({dx, scale * pair_of(weight(dx, dy), right)});
    }
  }
  return kernel;
}

/// A row of pixels of one weight that has the area and the spread along the row that a disc has in a row's height.
struct DiscRow {
  double half_length = 0;
  double weight = 0;
};

DiscRow disc_row(double radius, int y) {
  // integrals over t of the half chord h = sqrt(r^2 - t^2) and of h^3, of which a row of length 2 l and weight w has
  // w l and w l^3
  const auto integrals = [&](double at) {
    const double t = std::clamp(at, -radius, radius), rr = radius * radius;
    const double h = std::sqrt(rr - t * t), angle = std::asin(t / radius);
    return std::array{0.5 * (t * h + rr * angle), 0.125 * (t * h * (5 * rr - 2 * t * t) + 3 * rr * rr * angle)};
  };
  const auto [first_end, third_end] = integrals(y + 0.5);
  const auto [first_begin, third_begin] = integrals(y - 0.5);
  const double first = first_end - first_begin, third = third_end - third_begin;
  if (!(first > 0 && third > 0)) return {};
  return {std::sqrt(third / first), first * std::sqrt(first / third)};
}

/// Differences along x of a disc's weights, two pairs a row: where it begins and where it ends.
Kernel disc_gradient(float radius) {
  Kernel kernel{static_cast<int>(std::ceil(radius + 0.5f)) - 1, 2, {}};
  const double r = std::max(radius, 0.5f);  // a smaller disc lies within its pixel
  const double area = std::numbers::pi * r * r;
  for (int dy = -kernel.reach; dy <= kernel.reach; ++dy) {
    const DiscRow row = disc_row(r, dy);
    const int rim = static_cast<int>(std::floor(row.half_length + 0.5));  // the pixel that the row ends in
    const auto covered = static_cast<float>(row.half_length + 0.5 - rim);
    const auto scale = static_cast<float>(row.weight / area);
    kernel.pairs.push_back({-rim, scale * pair_of(covered, 1 - covered)});
    kernel.pairs.push_back({rim, scale * pair_of(covered - 1, -covered)});
  }
  return kernel;
}

/// Kernels for radii from 0 to the layer's largest, in steps.
template <typename Make>
std::vector<Kernel> make_kernels(const Layer& layer, const Make& make) {
  const std::vector<float>& radii = layer.radius_px.data;
  const float largest = radii.empty() ? 0 : *std::max_element(radii.begin(), radii.end());
  std::vector<Kernel> kernels;
  for (int step = 0; step <= step_of(largest); ++step) kernels.push_back(make(static_cast<float>(step) / kSteps));
  return kernels;
}

/// Rows of a strip of the result while it is being scattered, with room for discs to both sides.
struct Strip {
  int margin = 0;      ///< pixels to the left
  std::size_t stride;  ///< floats
  std::vector<float> data;

  float* row(int y) { return data.data() + static_cast<std::size_t>(y) * stride; }
};

Strip make_strip(int width, int reach) {
  Strip strip;
  strip.margin = reach + 1;
  // An odd number of cache lines, so that a disc's rows don't compete for the same ones.
  strip.stride = static_cast<std::size_t>((4 * (width + 2 * strip.margin + 1) + 15) / 16 | 1) * 16;
  strip.data.resize(kStripRows * strip.stride);
  return strip;
}

/// Adds what the layer's pixels scatter into rows y0 ... y1 - 1.
void scatter_into(Strip& strip, const Layer& layer, const std::vector<Kernel>& kernels, int y0, int y1) {
  const int width = layer.rgba.width, reach = kernels.back().reach;
  for (int y = std::max(y0 - reach, 0); y < std::min(y1 + reach, layer.rgba.height); ++y) {
    for (int x = 0; x < width; ++x) {
      const float* rgba = layer.rgba.row(y) + 4 * x;
      if (rgba[3] == 0) continue;
      const Lanes color = {rgba[0], rgba[1], rgba[2], rgba[3], rgba[0], rgba[1], rgba[2], rgba[3]};
      const Kernel& kernel = kernels[step_of(layer.radius_px.row(y)[x])];
      const int top = std::max(y - kernel.reach, y0), bottom = std::min(y + kernel.reach, y1 - 1);
      const Pairs* pairs = kernel.pairs.data() + (top - y + kernel.reach) * kernel.row_pairs;
      for (int v = top; v <= bottom; ++v) {
        float* row = strip.row(v - y0) + 4 * (x + strip.margin);
        for (int k = 0; k < kernel.row_pairs; ++k, ++pairs) {
          float* to = row + 4 * pairs->first;
          const Lanes sum = load_lanes(to) + pairs->weights * color;
          std::memcpy(to, &sum, sizeof(sum));
        }
      }
    }
  }
}

/// Premultiplied "over", in place on what lies behind.
void lay_over(Rgba front, float* behind) {
  const Rgba kept = front / std::max(front[3], 1.0f);
  store_rgba(kept + (1 - kept[3]) * load_rgba(behind), behind);
}

/// Scatters with `kernels` and hands each row of the result, with the margins that the strip has, to
/// finish(strip row, margin, row behind). Each strip takes from all source rows in order and adds to its own rows only,
/// so every sum has the same order however the strips are shared out.
template <typename Finish>
void scatter(const Layer& layer, const std::vector<Kernel>& kernels, Image& behind, const Finish& finish) {
  const int height = layer.rgba.height;
  tbb::enumerable_thread_specific<Strip> strips([&] { return make_strip(layer.rgba.width, kernels.back().reach); });
  tbb::parallel_for(0, (height + kStripRows - 1) / kStripRows, [&](int s) {
    const int y0 = s * kStripRows, y1 = std::min(y0 + kStripRows, height);
    Strip& strip = strips.local();
    std::fill(strip.data.begin(), strip.data.end(), 0.0f);
    scatter_into(strip, layer, kernels, y0, y1);
    for (int y = y0; y < y1; ++y) finish(strip.row(y - y0), strip.margin, behind.row(y));
  });
}

constexpr float kTraces = 1e-5f;  // alpha that rounding may leave where no disc reaches

}  // namespace

void scatter_direct(const Layer& layer, Image& behind) {
  scatter(layer, make_kernels(layer, antialiased_disc), behind, [&](const float* from, int margin, float* to) {
    for (int x = 0; x < layer.rgba.width; ++x) {
      const Rgba blurred = load_rgba(from + 4 * (x + margin));
      if (blurred[3] > kTraces) lay_over(blurred, to + 4 * x);
    }
  });
}

void scatter_gradient(const Layer& layer, Image& behind) {
  scatter(layer, make_kernels(layer, disc_gradient), behind, [&](const float* from, int margin, float* to) {
    using Sum = double __attribute__((vector_size(32)));  // single precision would drift over a row
    Sum sum{};
    for (int x = -margin; x < layer.rgba.width; ++x) {
      sum += __builtin_convertvector(load_rgba(from + 4 * (x + margin)), Sum);
      if (x >= 0 && sum[3] > kTraces) lay_over(__builtin_convertvector(sum, Rgba), to + 4 * x);
    }
  });
}

}  // namespace dualpixel::pipeline
