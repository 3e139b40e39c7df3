#include "simulator/lens/prescription/pupil_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulator/lens/prescription/cubic.h"

namespace dualpixel::simulator {
namespace {

constexpr int kPupilLanes = 16;
/// The cells of a grid of directions that pass: rows in M, columns in L >= 0 (the lens is symmetric about M's axis).
struct Grid {
  int columns, rows;
  double m_low, m_step, l_step;
  std::vector<char> passes;
  double l(int i) const { return (i + 0.5) * l_step; }
  double m(int j) const { return m_low + (j + 0.5) * m_step; }
};

/// In single precision: where exactly a rim lies is settled by the rays themselves.
Grid trace_grid(const TracedLens<float>& lens, double r, double center_m, double half_m, double half_l, int columns,
                int rows) {
  Grid grid{columns, rows, center_m - half_m, 2 * half_m / rows, half_l / columns, std::vector<char>(columns * rows)};
  RayBatch<float, kPupilLanes> rays;
  for (int first = 0; first < columns * rows; first += kPupilLanes) {
    for (int i = 0; i < kPupilLanes; ++i) {
      const int cell = std::min(first + i, columns * rows - 1);
      const auto l = static_cast<float>(grid.l(cell % columns)), m = static_cast<float>(grid.m(cell / columns));
      rays.x[i] = 0, rays.y[i] = static_cast<float>(r), rays.z[i] = static_cast<float>(lens.sensor_z_mm());
      rays.l[i] = l;
      rays.m[i] = m;
      rays.n[i] = -std::sqrt(std::max(1 - l * l - m * m, 1e-4f));
      rays.end[i] = l * l + m * m > 0.9999f ? static_cast<float>(RayEnd::missed) : 0.0f;
    }
    lens.trace(rays);
    for (int i = 0; i < kPupilLanes && first + i < columns * rows; ++i) grid.passes[first + i] = rays.end[i] == 0;
  }
  return grid;
}

/// Only what hangs together with the passing cell nearest to `chief_m` remains.
void keep_main_region(Grid& grid, double chief_m) {
  int seed = -1;
  double nearest = std::numeric_limits<double>::infinity();
  for (int cell = 0; cell < grid.columns * grid.rows; ++cell) {
    if (!grid.passes[cell]) continue;
    const double d = std::hypot(grid.l(cell % grid.columns), grid.m(cell / grid.columns) - chief_m);
    if (d < nearest) {
      nearest = d;
      seed = cell;
    }
  }
  std::vector<char> kept(grid.passes.size(), 0);
  std::vector<int> open;
  if (seed >= 0) open.push_back(seed);
  while (!open.empty()) {
    const int cell = open.back();
    open.pop_back();
    if (!grid.passes[cell] || kept[cell]) continue;
    kept[cell] = 1;
    const int i = cell % grid.columns, j = cell / grid.columns;
    if (i > 0) open.push_back(cell - 1);
    if (i + 1 < grid.columns) open.push_back(cell + 1);
    if (j > 0) open.push_back(cell - grid.columns);
    if (j + 1 < grid.rows) open.push_back(cell + grid.columns);
  }
  grid.passes = std::move(kept);
}

struct Point {
  double l, m;
};

/// Outer corners of the first and last passing cell of each row.
std::vector<Point> outline(const Grid& grid) {
  std::vector<Point> points;
  for (int j = 0; j < grid.rows; ++j) {
    int last = -1;
    for (int i = 0; i < grid.columns; ++i) {
      if (grid.passes[j * grid.columns + i]) last = i;
    }
    if (last < 0) continue;
    const double l = (last + 1) * grid.l_step;
    points.push_back({l, grid.m(j) - 0.5 * grid.m_step});
    points.push_back({l, grid.m(j) + 0.5 * grid.m_step});
  }
  return points;
}

/// The ellipse of least area about the outline: its center lies on L = 0.
PupilEllipse smallest_ellipse(const std::vector<Point>& points) {
  double low = points.front().m, high = low, width = 0;
  for (const Point& p : points) {
    low = std::min(low, p.m);
    high = std::max(high, p.m);
    width = std::max(width, p.l);
  }
  const auto reach2 = [&](double center, double ratio) {  // squared half_m that holds all points, half_l = ratio half_m
    double most = 0;
    for (const Point& p : points) {
      most = std::max(most, (p.m - center) * (p.m - center) + p.l * p.l / (ratio * ratio));
    }
    return most;
  };
  const double half = 0.5 * (high - low);
  double center = 0.5 * (low + high), ratio = width / half;
  double best = reach2(center, ratio) * ratio;
  for (double step = 0.25; step > 1e-3; step /= 2) {
    for (bool improved = true; improved;) {
      improved = false;
      for (int move = 0; move < 4; ++move) {
        const double c = center + (move == 0 ? step : move == 1 ? -step : 0) * half;
        const double q = ratio * (move == 2 ? 1 + step : move == 3 ? 1 / (1 + step) : 1);
        const double area = reach2(c, q) * q;
        if (area < best * (1 - 1e-9)) {
          best = area;
          center = c;
          ratio = q;
          improved = true;
        }
      }
    }
  }
  const double half_m = std::sqrt(reach2(center, ratio));
  return {0, center, half_m, half_m * ratio, 0};
}

double pass_area(const Grid& grid) {
  return 2 * grid.l_step * grid.m_step *
         static_cast<double>(std::count(grid.passes.begin(), grid.passes.end(), static_cast<char>(1)));
}

/// The pass region at r, from a first guess of its extent.
PupilEllipse find_region(const TracedLens<float>& lens, double r, double chief_m, double half, int fine) {
  double half_l = half, center = chief_m, half_m = half;
  PupilEllipse found;
  for (int attempt = 0; attempt < 6; ++attempt) {
    Grid grid = trace_grid(lens, r, center, half_m, half_l, 32, 64);
    keep_main_region(grid, chief_m);
    const std::vector<Point> points = outline(grid);
    if (points.empty()) {  // nothing, or too little to be seen in this grid
      half_m /= 3;
      half_l /= 3;
      continue;
    }
    found = smallest_ellipse(points);
    const bool cut =
        points.front().m <= grid.m_low + grid.m_step || points.back().m >= grid.m(grid.rows - 1) ||
        std::any_of(points.begin(), points.end(), [&](const Point& p) { return p.l >= half_l - grid.l_step; });
    center = found.center_m;
    half_m = (cut ? 1.6 : 1.05) * found.half_m;
    half_l = (cut ? 1.6 : 1.05) * found.half_l;
    if (cut) continue;
    Grid refined = trace_grid(lens, r, center, half_m, half_l, fine / 2, fine);
    keep_main_region(refined, chief_m);
    const std::vector<Point> finer = outline(refined);
    if (finer.empty()) break;
    PupilEllipse result = smallest_ellipse(finer);
    result.chief_m = chief_m;
    result.pass_area = pass_area(refined);
    return result;
  }
  PupilEllipse nothing;
  nothing.chief_m = nothing.center_m = chief_m;
  return nothing;
}

}  // namespace

double chief_cosine(const TracedLens<double>& unclipped, double r_mm, double guess) {
  double low = guess - 0.08, high = guess + 0.08;
  RayBatch<double, kPupilLanes> rays;
  for (int round = 0; round < 9; ++round) {
    const double step = (high - low) / (kPupilLanes - 1);
    for (int i = 0; i < kPupilLanes; ++i) {
      rays.x[i] = 0, rays.y[i] = r_mm, rays.z[i] = unclipped.sensor_z_mm();
      rays.l[i] = 0;
      rays.m[i] = low + i * step;
      rays.n[i] = -std::sqrt(std::max(1 - rays.m[i] * rays.m[i], 1e-12));
      rays.end[i] = 0;
    }
    unclipped.trace(rays);
    int bracket = -1;
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0; i + 1 < kPupilLanes; ++i) {
      const bool usable = rays.end[i] == 0 && rays.end[i + 1] == 0;
      if (!usable || (rays.stop_y[i] < 0) == (rays.stop_y[i + 1] < 0)) continue;
      const double distance = std::abs(low + (i + 0.5) * step - guess);
      if (distance < nearest) {
        nearest = distance;
        bracket = i;
      }
    }
    if (bracket < 0) return std::numeric_limits<double>::quiet_NaN();
    const double a = rays.stop_y[bracket], b = rays.stop_y[bracket + 1];
    const double m_a = low + bracket * step;
    guess = m_a + step * a / (a - b);
    low = m_a;
    high = m_a + step;
    if (step < 1e-13) break;
  }
  return guess;
}

