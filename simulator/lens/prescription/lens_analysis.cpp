#include "simulator/lens/prescription/lens_analysis.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/lens/prescription/pupil_bounds.h"

namespace dualpixel::simulator {
namespace {

constexpr int kLanes = 16;
using Batch = RayBatch<double, kLanes>;

/// Parallel light at theta from the axis, tilted along x or y; a ray is named by where it crosses the entrance pupil.
class Beam {
 public:
  Beam(const Prescription& lens, double wavelength_nm, double theta, bool along_x)
      : clipped_(lens, wavelength_nm), free_(lens, wavelength_nm, false), pupil_z_(paraxial(lens).entrance_pupil_z) {
    const double tilt = std::sin(theta);
    l_ = along_x ? tilt : 0;
    m_ = along_x ? 0 : tilt;
    n_ = std::cos(theta);
    // far enough before the lens that no surface lies in front
    start_z_ = -1;
    double z = 0;
    for (const LensSurface& s : lens.surfaces) {
      start_z_ = std::min(start_z_, z - 2 * s.semi_diameter_mm);
      z += s.thickness_mm;
    }
  }

  void launch(Batch& rays, int i, double x, double y) const {
    const double t = (start_z_ - pupil_z_) / n_;
    rays.x[i] = x + t * l_;
    rays.y[i] = y + t * m_;
    rays.z[i] = start_z_;
    rays.l[i] = l_, rays.m[i] = m_, rays.n[i] = n_;
    rays.end[i] = 0;
  }
  void trace(Batch& rays) const { clipped_.trace(rays); }
  double sensor_z() const { return clipped_.sensor_z_mm(); }

