#include "pipeline/edge_aware/bilateral_solver.h"

#include <fmt/format.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

#include "capture/error.h"
#include "capture/image/resample.h"
#include "capture/image/rows.h"

namespace dualpixel::pipeline {
namespace {

/// One value for each vertex and, at the end, the 0 of a missing neighbor.
using Vertices = std::vector<double>;

constexpr float kUnknownVariance = std::numeric_limits<float>::infinity();
constexpr int kGrain = 4096;  // part of the result: sums are taken in chunks of this size

template <typename F>
void for_vertices(const BilateralGrid& grid, const F& f) {
  tbb::parallel_for(tbb::blocked_range<int>(0, grid.vertices, kGrain), [&](const tbb::blocked_range<int>& range) {
    for (int v = range.begin(); v < range.end(); ++v) f(v);
  });
}

/// Sum of f(vertex), which may write to its own vertex.
template <typename F>
double sum_over_vertices(const BilateralGrid& grid, const F& f) {
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<int>(0, grid.vertices, kGrain), 0.0,
      [&](const tbb::blocked_range<int>& range, double sum) {
        for (int v = range.begin(); v < range.end(); ++v) sum += f(v);
        return sum;
      },
      std::plus<>());
}

/// Calls f(pixel, vertex) for all pixels; those of a vertex come in one order, and no two at once.
template <typename F>
void for_pixels(const BilateralGrid& grid, const F& f) {
  tbb::parallel_for(0, grid.rows(), [&](int line) {
    const std::size_t begin = static_cast<std::size_t>(grid.row_begins[line]) * grid.width;
    const std::size_t end = static_cast<std::size_t>(grid.row_begins[line + 1]) * grid.width;
    for (std::size_t i = begin; i < end; ++i) f(i, grid.vertex_of_pixel[i]);
  });
}

template <typename Values>
double sum_of_neighbors(const BilateralGrid& grid, const Values& values, int vertex) {
  const std::int32_t* neighbors = grid.neighbors.data() + static_cast<std::size_t>(vertex) * BilateralGrid::kNeighbors;
  double sum = 0;
  for (int k = 0; k < BilateralGrid::kNeighbors; ++k) sum += values[neighbors[k]];
  return sum;
}

Vertices make_vertices(const BilateralGrid& grid) { return Vertices(static_cast<std::size_t>(grid.vertices) + 1); }

/// The diagonal n for which Dn B Dn has about as much in each row as the vertex has pixels. B has twice the number of
/// axes on its diagonal, 1 for each neighbor.
Vertices bistochastize(const BilateralGrid& grid, int iterations) {
  Vertices pixels = make_vertices(grid), n = pixels, next = pixels;
  for_pixels(grid, [&](std::size_t, std::int32_t v) { pixels[v] += 1; });
  std::fill(n.begin(), n.end() - 1, 1.0);
  for (int i = 0; i < iterations; ++i) {
    for_vertices(grid, [&](int v) {
      next[v] = std::sqrt(n[v] * pixels[v] / (BilateralGrid::kNeighbors * n[v] + sum_of_neighbors(grid, n, v)));
    });
    std::swap(n, next);
  }
  return n;
}

/// With s = sqrt(lambda) n and u = s y, rows of Eq. 4 divided by s read
///     diagonal_i u_i - sum over the neighbors of u_j = right_i,
/// since Dm - Dn B Dn leaves on the diagonal what a row has elsewhere. Jacobi preconditioning does not depend on s.
struct System {
  const BilateralGrid& grid;
  Vertices s;
  Vertices weight;  ///< of the vertices: sums of confidence
  Vertices diagonal;

  Vertices inverse_diagonal;  ///< 0 where the diagonal is: a vertex alone, without confidence, stays as it is

