#include "pipeline/edge_aware/bilateral_solver.h"

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

/// One value for each vertex and, at the end, the 0 that stands for a neighbour that is not there.
using Vertices = std::vector<double>;

constexpr std::size_t kGrain = 4096;  // part of the result: sums are taken in chunks of this size

template <typename F>
void for_vertices(const BilateralGrid& grid, const F& f) {
  tbb::parallel_for(tbb::blocked_range<int>(0, grid.vertices, kGrain), [&](const tbb::blocked_range<int>& range) {
    for (int v = range.begin(); v < range.end(); ++v) f(v);
  });
}

double dot(const Vertices& a, const Vertices& b) {
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, a.size(), kGrain), 0.0,
      [&](const tbb::blocked_range<std::size_t>& range, double sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) sum += a[i] * b[i];
        return sum;
      },
      std::plus<>());
}

Vertices make_vertices(const BilateralGrid& grid, double fill = 0) {
  Vertices vertices(static_cast<std::size_t>(grid.vertices) + 1, fill);
  vertices.back() = 0;
  return vertices;
}

/// (B v)(vertex): twice the number of axes on the vertex itself, once each neighbour.
double blur_at(const BilateralGrid& grid, const Vertices& values, int vertex) {
  const std::int32_t* neighbors = grid.neighbors.data() + static_cast<std::size_t>(vertex) * BilateralGrid::kNeighbors;
  double sum = BilateralGrid::kNeighbors * values[vertex];
  for (int k = 0; k < BilateralGrid::kNeighbors; ++k) sum += values[neighbors[k]];
  return sum;
}

/// The diagonals n and m for which Dn B Dn has row sums m, with m about the pixels of each vertex.
struct Bistochastic {
  Vertices n;
  Vertices m;
};

Bistochastic bistochastise(const BilateralGrid& grid, const Vertices& pixels, int iterations) {
  Bistochastic result{make_vertices(grid, 1), pixels};
  Vertices next = make_vertices(grid);
  for (int i = 0; i < iterations; ++i) {
    for_vertices(grid, [&](int v) { next[v] = std::sqrt(result.n[v] * pixels[v] / blur_at(grid, result.n, v)); });
    std::swap(result.n, next);
  }
  for_vertices(grid, [&](int v) { result.m[v] = result.n[v] * blur_at(grid, result.n, v); });
  return result;
}

}  // namespace

Image fill_gaps(const Image& target, const Image& confidence) {
  const int width = target.width, height = target.height;
  Image filled(width, height);
  if (width == 1 && height == 1) {
    if (confidence.data[0] > 0) filled.data[0] = target.data[0];
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
  // Push: what confidence leaves open comes from there.
  const Image around = resize_bilinear(fill_gaps(coarse_target, coarse_confidence), width, height);
  for (std::size_t i = 0; i < filled.data.size(); ++i) {
    const float own = std::min(confidence.data[i], 1.0f);
    filled.data[i] = own * target.data[i] + (1 - own) * around.data[i];
  }
  return filled;
}

Image solve_bilateral(const BilateralGrid& grid, const Image& target, const Image& confidence,
                      const BilateralSolverOptions& options) {
  Image clean_target = target, clean_confidence = confidence;
  for (std::size_t i = 0; i < target.data.size(); ++i) {
    if (std::isfinite(target.data[i]) && std::isfinite(confidence.data[i]) && confidence.data[i] > 0) continue;
    clean_target.data[i] = 0;
    clean_confidence.data[i] = 0;
  }
  const Image filled = fill_gaps(clean_target, clean_confidence);

  // Splat: sums over the pixels of each vertex.
  Vertices pixels = make_vertices(grid), weight = pixels, right_side = pixels, y = pixels;
  for (std::size_t i = 0; i < grid.vertex_of_pixel.size(); ++i) {
    const std::int32_t v = grid.vertex_of_pixel[i];
    pixels[v] += 1;
    weight[v] += clean_confidence.data[i];
    right_side[v] += static_cast<double>(clean_confidence.data[i]) * clean_target.data[i];
    y[v] += filled.data[i];
  }
  for_vertices(grid, [&](int v) { y[v] /= pixels[v]; });

  const auto [n, m] = bistochastise(grid, pixels, options.bistochastic_iterations);
  const double lambda = options.lambda;
  Vertices scaled = make_vertices(grid);
  const auto apply = [&, &n = n, &m = m](const Vertices& x, Vertices& result) {
    for_vertices(grid, [&](int v) { scaled[v] = n[v] * x[v]; });
    for_vertices(
        grid, [&](int v) { result[v] = lambda * (m[v] * x[v] - n[v] * blur_at(grid, scaled, v)) + weight[v] * x[v]; });
  };
  Vertices inverse_diagonal = make_vertices(grid);
  for_vertices(grid, [&, &n = n, &m = m](int v) {
    const double diagonal = lambda * (m[v] - n[v] * n[v] * BilateralGrid::kNeighbors) + weight[v];
    inverse_diagonal[v] = 1 / std::max(diagonal, 1e-5);
  });

  // Preconditioned conjugate gradients (Saad 2003, "Iterative Methods for Sparse Linear Systems", algorithm 9.1).
  Vertices residual = make_vertices(grid), preconditioned = residual, direction = residual, applied = residual;
  apply(y, applied);
  for_vertices(grid, [&](int v) {
    residual[v] = right_side[v] - applied[v];
    preconditioned[v] = direction[v] = inverse_diagonal[v] * residual[v];
  });
  double energy = dot(residual, preconditioned);
  const double negligible = 1e-24 * (energy + dot(right_side, right_side));
  for (int i = 0; i < options.iterations && energy > negligible; ++i) {
    apply(direction, applied);
    const double step = energy / dot(direction, applied);
    for_vertices(grid, [&](int v) {
      y[v] += step * direction[v];
      residual[v] -= step * applied[v];
      preconditioned[v] = inverse_diagonal[v] * residual[v];
    });
    const double next = dot(residual, preconditioned);
    const double ratio = next / energy;
    energy = next;
    for_vertices(grid, [&](int v) { direction[v] = preconditioned[v] + ratio * direction[v]; });
  }

  Image solved(grid.width, grid.height);
  for (std::size_t i = 0; i < solved.data.size(); ++i) {
    solved.data[i] = static_cast<float>(y[grid.vertex_of_pixel[i]]);
  }
  return solved;
}

}  // namespace dualpixel::pipeline
