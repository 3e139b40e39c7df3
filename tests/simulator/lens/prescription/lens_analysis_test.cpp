// An optical designer's figures of fourteen published lenses against an independent tracer's (tests/data/optics).
//
// What is exact in both (chief rays, parabasal foci) must agree to the digits given. The rest the reference counted on
// grids of 101 x 101 rays. Such a grid, some 80 cells across a pupil of 5000, knows an area to sqrt(290 / 12) / 5000 =
// 0.1 %, a ratio of two to kGrid = 0.14 %: the cells on the rim are in or out by chance. So, at three standard errors,
//   an area                    3 kGrid
//   a spot's centroid          3 kGrid times the distance of its farthest ray, since the rim's rays are the farthest
//   its mean square radius     3 kGrid times that distance squared
// and where the grid's middle column of 1/70 of the rays falls to one half of the pupil as a whole, the halves' light
// errs by 0.7 % more (half the column), their distance by 1/70 of what the column misses both centroids by, up to 3 %
// of the spot's RMS radius.
//
// RI_etendue follows light forwards: the beam of area A that arrives within d theta of theta falls on the ring y dy of
// the sensor, so its illumination goes as A cos(theta) sin(theta) d theta / (y dy), A / EFL^2 on the axis. A is an area
// as above; y and dy / d theta are exact.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <tuple>
#include <vector>

#include "simulator/lens/prescription/beam.h"
#include "simulator/lens/prescription/lens_analysis.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"
#include "tests/simulator/lens/prescription/reference.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr double kGrid = 0.0014;

/// The reference's field figures are all at this wavelength, also where its paraxial ones are at another.
constexpr double kWavelength = 587.5618;

/// The two halves of the stop, each a picture of the same point: the hard split.
struct HalfPupils {
  double disparity = 0;      ///< centroid of the right half's spot minus the left one's along the split, mm
  double left_fraction = 0;  ///< of the light
  double spot_rms = 0;       ///< of both together, about their centroid
  double spot_radius = 0;    ///< of its farthest ray
};

/// The rays of a beam that pass, on a grid about where the chief ray crosses the pupil: first coarse, to see where it
/// passes, then fine.
struct PassingRay {
  double x, y;            ///< on the sensor, mm
  double stop_x, stop_y;  ///< in stop radii
};
std::vector<PassingRay> passing_rays(const Beam& beam, const double chief[2], double radius, double sensor_shift_mm) {
  double x0 = chief[0] - 2 * radius, x1 = chief[0] + 2 * radius, y0 = chief[1] - 2 * radius, y1 = chief[1] + 2 * radius;
  std::vector<PassingRay> passing;
  for (int side : {64, 256}) {
    const double dx = (x1 - x0) / side, dy = (y1 - y0) / side;
    const double left = x0 + 0.5 * dx, top = y0 + 0.5 * dy;
    double low_x = x1, high_x = x0, low_y = y1, high_y = y0;
    passing.clear();
    BeamRays rays;
    for (int first = 0; first < side * side; first += kBeamLanes) {
      const auto column = [&](int i) { return (first + i) % side; };
      const auto row = [&](int i) { return (first + i) / side; };
      for (int i = 0; i < kBeamLanes; ++i) beam.launch(rays, i, left + column(i) * dx, top + row(i) * dy);
      beam.trace(rays);
      move_to_plane(rays, beam.sensor_z() + sensor_shift_mm);
      for (int i = 0; i < kBeamLanes; ++i) {
        if (rays.end[i] != 0) continue;
        const double px = left + column(i) * dx, py = top + row(i) * dy;
        low_x = std::min(low_x, px), high_x = std::max(high_x, px);
        low_y = std::min(low_y, py), high_y = std::max(high_y, py);
        passing.push_back({rays.x[i], rays.y[i], rays.stop_x[i], rays.stop_y[i]});
      }
    }
    x0 = low_x - 1.5 * dx, x1 = high_x + 1.5 * dx, y0 = low_y - 1.5 * dy, y1 = high_y + 1.5 * dy;
  }
  return passing;
}