  template <typename Values>
  double apply(const Values& u, int v) const {
    return diagonal[v] * u[v] - sum_of_neighbors(grid, u, v);
  }
};

void set_weights(System& system, const Image& confidence) {
  std::fill(system.weight.begin(), system.weight.end(), 0.0);
  for_pixels(system.grid, [&](std::size_t i, std::int32_t v) { system.weight[v] += confidence.data[i]; });
  for_vertices(system.grid, [&](int v) {
    const double s = system.s[v];
    const double diagonal = sum_of_neighbors(system.grid, system.s, v) / s + system.weight[v] / (s * s);
    system.diagonal[v] = diagonal;
    system.inverse_diagonal[v] = diagonal > 0 ? 1 / diagonal : 0;
  });
}

/// Scratch memory of the solver. Search directions are in single precision, so that more of them fit the cache. That
/// adds no error: the residual is updated with the rounded directions.
struct Iterates {
  Vertices residual, applied;
  std::vector<float> direction;
};

struct Convergence {
  int iterations = 0;
  double residual = 0;
};

/// Preconditioned conjugate gradients (Saad 2003, "Iterative Methods for Sparse Linear Systems", algorithm 9.1) from
/// the `u` that is given.
Convergence solve(const System& system, const Vertices& right, Vertices& u, const BilateralSolverOptions& options,
                  Iterates& scratch) {
  const BilateralGrid& grid = system.grid;
  Vertices &residual = scratch.residual, &applied = scratch.applied;
  std::vector<float>& direction = scratch.direction;
  const double size = sum_over_vertices(grid, [&](int v) { return right[v] * right[v] * system.inverse_diagonal[v]; });
  double energy = sum_over_vertices(grid, [&](int v) {
    residual[v] = right[v] - system.apply(u, v);
    const double preconditioned = residual[v] * system.inverse_diagonal[v];
    direction[v] = static_cast<float>(preconditioned);
    return residual[v] * preconditioned;
  });
  const double enough = options.least_residual * options.least_residual * size;
  Convergence convergence;
  for (; convergence.iterations < options.iterations && energy > enough; ++convergence.iterations) {
    const double curvature =
        sum_over_vertices(grid, [&](int v) { return direction[v] * (applied[v] = system.apply(direction, v)); });
    if (!(curvature > 0)) break;
    const double step = energy / curvature;
    const double next = sum_over_vertices(grid, [&](int v) {
      u[v] += step * direction[v];
      residual[v] -= step * applied[v];
      return residual[v] * residual[v] * system.inverse_diagonal[v];
    });
    const double ratio = next / energy;
    energy = next;
    for_vertices(grid, [&](int v) {
      direction[v] = static_cast<float>(residual[v] * system.inverse_diagonal[v] + ratio * direction[v]);
    });
  }
  convergence.residual = size > 0 ? std::sqrt(energy / size) : 0;
  return convergence;
}

/// Whether each vertex is connected with a confident one.
std::vector<bool> reached_vertices(const System& system) {
  std::vector<bool> reached(system.grid.vertices + 1);
  reached.back() = true;
  std::vector<std::int32_t> open;
  for (std::int32_t v = 0; v < system.grid.vertices; ++v) {
    if (!(system.weight[v] > 0)) continue;
    reached[v] = true;
    open.push_back(v);
  }
  while (!open.empty()) {
    const std::int32_t* neighbors =
        system.grid.neighbors.data() + static_cast<std::size_t>(open.back()) * BilateralGrid::kNeighbors;
    open.pop_back();
    for (int k = 0; k < BilateralGrid::kNeighbors; ++k) {
      if (reached[neighbors[k]]) continue;
      reached[neighbors[k]] = true;
      open.push_back(neighbors[k]);
    }
  }
  return reached;
}

/// Replaces NaN by the value of the nearest pixel that is a number; there must be one.
void take_nearest(Image& image) {
  if (std::none_of(image.data.begin(), image.data.end(), [](float value) { return std::isnan(value); })) return;
  const int width = image.width, height = image.height;
  const auto known = [&](int x, int y) { return !std::isnan(image.at(x, y)); };
  // First the nearest along the column, then the best of the columns around, no further than what is found.
  constexpr int kNone = std::numeric_limits<int>::max();
  ImageOf<int> nearest_row(width, height, 1, kNone);
  for (int x = 0; x < width; ++x) {
    for (int y = 0; y < height; ++y) nearest_row.at(x, y) = known(x, y) ? y : y > 0 ? nearest_row.at(x, y - 1) : kNone;
    for (int y = height - 2; y >= 0; --y) {
      const int below = nearest_row.at(x, y + 1), above = nearest_row.at(x, y);
      if (below != kNone && (above == kNone || below - y < y - above)) nearest_row.at(x, y) = below;
    }
  }
  const Image before = image;
  for_rows(height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      if (!std::isnan(before.at(x, y))) continue;
      double best = std::numeric_limits<double>::infinity();
      for (int k = 0; k < width && 1.0 * k * k < best; ++k) {
        for (const int u : {x - k, x + k}) {
          if (u < 0 || u >= width || nearest_row.at(u, y) == kNone) continue;
          const double rows = nearest_row.at(u, y) - y, distance = rows * rows + 1.0 * k * k;
          if (distance >= best) continue;
          best = distance;
          for (int c = 0; c < image.channels; ++c) image.at(x, y, c) = before.at(u, nearest_row.at(u, y), c);
        }
      }
    }
  });
}

