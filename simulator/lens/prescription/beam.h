#pragma once
#include <algorithm>
#include <cmath>

#include "simulator/lens/prescription/ray_counts.h"
#include "simulator/lens/prescription/ray_trace.h"

/// Parallel light through a prescription, in double precision; lens frame, mm.
namespace dualpixel::simulator {

inline constexpr int kBeamLanes = 16;
using BeamRays = RayBatch<double, kBeamLanes>;

/// Parallel light at theta from the axis, tilted along y; a ray is named by where it crosses the entrance pupil.
class Beam {
 public:
  Beam(const Prescription& lens, double wavelength_nm, double theta)
      : clipped_(lens, wavelength_nm), free_(lens, wavelength_nm, false), pupil_z_(paraxial(lens).entrance_pupil_z) {
    m_ = std::sin(theta);
    n_ = std::cos(theta);
    // far enough before the lens that no surface lies in front
    start_z_ = -1;
    double z = 0;
    for (const LensSurface& s : lens.surfaces) {
      start_z_ = std::min(start_z_, z - 2 * s.semi_diameter_mm);
      z += s.thickness_mm;
    }
  }

  void launch(BeamRays& rays, int i, double x, double y) const {
    const double t = (start_z_ - pupil_z_) / n_;
    rays.x[i] = x;
    rays.y[i] = y + t * m_;
    rays.z[i] = start_z_;
    rays.l[i] = 0, rays.m[i] = m_, rays.n[i] = n_;
    rays.end[i] = 0;
  }
  void trace(BeamRays& rays) const { clipped_.trace(rays); }
  double sensor_z() const { return clipped_.sensor_z_mm(); }

  /// The ray that crosses the stop at (sx, sy), in stop radii: Newton on the two coordinates. False where none is
  /// found.
  bool through_stop(double sx, double sy, double radius, double guess[2], RayBatch<double, 1>& found) const {
    double x = guess[0], y = guess[1];
    BeamRays rays;
    for (int round = 0; round < 40; ++round) {
      const double step = 1e-4 * radius;
      for (int i = 0; i < kBeamLanes; ++i) launch(rays, i, x + (i == 1 ? step : 0), y + (i == 2 ? step : 0));
      free_.trace(rays);
      for (int i = 0; i < 3; ++i) {
        if (rays.end[i] != 0) return false;
      }
      const double ex = rays.stop_x[0] - sx, ey = rays.stop_y[0] - sy;
      if (std::abs(ex) + std::abs(ey) < 1e-13) break;
      const double a = (rays.stop_x[1] - rays.stop_x[0]) / step, b = (rays.stop_x[2] - rays.stop_x[0]) / step;
      const double c = (rays.stop_y[1] - rays.stop_y[0]) / step, d = (rays.stop_y[2] - rays.stop_y[0]) / step;
      const double det = a * d - b * c;
      if (det == 0) return false;
      double dx = (d * ex - b * ey) / det, dy = (a * ey - c * ex) / det;
      const double longest = std::max(std::abs(dx), std::abs(dy));
      if (longest > 0.5 * radius) dx *= 0.5 * radius / longest, dy *= 0.5 * radius / longest;
      x -= dx;
      y -= dy;
    }
    guess[0] = x;
    guess[1] = y;
    for (int i = 0; i < kBeamLanes; ++i) launch(rays, i, x, y);
    free_.trace(rays);
    move_to_plane(rays, free_.sensor_z_mm());
    found.x[0] = rays.x[0], found.y[0] = rays.y[0], found.z[0] = rays.z[0];
    found.l[0] = rays.l[0], found.m[0] = rays.m[0], found.n[0] = rays.n[0];
    found.stop_x[0] = rays.stop_x[0], found.stop_y[0] = rays.stop_y[0];
    found.end[0] = rays.end[0];
    return rays.end[0] == 0;
  }

 private:
  TracedLens<double> clipped_, free_;
  double pupil_z_, start_z_, m_, n_;
};

/// Moments of the points where rays meet the sensor, mm.
struct Spot {
  double light = 0, x = 0, y = 0, xx = 0, yy = 0;
  void add(double px, double py) {
    light += 1;
    x += px, y += py, xx += px * px, yy += py * py;
  }
  double mean_x() const { return light > 0 ? x / light : 0; }
  double mean_y() const { return light > 0 ? y / light : 0; }
  double rms() const {
    if (light == 0) return 0;
    return std::sqrt(std::max(0.0, (xx + yy) / light - mean_x() * mean_x() - mean_y() * mean_y()));
  }
};

/// What of a beam passes the lens, and its picture on the sensor.
struct BeamTrace {
  Spot spot;
  double radius = 0;  ///< of the farthest ray from the spot's centroid
  double area = 0;    ///< of the beam's cross-section that passes, mm^2
  RayCounts counts;
};

/// All of the beam that crosses the entrance pupil about (cx, cy), on a grid: first coarse, to see where it passes,
/// then fine.
BeamTrace trace_beam(const Beam& beam, double cx, double cy, double radius);

}  // namespace dualpixel::simulator