PupilEllipse PupilBounds::at(double r_mm) const {
  const double u = std::clamp(r_mm / image_radius_mm * (kNodes - 1), 0.0, kNodes - 1.0);
  const int i = std::min(static_cast<int>(u), kNodes - 2);
  const double t = u - i;
  const std::array<double, 4> w = cubic_weights(t);
  // one before the axis is the mirror image of one behind it; one past the end continues the line
  const auto value = [&](double PupilEllipse::*field, double mirror) {
    const double v1 = nodes[i].*field, v2 = nodes[i + 1].*field;
    const double v0 = i > 0 ? nodes[i - 1].*field : mirror * nodes[1].*field;
    const double v3 = i + 2 < kNodes ? nodes[i + 2].*field : 2 * v2 - v1;
    return w[0] * v0 + w[1] * v1 + w[2] * v2 + w[3] * v3;
  };
  PupilEllipse e;
  e.chief_m = value(&PupilEllipse::chief_m, -1);
  e.center_m = value(&PupilEllipse::center_m, -1);
  e.half_m = std::max(value(&PupilEllipse::half_m, 1), 0.0);
  e.half_l = std::max(value(&PupilEllipse::half_l, 1), 0.0);
  e.pass_area = (1 - t) * nodes[i].pass_area + t * nodes[i + 1].pass_area;
  return e;
}