/// What each vertex starts from: the mean over its pixels where they are confident, otherwise that of the tiles around.
Vertices start_values(const System& system, const Vertices& sums) {
  const BilateralGrid& grid = system.grid;
  Image tile_mean(grid.columns(), grid.rows()), tile_confidence(grid.columns(), grid.rows());
  for (std::size_t tile = 0; tile < tile_mean.data.size(); ++tile) {
    double weight = 0, sum = 0;
    for (std::int32_t v = grid.first_of_tile[tile]; v < grid.first_of_tile[tile + 1]; ++v) {
      weight += system.weight[v];
      sum += sums[v];
    }
    if (!(weight > 0)) continue;
    tile_mean.data[tile] = static_cast<float>(sum / weight);
    tile_confidence.data[tile] = static_cast<float>(std::min(weight, 1.0));
  }
  const Image around = fill_gaps(tile_mean, tile_confidence);
  Vertices start = make_vertices(grid);
  for (std::size_t tile = 0; tile < around.data.size(); ++tile) {
    for (std::int32_t v = grid.first_of_tile[tile]; v < grid.first_of_tile[tile + 1]; ++v) {
      const double own = std::min(system.weight[v], 1.0);
      start[v] = (own > 0 ? own * sums[v] / system.weight[v] : 0) + (1 - own) * around.data[tile];
    }
  }
  return start;
}

Vertices mean_of_pixels(const BilateralGrid& grid, const Image& image, int channel) {
  Vertices sums = make_vertices(grid), pixels = sums;
  for_pixels(grid, [&](std::size_t i, std::int32_t v) {
    const float value = image.data[i * image.channels + channel];
    sums[v] += std::isfinite(value) ? value : 0;
    pixels[v] += 1;
  });
  for_vertices(grid, [&](int v) { sums[v] /= pixels[v]; });
  return sums;
}