  /// The ray that crosses the stop at (sx, sy), in stop radii: Newton on the two coordinates. False where none is
  /// found.
  bool through_stop(double sx, double sy, double radius, double guess[2], RayBatch<double, 1>& found) const {
    double x = guess[0], y = guess[1];
    Batch rays;
    for (int round = 0; round < 40; ++round) {
      const double step = 1e-4 * radius;
      for (int i = 0; i < kLanes; ++i) launch(rays, i, x + (i == 1 ? step : 0), y + (i == 2 ? step : 0));
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
    for (int i = 0; i < kLanes; ++i) launch(rays, i, x, y);
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
  double pupil_z_, start_z_, l_, m_, n_;
};

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

struct Bundle {
  Spot whole, left, right;
  double radius = 0;  ///< of the farthest ray from the whole spot's centroid
  double area = 0;    ///< of the beam's cross-section that passes, mm^2
  RayCounts counts;
};

/// All of the beam on a grid about (cx, cy): first coarse, to see where it passes, then fine.
Bundle trace_beam(const Beam& beam, double cx, double cy, double radius, double sensor_shift) {
  double x0 = cx - 2 * radius, x1 = cx + 2 * radius, y0 = cy - 2 * radius, y1 = cy + 2 * radius;
  Bundle bundle;
  std::vector<std::array<double, 2>> points;
  for (int side : {64, 256}) {
    bundle = {};
    points.clear();
    double low_x = x1, high_x = x0, low_y = y1, high_y = y0;
    const double dx = (x1 - x0) / side, dy = (y1 - y0) / side;
    Batch rays;
    for (int first = 0; first < side * side; first += kLanes) {
      for (int i = 0; i < kLanes; ++i) {
        const int cell = first + i;
        beam.launch(rays, i, x0 + (cell % side + 0.5) * dx, y0 + (cell / side + 0.5) * dy);
      }
      beam.trace(rays);
      bundle.counts.add(rays);
      move_to_plane(rays, beam.sensor_z() + sensor_shift);
      for (int i = 0; i < kLanes; ++i) {
        if (rays.end[i] != 0) continue;
        const int cell = first + i;
        const double px = x0 + (cell % side + 0.5) * dx, py = y0 + (cell / side + 0.5) * dy;
        low_x = std::min(low_x, px), high_x = std::max(high_x, px);
        low_y = std::min(low_y, py), high_y = std::max(high_y, py);
        bundle.whole.add(rays.x[i], rays.y[i]);
        (rays.stop_x[i] < 0 ? bundle.left : bundle.right).add(rays.x[i], rays.y[i]);
        points.push_back({rays.x[i], rays.y[i]});
      }
    }
    bundle.area = bundle.whole.light * dx * dy;
    if (bundle.whole.light == 0) return bundle;
    x0 = low_x - 1.5 * dx, x1 = high_x + 1.5 * dx, y0 = low_y - 1.5 * dy, y1 = high_y + 1.5 * dy;
  }
  for (const auto& [x, y] : points) {
    bundle.radius = std::max(bundle.radius, std::hypot(x - bundle.whole.mean_x(), y - bundle.whole.mean_y()));
  }
  return bundle;
}

}  // namespace

std::vector<FieldAnalysis> analyse_fields(const Prescription& lens, double wavelength_nm,
                                          const std::vector<double>& theta_rad) {
  const Paraxial p = paraxial(lens);
  const double radius = 0.5 * p.entrance_pupil_diameter;
  std::vector<FieldAnalysis> fields(theta_rad.size());
  std::vector<double> area(theta_rad.size());
  tbb::parallel_for(std::size_t{0}, theta_rad.size(), [&](std::size_t k) {
    FieldAnalysis& f = fields[k];
    f.theta_rad = theta_rad[k];
    f.cos4 = std::pow(std::cos(f.theta_rad), 4);
    // the pupil walks: follow the chief ray out from the axis
    double guess[2] = {0, 0};
    RayBatch<double, 1> chief{};
    constexpr int kSteps = 16;
    for (int step = 1; step <= kSteps; ++step) {
      const Beam beam(lens, wavelength_nm, f.theta_rad * step / kSteps, false);
      f.reached = beam.through_stop(0, 0, radius, guess, chief);
      if (!f.reached) return;
    }
    const Beam beam(lens, wavelength_nm, f.theta_rad, false);
    f.chief_height = chief.y[0];
    const double ideal = p.focal_length * std::tan(f.theta_rad);
    f.distortion = ideal > 0 ? f.chief_height / ideal - 1 : 0;
    f.chief_angle_rad = std::atan2(std::abs(chief.m[0]), chief.n[0]);
    constexpr double kParabasal = 0.02;
    RayBatch<double, 1> up{}, down{}, side{};
    double g[3][2] = {{guess[0], guess[1]}, {guess[0], guess[1]}, {guess[0], guess[1]}};
    if (beam.through_stop(0, kParabasal, radius, g[0], up) && beam.through_stop(0, -kParabasal, radius, g[1], down)) {
      f.tangential_focus = -(up.y[0] - down.y[0]) / (up.m[0] / up.n[0] - down.m[0] / down.n[0]);
    }
    if (beam.through_stop(kParabasal, 0, radius, g[2], side)) f.sagittal_focus = -side.x[0] / (side.l[0] / side.n[0]);
    const Bundle bundle = trace_beam(beam, guess[0], guess[1], radius, 0);
    area[k] = bundle.area;
    f.centroid_height = bundle.whole.mean_y();
    f.spot_rms = bundle.whole.rms();
    f.spot_radius = bundle.radius;
    f.rays = bundle.counts;
  });
  const Beam axis(lens, wavelength_nm, 0, false);
  const double axis_area = trace_beam(axis, 0, 0, radius, 0).area;
  double reach = 1e-6;
  for (const FieldAnalysis& f : fields) reach = std::max(reach, f.chief_height);
  const PupilBounds bounds = find_pupil(lens, wavelength_nm, reach);
  for (std::size_t k = 0; k < fields.size(); ++k) {
    fields[k].pupil_fraction = axis_area > 0 ? area[k] / axis_area : 0;
    const double on_axis = bounds.nodes[0].pass_area;
    fields[k].relative_illumination =
        fields[k].reached && on_axis > 0 ? bounds.at(fields[k].chief_height).pass_area / on_axis : 0;
  }
  return fields;
}

HalfPupils analyse_halves(const Prescription& lens, double wavelength_nm, double theta_rad, bool along_split,
                          double sensor_shift_mm) {
  const double radius = 0.5 * paraxial(lens).entrance_pupil_diameter;
  double guess[2] = {0, 0};
  RayBatch<double, 1> chief{};
  constexpr int kSteps = 16;
  for (int step = 1; step <= kSteps; ++step) {
    if (!Beam(lens, wavelength_nm, theta_rad * step / kSteps, along_split).through_stop(0, 0, radius, guess, chief))
      return {};
  }
  const Bundle bundle =
      trace_beam(Beam(lens, wavelength_nm, theta_rad, along_split), guess[0], guess[1], radius, sensor_shift_mm);
  if (bundle.left.light == 0 || bundle.right.light == 0) return {};
  return {bundle.right.mean_x() - bundle.left.mean_x(), bundle.left.light / bundle.whole.light, bundle.whole.rms(),
          bundle.radius};
}

double naive_rear_efficiency(const Prescription& lens, double wavelength_nm) {
  const TracedLens<double> traced(lens, wavelength_nm);
  const double rear_z = traced.sensor_z_mm() - lens.surfaces.back().thickness_mm;
  const double radius = lens.surfaces.back().semi_diameter_mm;
  constexpr int kSide = 1024;
  std::uint64_t aimed = 0, passed = 0;
  Batch rays;
  for (int first = 0; first < kSide * kSide; first += kLanes) {
    bool inside[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const double x = (2.0 * ((first + i) % kSide) + 1) / kSide - 1, y = (2.0 * ((first + i) / kSide) + 1) / kSide - 1;
      inside[i] = x * x + y * y <= 1;
      const double dx = x * radius, dy = y * radius, dz = rear_z - traced.sensor_z_mm();
      const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
      rays.x[i] = rays.y[i] = 0, rays.z[i] = traced.sensor_z_mm();
      rays.l[i] = dx / length, rays.m[i] = dy / length, rays.n[i] = dz / length;
      rays.end[i] = 0;
    }
    traced.trace(rays);
    for (int i = 0; i < kLanes; ++i) {
      aimed += inside[i] ? 1 : 0;
      passed += inside[i] && rays.end[i] == 0 ? 1 : 0;
    }
  }
  return static_cast<double>(passed) / static_cast<double>(aimed);
}

}  // namespace dualpixel::simulator
