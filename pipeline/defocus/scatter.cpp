#include "pipeline/defocus/scatter.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "pipeline/burst/lanes.h"
#include "pipeline/defocus/rgba.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

constexpr float kSteps = 16;  // of a radius, a pixel
constexpr int kStripRows = 64;
constexpr float kLeastRadius = 0.5f;  ///< of gradients: a smaller disc lies within its pixel

int step_of(float radius_px) { return static_cast<int>(std::floor(radius_px * kSteps + 0.5f)); }

/// A row of a kernel: pairs of weights for neighbouring pixels, the first at `first` from the shape's middle.
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

int reach_of(const BlurShape& shape, float radius) {
  return static_cast<int>(std::ceil(shape.extent * radius + 0.5)) - 1;
}

/// Every pixel's weight.
Kernel antialiased(const BlurShape& shape, float radius) {
  const int reach = reach_of(shape, radius);
  const auto weight = [&](int dx, int dy) {
    return static_cast<float>(std::clamp(depth_inside(shape, radius, dx, dy) + 0.5, 0.0, 1.0));
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

/// A row of pixels of one weight that has the area, the middle and the spread along the row of what the shape has in a
/// row's height.
struct ShapeRow {
  double area = 0;
  double begin = 0;
  double end = 0;
};

ShapeRow shape_row(const BlurShape& shape, double radius, int y) {
  constexpr int kLines = 16;
  // lines at sines of even steps: chords fall like a root at a disc's top, and so evenly
  const double top = shape.extent * radius;
  const auto angle = [&](double at) { return std::asin(std::clamp(at / top, -1.0, 1.0)); };
  const double from = angle(y - 0.5), step = (angle(y + 0.5) - from) / kLines;
  double area = 0, first = 0, second = 0;  // moments over x
  for (int line = 0; line < kLines; ++line) {
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

/// Differences along x of the shape's weights, two pairs a row: where it begins and where it ends.
Kernel gradient(const BlurShape& shape, float radius) {
  radius = std::max(radius, kLeastRadius);
  Kernel kernel{reach_of(shape, radius), 2, {}};
  std::vector<ShapeRow> rows;
  double area = 0;
  for (int dy = -kernel.reach; dy <= kernel.reach; ++dy) {
    rows.push_back(shape_row(shape, radius, dy));
    area += rows.back().area;
  }
  for (const ShapeRow& row : rows) {
    // a step of the row's weight at `at`, spread over the two pixels whose running sums then have the row's share
    const auto step = [&](double at, float weight) {
      const double pixel = std::floor(at + 0.5);
      const auto later = static_cast<float>(at + 0.5 - pixel);
      return Pairs{static_cast<int>(pixel), weight * pair_of(1 - later, later)};
    };
    const double length = row.end - row.begin;
    const auto weight = length > 0 ? static_cast<float>(row.area / (length * area)) : 0;
    kernel.pairs.push_back(step(row.begin, weight));
    kernel.pairs.push_back(step(row.end, -weight));
  }
  return kernel;
}

using MakeKernel = Kernel (*)(const BlurShape&, float);

/// Kernels of the shapes and radii that a layer needs, made when they are first asked for. A cat's eye is of one shape
/// in each cell of the picture.
class Kernels {
 public:
  static constexpr int kCell = 64;  ///< pixels; over one, a rim moves by a fraction of a pixel

  Kernels(const Layer& layer, const Aperture& aperture, MakeKernel make)
      : layer_(layer), aperture_(aperture), make_(make) {
    if (aperture.cats_eye > 0) cell_px_ = kCell;
    columns_ = (layer.rgba.width + cell_px_ - 1) / cell_px_;
    const std::vector<float>& radii = layer.radius_px.data;
    steps_ = radii.empty() ? 1 : step_of(*std::max_element(radii.begin(), radii.end())) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * ((layer.rgba.height + cell_px_ - 1) / cell_px_));
  }

  int cell_px() const { return cell_px_; }
  int largest_reach() const {
    const float largest_px = std::max(static_cast<float>(steps_ - 1) / kSteps, kLeastRadius);
    return reach_of(blur_shape(aperture_, 0, 0, layer_.in_front_of_focus), largest_px);
  }

  const Kernel& operator()(int x, int y, float radius) {
    std::vector<Kernel>& cell = cells_[static_cast<std::size_t>(y / cell_px_) * columns_ + x / cell_px_];
    if (cell.empty()) cell.resize(steps_);
    Kernel& kernel = cell[step_of(radius)];
    if (kernel.pairs.empty()) kernel = make_(shape_at(x, y), static_cast<float>(step_of(radius)) / kSteps);
    return kernel;
  }

 private:
  BlurShape shape_at(int x, int y) const {
    const double half_width = 0.5 * layer_.rgba.width, half_height = 0.5 * layer_.rgba.height;
    const double corner = std::hypot(half_width, half_height);
    const auto field = [&](int at, double half) { return ((at / cell_px_ + 0.5) * cell_px_ - half) / corner; };
    return blur_shape(aperture_, field(x, half_width), field(y, half_height), layer_.in_front_of_focus);
  }

  const Layer& layer_;
  Aperture aperture_;
  MakeKernel make_;
  int cell_px_ = 1 << 30;
  int columns_ = 1;
  int steps_ = 1;
  std::vector<std::vector<Kernel>> cells_;
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

/// Premultiplied "over", in place on what lies behind.
void lay_over(Rgba front, float* behind) {
  const Rgba kept = front / std::max(front[3], 1.0f);
  store_rgba(kept + (1 - kept[3]) * load_rgba(behind), behind);
}

/// Scatters and hands each row of the result, with the margins that the strip has, to finish(strip row, margin, row
/// behind). Each strip takes from all source rows in order and adds to its own rows only, so every sum has the same
/// order however the strips are shared out.
template <typename Finish>
void scatter(const Layer& layer, const Aperture& aperture, MakeKernel make, Image& behind, const Finish& finish) {
  const int height = layer.rgba.height;
  tbb::enumerable_thread_specific<Strip> strips([&] { return make_strip(layer, aperture, make); });
  tbb::parallel_for(0, (height + kStripRows - 1) / kStripRows, [&](int s) {
    const int y0 = s * kStripRows, y1 = std::min(y0 + kStripRows, height);
    Strip& strip = strips.local();
    std::fill(strip.data.begin(), strip.data.end(), 0.0f);
    scatter_into(strip, layer, y0, y1);
    for (int y = y0; y < y1; ++y) finish(strip.row(y - y0), strip.margin, behind.row(y));
  });
}

constexpr float kTraces = 1e-5f;  // alpha that rounding may leave where no disc reaches

}  // namespace

void scatter_direct(const Layer& layer, Image& behind, const Aperture& aperture) {
  scatter(layer, aperture, antialiased, behind, [&](const float* from, int margin, float* to) {
    for (int x = 0; x < layer.rgba.width; ++x) {
      const Rgba blurred = load_rgba(from + 4 * (x + margin));
      if (blurred[3] > kTraces) lay_over(blurred, to + 4 * x);
    }
  });
}

void scatter_gradient(const Layer& layer, Image& behind, const Aperture& aperture) {
  scatter(layer, aperture, gradient, behind, [&](const float* from, int margin, float* to) {
    using Sum = double __attribute__((vector_size(32)));  // single precision would drift over a row
    Sum sum{};
    for (int x = -margin; x < layer.rgba.width; ++x) {
      sum += __builtin_convertvector(load_rgba(from + 4 * (x + margin)), Sum);
      if (x >= 0 && sum[3] > kTraces) lay_over(__builtin_convertvector(sum, Rgba), to + 4 * x);
    }
  });
}

}  // namespace dualpixel::pipeline