double mean_of_finite(const Image& image, int channel) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = channel; i < image.data.size(); i += image.channels) {
    if (!std::isfinite(image.data[i])) continue;
    sum += image.data[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

void fill_channel(Image& image, int channel, double value) {
  for (std::size_t i = channel; i < image.data.size(); i += image.channels) image.data[i] = static_cast<float>(value);
}

/// The first and the second half of the channels.
std::pair<Image, Image> split_channels(const Image& image) {
  const int half = image.channels / 2;
  std::pair<Image, Image> halves(Image(image.width, image.height, half), Image(image.width, image.height, half));
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float* from = image.data.data() + i * image.channels;
    std::copy_n(from, half, halves.first.data.begin() + static_cast<std::ptrdiff_t>(i * half));
    std::copy_n(from + half, half, halves.second.data.begin() + static_cast<std::ptrdiff_t>(i * half));
  }
  return halves;
}

void require_inputs(const BilateralGrid& grid, const Image& guide, const Image& target, const Image& confidence,
                    const Image& start) {
  const auto fits = [&](const Image& image) { return image.width == grid.width && image.height == grid.height; };
  if (fits(guide) && (guide.channels == 1 || guide.channels == 3) && fits(target) && fits(confidence) &&
      confidence.channels == 1 && target.channels >= 1 &&
      (start.empty() || (fits(start) && start.channels == target.channels))) {
    return;
  }
  throw InputError(
      fmt::format("bilateral solver: guide (1 or 3 channels), target, confidence (1) and start must be {} x {}",
                  grid.width, grid.height));
}

/// Confidence, 0 where it or any channel of the target is not finite, nowhere negative.
Image usable_confidence(const Image& target, const Image& confidence) {
  Image usable = confidence;
  for_rows(usable.height, [&](int y) {
    for (int x = 0; x < usable.width; ++x) {
      float& value = usable.at(x, y);
      for (int c = 0; c < target.channels; ++c) value = std::isfinite(target.at(x, y, c)) ? value : 0;
      value = std::isfinite(value) ? std::max(value, 0.0f) : 0;
    }
  });
  return usable;
}

/// One problem being solved: the system of Eq. 4, its right side, and the memory that its solves share.
class Solver {
 public:
  Solver(const BilateralGrid& grid, const Image& target, const BilateralSolverOptions& options)
      : grid_(grid),
        target_(target),
        options_(options),
        system_{grid, bistochastize(grid, options.bistochastic_iterations), make_vertices(grid), make_vertices(grid),
                make_vertices(grid)},
        scratch_{make_vertices(grid), make_vertices(grid),
                 std::vector<float>(static_cast<std::size_t>(grid.vertices) + 1)},
        sums_(make_vertices(grid)),
        right_(sums_),
        u_(target.channels) {
    for (double& s : system_.s) s *= std::sqrt(static_cast<double>(options.lambda));
  }

  /// All rounds of reweighting, each channel by itself.
  void solve_values(const Image& confidence, const Image& start) {
    weight_ = confidence;
    for (int round = 0; round <= options_.robust_rounds; ++round) {
      if (round > 0) reweight(confidence);
      set_weights(system_, weight_);
      convergence_ = {};
      for (int c = 0; c < target_.channels; ++c) {
        splat([&](std::size_t i) { return target_at(i, c); });
        if (round == 0) {
          u_[c] = start.empty() ? start_values(system_, sums_) : mean_of_pixels(grid_, start, c);
          for_vertices(grid_, [&](int v) { u_[c][v] *= system_.s[v]; });
        }
        solve_for(u_[c]);
      }
    }
  }

  double value(int channel, int vertex) const { return u_[channel][vertex] / system_.s[vertex]; }

  /// E[t^2] - E[t]^2 of every vertex, taken about the mean of all targets lest digits cancel.
  Vertices variances(int channel) {
    const double center = mean_of_finite(target_, channel);
    splat([&](std::size_t i) { return (target_at(i, channel) - center) * (target_at(i, channel) - center); });
    Vertices squares = start_values(system_, sums_);
    for_vertices(grid_, [&](int v) { squares[v] *= system_.s[v]; });
    solve_for(squares);
    for_vertices(grid_, [&](int v) {
      const double mean = u_[channel][v] / system_.s[v] - center;
      squares[v] = std::max(squares[v] / system_.s[v] - mean * mean, 0.0);
    });
    return squares;
  }

  std::vector<bool> reached() const { return reached_vertices(system_); }
  const Convergence& convergence() const { return convergence_; }

 private:
  double target_at(std::size_t pixel, int channel) const { return target_.data[pixel * target_.channels + channel]; }

  /// Sums of confidence times f of each pixel, and the system's right side.
  template <typename F>
  void splat(const F& f) {
    std::fill(sums_.begin(), sums_.end(), 0.0);
    for_pixels(grid_, [&](std::size_t i, std::int32_t v) {
      if (weight_.data[i] > 0) sums_[v] += weight_.data[i] * f(i);
    });
    for_vertices(grid_, [&](int v) { right_[v] = sums_[v] / system_.s[v]; });
  }

  void solve_for(Vertices& u) {
    const Convergence convergence = solve(system_, right_, u, options_, scratch_);
    convergence_.iterations = std::max(convergence_.iterations, convergence.iterations);
    convergence_.residual = std::max(convergence_.residual, convergence.residual);
  }

  /// Weights of Geman and McClure's loss at the last round's values.
  void reweight(const Image& confidence) {
    const double scale = 1 / (static_cast<double>(options_.robust_scale) * options_.robust_scale);
    for_pixels(grid_, [&](std::size_t i, std::int32_t v) {
      if (!(confidence.data[i] > 0)) return;
      double error = 0;
      for (int c = 0; c < target_.channels; ++c) {
        const double difference = target_at(i, c) - u_[c][v] / system_.s[v];
        error += difference * difference;
      }
      const double likeness = 1 / (1 + scale * error);
      weight_.data[i] = static_cast<float>(confidence.data[i] * likeness * likeness);
    });
  }

  const BilateralGrid& grid_;
  const Image& target_;
  const BilateralSolverOptions& options_;
  System system_;
  Iterates scratch_;
  Vertices sums_, right_;
  std::vector<Vertices> u_;  ///< s times the values, a channel each
  Image weight_;
  Convergence convergence_;
};

/// The answer where confidence is 0 throughout.
BilateralSolution mean_everywhere(const BilateralGrid& grid, const Image& target, bool variance) {
  BilateralSolution solution;
  solution.value = Image(grid.width, grid.height, target.channels);
  for (int c = 0; c < target.channels; ++c) fill_channel(solution.value, c, mean_of_finite(target, c));
  if (variance) solution.variance = Image(grid.width, grid.height, target.channels, kUnknownVariance);
  return solution;
}

}  // namespace

