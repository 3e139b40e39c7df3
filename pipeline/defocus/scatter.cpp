#include "pipeline/defocus/scatter.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "capture/image/rows.h"
#include "capture/lanes.h"
#include "pipeline/defocus/rgba.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kStepsPerPx = 16;  // of a radius, a pixel
constexpr int kStripRows = 64;
constexpr float kLeastRadius = 0.5f;  ///< of gradients: a smaller disc lies within its pixel

int step_of(float radius_px) { return static_cast<int>(std::floor(radius_px * kStepsPerPx + 0.5f)); }

/// A row of a kernel: pairs of weights for neighboring pixels, the first at `first` from the shape's middle.
struct Pairs {
  int first = 0;
  Lanes weights{};  ///< the left pixel's four times, then the right one's
};

/// The weights that one pixel adds to the rows -reach ... reach around it, `row_pairs` pairs to each row.
struct Kernel {
  int reach = 0;
  int row_pairs = 0;
  std::vector<Pairs> pairs;
};

Lanes pair_of(float left, float right) { return Lanes{left, left, left, left, right, right, right, right}; }

int reach_of(const BlurShape& shape, float radius) {
  return static_cast<int>(std::ceil(shape.extent * radius + 0.5)) - 1;
}

/// The kernel with every pixel's weight, for scatter_direct().
void antialiased(const BlurShape& shape, float radius, int, Kernel& kernel) {
  const int reach = reach_of(shape, radius);
  const auto weight = [&](int dx, int dy) {
    return static_cast<float>(std::clamp(depth_inside(shape, radius, dx, dy) + 0.5, 0.0, 1.0));
  };
  double total = 0;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) total += weight(dx, dy);
  }
  const auto scale = static_cast<float>(1 / total);
  kernel.reach = reach;
  kernel.row_pairs = reach + 1;
  kernel.pairs.clear();
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; dx += 2) {
      const float right = dx < reach ? weight(dx + 1, dy) : 0;
      kernel.pairs.push_back({dx, scale * pair_of(weight(dx, dy), right)});
    }
  }
}

/// One row of a kernel: from `begin` to `end`, with constant weight. It has the area, the center of mass and the spread
/// along x of the part of the ideal shape that lies in the row's height.
struct ShapeRow {
  double area = 0;
  double begin = 0;
  double end = 0;
};

ShapeRow shape_row(const BlurShape& shape, double radius, int y, int lines) {
  // Lines lie at the sines of even steps: a disc's chords fall like a square root at its top, so its samples are denser
  // there.
  const double top = shape.extent * radius;
  const auto angle = [&](double at) { return std::asin(std::clamp(at / top, -1.0, 1.0)); };
  const double from = angle(y - 0.5), step = (angle(y + 0.5) - from) / lines;
  double area = 0, first = 0, second = 0;  // moments over x
  for (int line = 0; line < lines; ++line) {
    const double u = from + (line + 0.5) * step;
    const auto [begin, end] = chord(shape, radius, top * std::sin(u));
    if (end <= begin) continue;
    const double height = top * std::cos(u) * step;
    area += (end - begin) * height;
    first += (end * end - begin * begin) / 2 * height;
    second += (end * end * end - begin * begin * begin) / 3 * height;
  }
  if (!(area > 0)) return {};
  const double middle = first / area;
  const double half = std::sqrt(3 * std::max(second / area - middle * middle, 0.0));
  return {area, middle - half, middle + half};
}

/// The kernel's differences along x, two pairs a row (where it begins and where it ends), for scatter_gradient().
void gradient(const BlurShape& shape, float radius, int lines, Kernel& kernel) {
  radius = std::max(radius, kLeastRadius);
  kernel.reach = reach_of(shape, radius);
  kernel.row_pairs = 2;
  kernel.pairs.clear();
  // A step of a row's weight at `at`, split over two pixels so that their running sums have the row's coverage.
  const auto step = [](double at, float weight) {
    const double pixel = std::floor(at + 0.5);
    const auto later = static_cast<float>(at + 0.5 - pixel);
    return Pairs{static_cast<int>(pixel), weight * pair_of(1 - later, later)};
  };
  double area = 0;
  for (int dy = -kernel.reach; dy <= kernel.reach; ++dy) {
    const ShapeRow row = shape_row(shape, radius, dy, lines);
    const double length = row.end - row.begin;
    const float weight = length > 0 ? static_cast<float>(row.area / length) : 0;
    kernel.pairs.push_back(step(row.begin, weight));
    kernel.pairs.push_back(step(row.end, -weight));
    area += row.area;
  }
  if (!(area > 0)) {  // a cat's eye so narrow that it lies between the lines: within its pixel
    kernel.pairs[2 * kernel.reach] = step(-0.5, 1);
    kernel.pairs[2 * kernel.reach + 1] = step(0.5, -1);
    return;
  }
  const auto scale = static_cast<float>(1 / area);
  for (Pairs& pair : kernel.pairs) pair.weights *= scale;
}

/// Makes the kernel of a radius; each row is integrated over `lines` lines.
using MakeKernel = void (*)(const BlurShape&, float radius, int lines, Kernel&);

