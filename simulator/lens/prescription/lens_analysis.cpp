#include "simulator/lens/prescription/lens_analysis.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simulator/lens/prescription/beam.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"

namespace dualpixel::simulator {

std::vector<FieldAnalysis> analyze_fields(const Prescription& lens, double wavelength_nm,
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
      const Beam beam(lens, wavelength_nm, f.theta_rad * step / kSteps);
      f.reached = beam.through_stop(0, 0, radius, guess, chief);
      if (!f.reached) return;
    }
    const Beam beam(lens, wavelength_nm, f.theta_rad);
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
    const BeamTrace bundle = trace_beam(beam, guess[0], guess[1], radius);
    area[k] = bundle.area;
    f.centroid_height = bundle.spot.mean_y();
    f.spot_rms = bundle.spot.rms();
    f.spot_radius = bundle.radius;
    f.rays = bundle.counts;
  });
  const Beam axis(lens, wavelength_nm, 0);
  const double axis_area = trace_beam(axis, 0, 0, radius).area;
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

}  // namespace dualpixel::simulator