Image fill_gaps(const Image& target, const Image& confidence) {
  const int width = target.width, height = target.height;
  Image filled(width, height);
  if (width <= 1 && height <= 1) {
    if (!target.empty() && confidence.data[0] > 0) filled.data[0] = target.data[0];
    return filled;
  }
  // Pull: half the size, a mean weighted by confidence; confidences add up, to 1 at most.
  Image coarse_target((width + 1) / 2, (height + 1) / 2), coarse_confidence((width + 1) / 2, (height + 1) / 2);
  for (int y = 0; y < coarse_target.height; ++y) {
    for (int x = 0; x < coarse_target.width; ++x) {
      double weights = 0, sum = 0;
      for (int v = 2 * y; v < std::min(2 * y + 2, height); ++v) {
        for (int u = 2 * x; u < std::min(2 * x + 2, width); ++u) {
          weights += confidence.at(u, v);
          sum += static_cast<double>(confidence.at(u, v)) * target.at(u, v);
        }
      }
      if (!(weights > 0)) continue;
      coarse_target.at(x, y) = static_cast<float>(sum / weights);
      coarse_confidence.at(x, y) = static_cast<float>(std::min(weights, 1.0));
    }
  }
  // Push: where confidence is below 1, the rest comes from the coarser level.
  const Image around = resize_bilinear(fill_gaps(coarse_target, coarse_confidence), width, height);
  for (std::size_t i = 0; i < filled.data.size(); ++i) {
    const float own = std::min(confidence.data[i], 1.0f);
    filled.data[i] = own * target.data[i] + (1 - own) * around.data[i];
  }
  return filled;
}

OptionFields fields(BilateralSolverOptions& options) {
  return {{"lambda", &options.lambda, 1e-12, 1e12, "", "ours"},
          {"iterations", &options.iterations, 0, 1e6, "", "Barron and Poole 2016: 25"},
          {"least_residual", &options.least_residual, 0, 1e12, "", "ours"},
          {"bistochastic_iterations", &options.bistochastic_iterations, 1, 1e6, "", "ours"},
          {"robust_rounds", &options.robust_rounds, 0, 1000, "", "ours"},
          {"robust_scale", &options.robust_scale, 1e-12, 1e12, "of the target", "ours"}};
}

BilateralSolution solve_bilateral(const BilateralGrid& grid, const Image& guide, const Image& target,
                                  const Image& confidence, const BilateralSolverOptions& options, const Image& start) {
  require_inputs(grid, guide, target, confidence, start);
  check_options("solver", options);
  const int channels = target.channels;
  Solver solver(grid, target, options);
  solver.solve_values(usable_confidence(target, confidence), start);

  const std::vector<bool> reached = solver.reached();
  if (std::find(reached.begin(), reached.end() - 1, true) == reached.end() - 1) {
    BilateralSolution solution = mean_everywhere(grid, target, options.variance);
    solution.iterations = solver.convergence().iterations;
    solution.residual = solver.convergence().residual;
    return solution;
  }

  // Values, then variances, of each vertex; not a number where no confidence reaches.
  const int width = options.variance ? 2 * channels : channels;
  std::vector<float> values(static_cast<std::size_t>(grid.vertices) * width);
  const auto store = [&](int c, const auto& value_of) {
    for_vertices(grid, [&](int v) {
      values[static_cast<std::size_t>(v) * width + c] =
          reached[v] ? static_cast<float>(value_of(v)) : std::numeric_limits<float>::quiet_NaN();
    });
  };
  for (int c = 0; c < channels; ++c) {
    store(c, [&](int v) { return solver.value(c, v); });
    if (!options.variance) continue;
    const Vertices variances = solver.variances(c);
    store(channels + c, [&](int v) { return variances[v]; });
  }
  BilateralSolution solution;
  solution.iterations = solver.convergence().iterations;
  solution.residual = solver.convergence().residual;
  solution.value = interpolate(grid, guide, values, width);
  if (options.variance) std::tie(solution.value, solution.variance) = split_channels(solution.value);
  take_nearest(solution.value);
  for (float& value : solution.variance.data) value = std::isnan(value) ? kUnknownVariance : value;
  return solution;
}

}  // namespace dualpixel::pipeline