/// The kernels of a layer, by radius and field position. They are cached where the shape is the same over the field. A
/// cat's eye changes from pixel to pixel and is computed for each, from fewer lines.
class Kernels {
 public:
  Kernels(const Layer& layer, const Aperture& aperture, MakeKernel make)
      : aperture_(aperture),
        make_(make),
        shape_(blur_shape(aperture, layer.in_front_of_focus)),
        half_width_(0.5 * layer.rgba.width),
        half_height_(0.5 * layer.rgba.height),
        per_corner_(1 / std::max(std::hypot(half_width_, half_height_), 1.0)) {
    const std::vector<float>& radii = layer.radius_px.data;
    const float largest = radii.empty() ? 0 : *std::max_element(radii.begin(), radii.end());
    largest_reach_ = reach_of(shape_, std::max(largest + 1 / kStepsPerPx, kLeastRadius));
    kept_.resize(aperture.cats_eye > 0 ? 1 : step_of(largest) + 1);
  }

  int largest_reach() const { return largest_reach_; }

  const Kernel& operator()(int x, int y, float radius) {
    const int step = step_of(radius);
    const float rounded = static_cast<float>(step) / kStepsPerPx;
    if (aperture_.cats_eye > 0) {
      cut_to_cats_eye(shape_, aperture_, (x + 0.5 - half_width_) * per_corner_, (y + 0.5 - half_height_) * per_corner_);
      make_(shape_, rounded, 2, kept_[0]);
      return kept_[0];
    }
    if (kept_[step].pairs.empty()) make_(shape_, rounded, 16, kept_[step]);
    return kept_[step];
  }

 private:
  Aperture aperture_;
  MakeKernel make_;
  BlurShape shape_;
  double half_width_, half_height_, per_corner_;
  int largest_reach_ = 0;
  std::vector<Kernel> kept_;
};

/// Rows of a strip of the result while it is being scattered, with room for discs to both sides.
struct Strip {
  Kernels kernels;
  int margin = 0;      ///< pixels to the left
  std::size_t stride;  ///< floats
  std::vector<float> data;

  float* row(int y) { return data.data() + static_cast<std::size_t>(y) * stride; }
};

Strip make_strip(const Layer& layer, const Aperture& aperture, MakeKernel make) {
  Strip strip{Kernels(layer, aperture, make), 0, 0, {}};
  strip.margin = strip.kernels.largest_reach() + 1;
  // An odd number of cache lines, so that a disc's rows don't compete for the same ones.
  strip.stride = static_cast<std::size_t>((4 * (layer.rgba.width + 2 * strip.margin + 1) + 15) / 16 | 1) * 16;
  strip.data.resize(kStripRows * strip.stride);
  return strip;
}

/// Adds what the layer's pixels scatter into rows y0 ... y1 - 1.
void scatter_into(Strip& strip, const Layer& layer, int y0, int y1) {
  const int width = layer.rgba.width, reach = strip.margin - 1;
  for (int y = std::max(y0 - reach, 0); y < std::min(y1 + reach, layer.rgba.height); ++y) {
    for (int x = 0; x < width; ++x) {
      const float* rgba = layer.rgba.row(y) + 4 * x;
      if (rgba[3] == 0) continue;
      const Lanes color = {rgba[0], rgba[1], rgba[2], rgba[3], rgba[0], rgba[1], rgba[2], rgba[3]};
      const Kernel& kernel = strip.kernels(x, y, layer.radius_px.row(y)[x]);
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

/// In place on what lies in front. Piled-up discs count as one that is opaque.
void lay_behind(float* front, const Rgba& blurred) {
  store_rgba(lay_over(load_rgba(front), blurred / std::max(blurred[3], 1.0f)), front);
}

/// Scatters and hands each row of the result, with the margins that the strip has, to finish(strip row, margin, row of
/// `front`). Each strip takes from all source rows in order and adds to its own rows only, so every sum has the same
/// order however the strips are shared out.
template <typename Finish>
void scatter(const Layer& layer, const Aperture& aperture, MakeKernel make, Image& front, const Finish& finish) {
  const int height = layer.rgba.height;
  tbb::enumerable_thread_specific<Strip> strips([&] { return make_strip(layer, aperture, make); });
  tbb::parallel_for(0, (height + kStripRows - 1) / kStripRows, [&](int s) {
    const int y0 = s * kStripRows, y1 = std::min(y0 + kStripRows, height);
    Strip& strip = strips.local();
    std::fill(strip.data.begin(), strip.data.end(), 0.0f);
    scatter_into(strip, layer, y0, y1);
    for (int y = y0; y < y1; ++y) finish(strip.row(y - y0), strip.margin, front.row(y));
  });
}

constexpr float kTraces = 1e-5f;  // alpha that rounding may leave where no disc reaches

}  // namespace

void scatter_direct(const Layer& layer, Image& front, const Aperture& aperture) {
  scatter(layer, aperture, antialiased, front, [&](const float* from, int margin, float* to) {
    for (int x = 0; x < layer.rgba.width; ++x) {
      const Rgba blurred = load_rgba(from + 4 * (x + margin));
      if (blurred[3] > kTraces) lay_behind(to + 4 * x, blurred);
    }
  });
}

void scatter_gradient(const Layer& layer, Image& front, const Aperture& aperture) {
  scatter(layer, aperture, gradient, front, [&](const float* from, int margin, float* to) {
    using Sum = double __attribute__((vector_size(32)));  // single precision would drift over a row
    Sum sum{};
    for (int x = -margin; x < layer.rgba.width; ++x) {
      sum += __builtin_convertvector(load_rgba(from + 4 * (x + margin)), Sum);
      if (x >= 0 && sum[3] > kTraces) lay_behind(to + 4 * x, __builtin_convertvector(sum, Rgba));
    }
  });
}

}  // namespace dualpixel::pipeline