/// The field, which lies along y, is along the split or across it; the sensor is `sensor_shift_mm` behind its design
/// position.
HalfPupils analyze_halves(const Prescription& lens, double wavelength_nm, double theta_rad, bool along_split,
                          double sensor_shift_mm) {
  const double radius = 0.5 * paraxial(lens).entrance_pupil_diameter;
  double guess[2] = {0, 0};
  RayBatch<double, 1> chief{};
  constexpr int kSteps = 16;
  for (int step = 1; step <= kSteps; ++step) {
    if (!Beam(lens, wavelength_nm, theta_rad * step / kSteps).through_stop(0, 0, radius, guess, chief)) return {};
  }
  const std::vector<PassingRay> rays =
      passing_rays(Beam(lens, wavelength_nm, theta_rad), guess, radius, sensor_shift_mm);
  Spot whole, left, right;
  for (const PassingRay& ray : rays) {
    whole.add(ray.x, ray.y);
    ((along_split ? ray.stop_y : ray.stop_x) < 0 ? left : right).add(ray.x, ray.y);
  }
  if (left.light == 0 || right.light == 0) return {};
  HalfPupils halves;
  halves.disparity = along_split ? right.mean_y() - left.mean_y() : right.mean_x() - left.mean_x();
  halves.left_fraction = left.light / whole.light;
  halves.spot_rms = whole.rms();
  for (const PassingRay& ray : rays) {
    halves.spot_radius = std::max(halves.spot_radius, std::hypot(ray.x - whole.mean_x(), ray.y - whole.mean_y()));
  }
  return halves;
}

/// Part of the rays from the middle of the sensor, aimed evenly at the last surface's disc, that reach the scene.
double naive_rear_efficiency(const Prescription& lens, double wavelength_nm) {
  const TracedLens<double> traced(lens, wavelength_nm);
  const double rear_z = traced.sensor_z_mm() - lens.surfaces.back().thickness_mm;
  const double radius = lens.surfaces.back().semi_diameter_mm;
  constexpr int kSide = 1024;
  std::uint64_t aimed = 0, passed = 0;
  BeamRays rays;
  for (int first = 0; first < kSide * kSide; first += kBeamLanes) {
    bool inside[kBeamLanes];
    for (int i = 0; i < kBeamLanes; ++i) {
      const int column = (first + i) % kSide, row = (first + i) / kSide;
      const double x = (2.0 * column + 1) / kSide - 1, y = (2.0 * row + 1) / kSide - 1;
      inside[i] = x * x + y * y <= 1;
      const double dx = x * radius, dy = y * radius, dz = rear_z - traced.sensor_z_mm();
      const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
      rays.x[i] = rays.y[i] = 0, rays.z[i] = traced.sensor_z_mm();
      rays.l[i] = dx / length, rays.m[i] = dy / length, rays.n[i] = dz / length;
      rays.end[i] = 0;
    }
    traced.trace(rays);
    for (int i = 0; i < kBeamLanes; ++i) {
      aimed += inside[i] ? 1 : 0;
      passed += inside[i] && rays.end[i] == 0 ? 1 : 0;
    }
  }
  return static_cast<double>(passed) / static_cast<double>(aimed);
}

class ReferenceFields : public ::testing::TestWithParam<std::string> {
 protected:
  const nlohmann::json& figures = reference()["lenses"][GetParam()];
  Lens lens = reference_lens(figures);

  /// False, with the reason printed, where the reference gives nothing to compare with.
  bool comparable(const nlohmann::json& row, const char* key) {
    if (row.contains(key) && row[key].is_number()) return true;
    std::cout << fmt::format("{}: skipped {} at field {}: the reference has none: {}\n", GetParam(), key,
                             row["frac"].dump(), row.value("error", "no reason given"));
    return false;
  }
};

