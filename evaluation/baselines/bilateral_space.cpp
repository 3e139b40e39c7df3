#include "evaluation/baselines/bilateral_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "capture/error.h"
#include "evaluation/baselines/lbfgs.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::BilateralGrid;

double sum_of_neighbors(const BilateralGrid& grid, const std::vector<double>& values, int vertex) {
  const std::int32_t* neighbors = grid.neighbors.data() + static_cast<std::size_t>(vertex) * BilateralGrid::kNeighbors;
  double sum = 0;
  for (int k = 0; k < BilateralGrid::kNeighbors; ++k) sum += values[neighbors[k]];
  return sum;
}

/// B, with [1 2 1] along each of the five axes.
double blurred(const BilateralGrid& grid, const std::vector<double>& values, int vertex) {
  return BilateralGrid::kNeighbors * values[vertex] + sum_of_neighbors(grid, values, vertex);
}

std::vector<double> bistochastize(const BilateralGrid& grid, int iterations) {
  std::vector<double> pixels(grid.vertices), n(grid.vertices + 1, 1.0), next(grid.vertices + 1);
  for (const std::int32_t v : grid.vertex_of_pixel) pixels[v] += 1;
  n.back() = 0;
  for (int i = 0; i < iterations; ++i) {
    for (int v = 0; v < grid.vertices; ++v) next[v] = std::sqrt(n[v] * pixels[v] / blurred(grid, n, v));
    std::swap(n, next);
  }
  return n;
}

/// Where a vertex lies, in cells: x, y, Y, Cb, Cr.
using Cell = std::array<int, 5>;

std::vector<Cell> cells_of(const BilateralGrid& grid) {
  std::vector<Cell> cells(grid.vertices);
  for (int tile = 0; tile < grid.columns() * grid.rows(); ++tile) {
    for (int v = grid.first_of_tile[tile]; v < grid.first_of_tile[tile + 1]; ++v) {
      const std::uint32_t color = grid.color[v];
      const auto part = [&](int bits) { return static_cast<int>((color >> bits) & 1023U); };
      cells[v] = {tile % grid.columns(), tile / grid.columns(), part(0), part(10), part(20)};
    }
  }
  return cells;
}

}  // namespace

BilateralSpaceEnergy::BilateralSpaceEnergy(const BilateralGrid& grid, const MatchIntervals& intervals, int labels,
                                           const BilateralSpaceOptions& options)
    : grid_(grid), vertices_(grid.vertices), labels_(labels), lambda_(options.lambda) {
  if (!(options.lambda > 0) || options.iterations < 0 || options.levels < 1 || options.levels > 16 ||
      options.bistochastic_iterations < 1) {
    throw InputError("bilateral space: lambda, iterations, levels or bistochastic_iterations is out of its range");
  }
  if (intervals.first.width != grid.width || intervals.first.height != grid.height ||
      !intervals.first.same_size(intervals.last)) {
    throw InputError(fmt::format("bilateral space: intervals: {} x {}: must have the grid's size, {} x {}",
                                 intervals.first.width, intervals.first.height, grid.width, grid.height));
  }
  n_ = bistochastize(grid, options.bistochastic_iterations);
  diagonal_.resize(vertices_);
  for (int v = 0; v < vertices_; ++v) diagonal_[v] = n_[v] * blurred(grid, n_, v);
  pixels_.resize(vertices_);
  table_.assign(static_cast<std::size_t>(vertices_) * labels, 0.0);
  for (std::size_t i = 0; i < grid.vertex_of_pixel.size(); ++i) {
    pixels_[grid.vertex_of_pixel[i]] += 1;
    double* const g = table_.data() + static_cast<std::size_t>(grid.vertex_of_pixel[i]) * labels;
    const double first = intervals.first.data[i], last = intervals.last.data[i];
    for (int k = 0; k < labels; ++k) g[k] += std::max({0.0, first - k, k - last});
  }
}