PupilBounds find_pupil(const Prescription& lens, double wavelength_nm, double image_radius_mm) {
  const TracedLens<float> clipped(lens, wavelength_nm);
  const TracedLens<double> unclipped(lens, wavelength_nm, false);
  PupilBounds bounds;
  bounds.image_radius_mm = image_radius_mm;
  std::array<double, PupilBounds::kNodes> chief{};
  for (int k = 1; k < PupilBounds::kNodes; ++k) {  // outwards, each from the line through the two before
    const double guess = k == 1 ? 0 : 2 * chief[k - 1] - chief[k - 2];
    chief[k] = chief_cosine(unclipped, image_radius_mm * k / (PupilBounds::kNodes - 1), guess);
    if (std::isnan(chief[k])) chief[k] = guess;  // where light gets through at all it does so near the line
  }
  const Paraxial p = paraxial(lens);
  const double half =
      0.75 * p.exit_pupil_diameter / std::hypot(clipped.sensor_z_mm() - p.exit_pupil_z, 0.5 * p.exit_pupil_diameter);
  tbb::parallel_for(0, PupilBounds::kNodes, [&](int k) {
    const double r = image_radius_mm * k / (PupilBounds::kNodes - 1);
    PupilEllipse& node = bounds.nodes[k];
    node = find_region(clipped, r, chief[k], std::min(half, 0.99), k == 0 ? 256 : 96);
    constexpr double kMargin = 1.004;  // between nodes the region may bulge a little
    node.half_m *= kMargin;
    node.half_l *= kMargin;
  });
  return bounds;
}

}  // namespace dualpixel::simulator