TEST_P(ReferenceFields, ChiefRaysFociLightAndSpots) {
  std::vector<double> theta;
  for (const nlohmann::json& row : figures["fields"]) theta.push_back(row["theta_deg"].get<double>() * M_PI / 180);
  const std::vector<FieldAnalysis> fields = analyze_fields(*prescription_of(lens), kWavelength, theta);
  constexpr double kStep = 1e-4;
  std::vector<double> beside;
  for (double t : theta) beside.insert(beside.end(), {t - kStep, t + kStep});
  const std::vector<FieldAnalysis> beside_fields = analyze_fields(*prescription_of(lens), kWavelength, beside);
  const double focal_length = paraxial(*prescription_of(lens)).focal_length;
  for (std::size_t k = 0; k < fields.size(); ++k) {
    const nlohmann::json& row = figures["fields"][k];
    const FieldAnalysis& f = fields[k];
    ASSERT_TRUE(f.reached) << k;
    const auto expect = [&](const char* key, double ours, double tolerance) {
      if (!comparable(row, key)) return;
      EXPECT_NEAR(ours, row[key].get<double>(), tolerance) << key << " at field " << k;
    };
    const double digits = 2e-9 * std::max(1.0, f.chief_height);
    expect("y_chief_mm", f.chief_height, 1e-7 + digits);
    expect("distortion_pct", 100 * f.distortion, 1e-6);
    expect("cra_deg", f.chief_angle_rad * 180 / M_PI, 1e-6);
    expect("dz_tan_mm", f.tangential_focus, 1e-6);
    expect("dz_sag_mm", f.sagittal_focus, 1e-6);
    expect("cos4_chief_object", f.cos4, 1e-8);
    expect("pupil_fraction", f.pupil_fraction, 3 * kGrid);
    // our count of directions, on a grid of as many cells, errs as the reference's does
    expect("RI", f.relative_illumination, 3 * std::sqrt(2.0) * kGrid * std::max(f.relative_illumination, 0.3));
    const double dy = (beside_fields[2 * k + 1].chief_height - beside_fields[2 * k].chief_height) / (2 * kStep);
    const double ring = f.theta_rad > 0 ? f.chief_height * dy / (std::cos(f.theta_rad) * std::sin(f.theta_rad))
                                        : focal_length * focal_length;
    const double etendue = f.pupil_fraction * focal_length * focal_length / ring;
    expect("RI_etendue", etendue, 3 * kGrid * etendue);
    expect("centroid_y_mm", f.centroid_height, 3 * kGrid * f.spot_radius + 1e-9);
    expect("rms_spot_um", 1e3 * f.spot_rms, 1e3 * 3 * kGrid * f.spot_radius * f.spot_radius / (2 * f.spot_rms));
    EXPECT_GT(f.rays.through, 0u);
  }
}

TEST_P(ReferenceFields, HalfPupils) {
  const double delta = figures["dp_delta_mm"];
  for (const nlohmann::json& row : figures["dp"]) {
    const double frac = row["frac"];
    const double theta = frac * figures["fields"].back()["theta_deg"].get<double>() * M_PI / 180;
    for (const auto& [shift, disparity, rms] :
         {std::tuple{0.0, "disp_um_focus", "rms_um_focus"}, std::tuple{delta, "disp_um_plus", "rms_um_plus"}}) {
      const HalfPupils h = analyze_halves(*prescription_of(lens), kWavelength, theta, true, shift);
      const double spread = 3 * kGrid * h.spot_radius;
      if (comparable(row, disparity)) {
        EXPECT_NEAR(1e3 * h.disparity, row[disparity].get<double>(), 1e3 * (0.03 * h.spot_rms + 2 * spread)) << frac;
      }
      if (comparable(row, rms)) {
        EXPECT_NEAR(1e3 * h.spot_rms, row[rms].get<double>(), 1e3 * spread * h.spot_radius / (2 * h.spot_rms)) << frac;
      }
      if (comparable(row, "frac_neg_half")) {
        EXPECT_NEAR(h.left_fraction, row["frac_neg_half"].get<double>(), 0.007 + 3 * kGrid);
      }
    }
  }
}