double BilateralSpaceEnergy::data(int vertex, double label, double& slope) const {
  const double* const g = table_.data() + static_cast<std::size_t>(vertex) * labels_;
  const int last = labels_ - 1;
  if (label < 0 || label > last) {
    slope = label < 0 ? -pixels_[vertex] : pixels_[vertex];
    return label < 0 ? g[0] + slope * label : g[last] + slope * (label - last);
  }
  const int k = std::min(static_cast<int>(label), last - 1);
  slope = g[k + 1] - g[k];
  return g[k] + slope * (label - k);
}

double BilateralSpaceEnergy::operator()(const std::vector<double>& v, std::vector<double>& gradient) const {
  std::vector<double> scaled(vertices_ + 1);
  for (int j = 0; j < vertices_; ++j) scaled[j] = n_[j] * v[j];
  double energy = 0;
  for (int j = 0; j < vertices_; ++j) {
    const double smooth = diagonal_[j] * v[j] - n_[j] * blurred(grid_, scaled, j);
    double slope = 0;
    energy += 0.5 * v[j] * smooth + lambda_ * data(j, v[j], slope);
    gradient[j] = smooth + lambda_ * slope;
  }
  return energy;
}

std::vector<std::vector<std::int32_t>> grid_pyramid(const BilateralGrid& grid, int levels) {
  std::vector<std::vector<std::int32_t>> parents;
  std::vector<Cell> cells = cells_of(grid);
  for (int level = 1; level < levels; ++level) {
    std::map<Cell, std::int32_t> known;
    std::vector<std::int32_t> parent(cells.size());
    std::vector<Cell> above;
    for (std::size_t v = 0; v < cells.size(); ++v) {
      Cell cell = cells[v];
      for (int& coordinate : cell) coordinate /= 2;
      const auto [entry, is_new] = known.try_emplace(cell, static_cast<std::int32_t>(above.size()));
      if (is_new) above.push_back(cell);
      parent[v] = entry->second;
    }
    parents.push_back(std::move(parent));
    cells = std::move(above);
  }
  return parents;
}

std::vector<double> solve_bilateral_space(const BilateralGrid& grid, const MatchIntervals& intervals, int labels,
                                          const BilateralSpaceOptions& options) {
  const BilateralSpaceEnergy energy(grid, intervals, labels, options);
  const std::vector<std::vector<std::int32_t>> parents = grid_pyramid(grid, options.levels);
  std::vector<std::size_t> begins = {0, static_cast<std::size_t>(grid.vertices)};
  for (const auto& parent : parents) {
    begins.push_back(begins.back() + 1 + *std::max_element(parent.begin(), parent.end()));
  }
  const int middle = labels / 2;
  // z holds the levels one after the other, the grid's own first
  const auto vertices_from = [&](std::vector<double> z) {
    for (std::size_t level = parents.size(); level-- > 0;) {
      for (std::size_t v = 0; v < parents[level].size(); ++v)
        z[begins[level] + v] += z[begins[level + 1] + parents[level][v]];
    }
    z.resize(begins[1]);
    for (double& label : z) label += middle;
    return z;
  };
  const auto objective = [&](const std::vector<double>& z, std::vector<double>& gradient) {
    std::vector<double> slopes(grid.vertices);
    const double value = energy(vertices_from(z), slopes);
    std::fill(gradient.begin(), gradient.end(), 0.0);
    std::copy(slopes.begin(), slopes.end(), gradient.begin());
    for (std::size_t level = 0; level < parents.size(); ++level) {
      for (std::size_t v = 0; v < parents[level].size(); ++v) {
        gradient[begins[level + 1] + parents[level][v]] += gradient[begins[level] + v];
      }
    }
    return value;
  };
  return vertices_from(minimize_lbfgs(objective, std::vector<double>(begins.back()), options.iterations));
}

}  // namespace dualpixel::evaluation
