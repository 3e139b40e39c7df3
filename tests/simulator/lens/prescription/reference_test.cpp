// Fourteen published lenses against what an independent tracer computed for them (tests/data/optics).
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/ray_trace.h"
#include "tests/simulator/lens/prescription/reference.h"

namespace dualpixel::simulator::testing {
namespace {

class Reference : public ::testing::TestWithParam<std::string> {
 protected:
  const nlohmann::json& figures = reference()["lenses"][GetParam()];
  Lens lens = reference_lens(figures);
};

TEST_P(Reference, Paraxial) {
  const Paraxial p = paraxial(*prescription_of(lens));
  const nlohmann::json& expected = figures["paraxial"];
  const auto expect = [&](const char* key, double ours) {
    const double theirs = expected[key];
    // nine digits are given; a distance of 0 (the pupil on the first vertex) is compared with the focal length
    EXPECT_NEAR(ours, theirs, 1e-6 * std::max(std::abs(theirs), 1e-3 * p.focal_length)) << key;
  };
  expect("efl", p.focal_length);
  expect("bfl", p.back_focus);
  expect("ffl", p.front_focus);
  expect("petzval_radius", p.petzval_radius);
  expect("z_ep", p.entrance_pupil_z);
  expect("ep_diam", p.entrance_pupil_diameter);
  expect("ep_mag", p.entrance_pupil_scale);
  expect("z_xp", p.exit_pupil_z);
  expect("xp_diam", p.exit_pupil_diameter);
  expect("xp_mag", p.exit_pupil_scale);
  expect("fno", p.f_number());
}

TEST_P(Reference, ExactRays) {
  const TracedLens<double> traced(*prescription_of(lens), figures["wavelength_nm"], false);
  EXPECT_NEAR(traced.sensor_z_mm(), figures["zsensor_from_first_vertex"].get<double>(), 1e-6);
  int checked = 0;
  for (const nlohmann::json& row : figures["rays"]) {
    if (!row["valid"].get<bool>()) {
      std::cout << GetParam() << ": skipped a ray that the reference marks as not valid: " << row.dump() << '\n';
      continue;
    }
    RayBatch<double, 1> ray{};
    ray.x[0] = row["launch_point"][0], ray.y[0] = row["launch_point"][1], ray.z[0] = row["launch_point"][2];
    ray.l[0] = row["launch_dir"][0], ray.m[0] = row["launch_dir"][1], ray.n[0] = row["launch_dir"][2];
    traced.trace(ray);
    ASSERT_EQ(ray.end[0], 0) << row.dump();
    move_to_plane(ray, traced.sensor_z_mm());
    EXPECT_NEAR(ray.x[0], row["sensor_xy"][0].get<double>(), 1e-6);
    EXPECT_NEAR(ray.y[0], row["sensor_xy"][1].get<double>(), 1e-6);
    EXPECT_NEAR(ray.l[0], row["sensor_dir"][0].get<double>(), 1e-7);
    EXPECT_NEAR(ray.m[0], row["sensor_dir"][1].get<double>(), 1e-7);
    EXPECT_NEAR(ray.n[0], row["sensor_dir"][2].get<double>(), 1e-7);
    ++checked;
  }
  EXPECT_GE(checked, 6);
}

INSTANTIATE_TEST_SUITE_P(All, Reference, ::testing::ValuesIn(lens_names()),
                         [](const auto& parameter) { return parameter.param; });

}  // namespace
}  // namespace dualpixel::simulator::testing