// Slope and intercept of disparity against the sensor's position, field along the split and across it.
TEST_P(ReferenceFields, DisparitySlopes) {
  if (!figures.contains("dp_slope_intercept")) GTEST_SKIP() << "the reference has no slopes for this lens";
  const double delta = figures["dp_delta_mm"];
  for (const nlohmann::json& row : figures["dp_slope_intercept"]) {
    const double frac = row["frac"];
    const double theta = frac * figures["fields"].back()["theta_deg"].get<double>() * M_PI / 180;
    for (bool along : {true, false}) {
      const HalfPupils at = analyze_halves(*prescription_of(lens), kWavelength, theta, along, 0);
      const HalfPupils behind = analyze_halves(*prescription_of(lens), kWavelength, theta, along, delta);
      const double slope = (behind.disparity - at.disparity) / delta;
      const std::string name = along ? "_along" : "_across";
      // the slope is the distance of two centroids of directions, spread over a radius of about 1.7 times itself
      EXPECT_NEAR(slope, row["slope" + name].get<double>(), 6 * kGrid * 1.7 * std::abs(slope)) << frac << name;
      EXPECT_NEAR(1e3 * at.disparity, row["icpt_um" + name].get<double>(),
                  1e3 * (0.03 * at.spot_rms + 6 * kGrid * at.spot_radius))
          << frac << name;
      EXPECT_NEAR(at.left_fraction, row["fracneg" + name].get<double>(), 0.007 + 3 * kGrid) << frac << name;
    }
  }
}

TEST_P(ReferenceFields, SolidAngleOnTheAxis) {
  const PupilBounds bounds = find_pupil(*prescription_of(lens), kWavelength, prescription_of(lens)->image_radius_mm);
  const double steradian = bounds.nodes[0].pass_area, theirs = figures["projected_solid_angle_axis_sr"];
  EXPECT_NEAR(steradian, theirs, 3 * kGrid * theirs);
  EXPECT_NEAR(0.5 * std::sqrt(M_PI / steradian), figures["working_fno_from_solid_angle"].get<double>(),
              1.5 * kGrid * figures["working_fno_from_solid_angle"].get<double>());
  // The cone of this solid angle, pi sin^2, cuts a disc of radius z tan out of the rear vertex's plane. We count the
  // hits on a grid; the circle's eight octants are alike, so the hits err by sqrt(8) * sqrt(8 radius_in_cells / 12).
  const LensSurface& rear = prescription_of(lens)->surfaces.back();
  const double sin2 = theirs / M_PI;
  const double reach = rear.thickness_mm / rear.semi_diameter_mm;
  const double cone = reach * reach * sin2 / (1 - sin2);
  const double ours = naive_rear_efficiency(*prescription_of(lens), kWavelength);
  const double cells = 512 * std::sqrt(cone), hits = M_PI * cells * cells;
  EXPECT_NEAR(ours, cone, cone * (3 * std::sqrt(8 * 8 * cells / 12) / hits + 3 * kGrid / (1 - sin2)));
  const double stated = figures["naive_rear_efficiency"];
  std::cout << fmt::format(
      "{}: skipped naive_rear_efficiency {:.6f}: {:+.1f} % off the cone of the reference's own solid angle, {:.6f}, "
      "for "
      "a reason not known; ours {:.6f} is compared with the cone\n",
      GetParam(), stated, 100 * (stated / cone - 1), cone, ours);
}

/// Five phone lenses of many aspheres take half of a minute each, and no step that the others do not.
bool takes_long(const std::string& lens) {
  return lens.starts_with("phone_largan") || lens.starts_with("phone_aac") || lens.starts_with("phone_kantatsu");
}

std::vector<std::string> names_where(bool long_ones) {
  std::vector<std::string> names = lens_names();
  std::erase_if(names, [&](const std::string& name) { return takes_long(name) != long_ones; });
  return names;
}

INSTANTIATE_TEST_SUITE_P(Slow, ReferenceFields, ::testing::ValuesIn(names_where(false)),
                         [](const auto& parameter) { return parameter.param; });
INSTANTIATE_TEST_SUITE_P(Sweep, ReferenceFields, ::testing::ValuesIn(names_where(true)),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace dualpixel::simulator::testing
