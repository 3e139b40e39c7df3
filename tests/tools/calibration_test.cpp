#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/sampling/hash.h"
#include "tests/capture/temporary_folder.h"
#include "tests/tools/run_program.h"
#include "tools/calibration_sweep.h"

namespace dualpixel::tools {
namespace {

using pipeline::kCalibrationColumns;
using pipeline::kCalibrationRows;

simulator::Simulation camera_with(const std::string& lens, int width_px = 2688, int height_px = 2016) {
  simulator::Simulation simulation;
  simulation.lens = simulator::read_lens_file(std::string(DUALPIXEL_SOURCE_DIR "/lens_models/") + lens + ".json", 1);
  simulation.sensor.width_px = width_px;
  simulation.sensor.height_px = height_px;
  if (simulation.lens.prescription) {
    simulation.sensor.pixel_pitch_um =
        2e3 * simulation.lens.prescription->image_radius_mm / std::hypot(width_px, height_px);
  }
  return simulation;
}

std::vector<pipeline::TargetMeasurement> measure_all(const FocusSweep& sweep, std::uint64_t seed) {
  std::vector<pipeline::TargetMeasurement> measurements;
  for (const double distance : sweep.target_distances_m()) {
    measurements.push_back(sweep.measure(distance, simulator::hash(seed, measurements.size())));
  }
  return measurements;
}

bool inside(int i, int j) {
  return std::abs(2.0 * i / (kCalibrationColumns - 1) - 1) <= 0.9 &&
         std::abs(2.0 * j / (kCalibrationRows - 1) - 1) <= 0.9;
}

/// RMS and share of the inner 90 % of the field within 2 % (slope) and 0.03 DP px (intercept) of the traced lens.
struct Agreement {
  double slope_rms = 0, intercept_rms_dp_px = 0, slope_within = 0, intercept_within = 0;
};
Agreement compare(const pipeline::FocusCalibration& lines, const FocusSweep& sweep) {
  const simulator::DisparityField field(sweep.lens());
  const simulator::SensorGrid& sensor = sweep.lens().sensor();
  Agreement a;
  double count = 0;
  for (int j = 0; j < kCalibrationRows; ++j) {
    for (int i = 0; i < kCalibrationColumns; ++i) {
      if (!inside(i, j)) continue;
      const simulator::DisparityCoefficients truth =
          field.at(static_cast<double>(i) / (kCalibrationColumns - 1) * sensor.width_px,
                   static_cast<double>(j) / (kCalibrationRows - 1) * sensor.height_px);
      const double slope = lines.slope_dp_px_m.at(i, j) / truth.slope_dp_px_m - 1;
      const double intercept = lines.intercept_dp_px.at(i, j) - truth.intercept_dp_px;
      a.slope_rms += slope * slope;
      a.intercept_rms_dp_px += intercept * intercept;
      a.slope_within += std::abs(slope) < 0.02;
      a.intercept_within += std::abs(intercept) < 0.03;
      ++count;
    }
  }
  return {std::sqrt(a.slope_rms / count), std::sqrt(a.intercept_rms_dp_px / count), a.slope_within / count,
          a.intercept_within / count};
}

TEST(CalibrationSweep, AThinLensHasTheClosedFormsLine) {
  const simulator::Simulation simulation = camera_with("phone_thin_4.4mm_f1.8", 1344, 1008);
  for (const double focus_m : {0.6, 3.0}) {
    const FocusSweep sweep(simulation, focus_m, {});
    const pipeline::Calibration calibration =
        pipeline::fit_calibration(describe_camera(simulation), measure_all(sweep, 1));
    const simulator::ThinLens& thin = sweep.lens().lens().thin;
    const double f = thin.focal_length_m, diameter = f / 1.8, alpha = 1 / (4 * 1.19);
    const double slope = -alpha * diameter * f / (1 - f / focus_m) / 2.8e-6;
    const pipeline::FocusCalibration& lines = calibration.focuses[0];
    double mean_slope = 0, mean_intercept = 0, count = 0;
    for (int j = 0; j < kCalibrationRows; ++j) {
      for (int i = 0; i < kCalibrationColumns; ++i) {
        if (!inside(i, j)) continue;
        mean_slope += lines.slope_dp_px_m.at(i, j);
        mean_intercept += lines.intercept_dp_px.at(i, j);
        ++count;
      }
    }
    EXPECT_NEAR(mean_slope / count / slope, 1, 0.01);
    EXPECT_NEAR(mean_intercept / count, -slope / focus_m, 0.01 * std::abs(slope / focus_m) + 0.003);
    EXPECT_GT(lines.r_squared.at(kCalibrationColumns / 2, kCalibrationRows / 2), 0.999);
    EXPECT_TRUE(calibration.warnings.empty());
  }
}

TEST(CalibrationSweep, FindsThatTheTargetIsTilted) {
  SweepOptions options;
  options.tilt_x_deg = 3;
  options.targets = 4;
  const simulator::Simulation simulation = camera_with("phone_thin_4.4mm_f1.8", 1344, 1008);
  const FocusSweep sweep(simulation, 0.6, options);
  const std::vector<pipeline::TargetMeasurement> measurements = measure_all(sweep, 1);
  const pipeline::Calibration calibration = pipeline::fit_calibration(describe_camera(simulation), measurements);
  EXPECT_EQ(calibration.warnings.size(), 1u);
  EXPECT_NEAR(pipeline::estimate_tilt(calibration.camera, calibration.focuses[0], measurements[0]).x_deg, 3, 1);
}

class CalibrationLens : public testing::TestWithParam<const char*> {};

TEST_P(CalibrationLens, AgreesWithTheTracedLens) {
  const simulator::Simulation simulation = camera_with(GetParam());
  for (const double focus_m : {0.5, 2.0}) {
    const FocusSweep sweep(simulation, focus_m, {});
    const pipeline::Calibration calibration =
        pipeline::fit_calibration(describe_camera(simulation), measure_all(sweep, 1));
    const Agreement a = compare(calibration.focuses[0], sweep);
    std::printf("%s, focus %g m: slope RMS %.4f, within 2 %%: %.3f; intercept RMS %.4f DP px, within 0.03: %.3f\n",
                GetParam(), focus_m, a.slope_rms, a.slope_within, a.intercept_rms_dp_px, a.intercept_within);
    EXPECT_LT(a.slope_rms, 0.02);
    EXPECT_LT(a.intercept_rms_dp_px, 0.03);
    EXPECT_GT(calibration.focuses[0].r_squared.at(kCalibrationColumns / 2, kCalibrationRows / 2), 0.999);
  }
}

TEST_P(CalibrationLens, MakesPlanesFlatAtDepthsAndFocusesThatTheSweepDidNotUse) {
  const simulator::Simulation simulation = camera_with(GetParam());
  // the two of twenty focus distances on either side of 0.75 m
  std::vector<pipeline::TargetMeasurement> measurements;
  for (const double per_m : {5 * 5.0 / 19, 6 * 5.0 / 19}) {
    const std::vector<pipeline::TargetMeasurement> more = measure_all(FocusSweep(simulation, 1 / per_m, {}), 2);
    measurements.insert(measurements.end(), more.begin(), more.end());
  }
  Camera camera = describe_camera(simulation);
  const pipeline::Calibration calibration = pipeline::fit_calibration(camera, measurements);
  const double focus_m = 0.69;
  camera.focus_distance_m = focus_m;
  const pipeline::Correction correction = make_correction(calibration, camera);
  EXPECT_EQ(correction.warning, "");
  const simulator::DisparityField field(FocusSweep(simulation, focus_m, {}).lens());
  for (const double depth_m : {0.45, 0.9, 2.2}) {
    // the lens's own disparity of the plane: no matcher, so no noise
    Image d(672, 252), confidence(672, 252, 1, 1.0f);
    for (int y = 0; y < d.height; ++y) {
      for (int x = 0; x < d.width; ++x) {
        const simulator::DisparityCoefficients c = field.at((x + 0.5) * 4, (y + 0.5) * 8);
        d.at(x, y) = static_cast<float>(c.slope_dp_px_m / depth_m + c.intercept_dp_px);
      }
    }
    const auto sigma = [](const Image& image) {
      double sum = 0, squares = 0, count = 0;
      for (int y = image.height / 20; y < image.height * 19 / 20; ++y) {
        for (int x = image.width / 20; x < image.width * 19 / 20; ++x) {
          sum += image.at(x, y), squares += image.at(x, y) * image.at(x, y), ++count;
        }
      }
      return std::sqrt(squares / count - sum / count * (sum / count));
    };
    const double before = sigma(d);
    correct_disparity(correction, d, confidence);
    std::printf("%s, plane at %g m: sigma %.4f, corrected %.4f DP px\n", GetParam(), depth_m, before, sigma(d));
    EXPECT_LT(sigma(d), 0.03);
    EXPECT_LT(sigma(d), before);
  }
}

INSTANTIATE_TEST_SUITE_P(Slow, CalibrationLens,
                         testing::Values("phone_aberrated_4.4mm_f1.8", "phone_6p_4.2mm_f1.8", "phone_7p_4.9mm_f1.85"));

const std::string kScene = std::string("'") + DUALPIXEL_SOURCE_DIR + "/scenes/calibration_target.json' ";
const std::string kSmall = "--focuses 2 --targets 3 --set sensor.width_px=448 --set sensor.height_px=336 ";

TEST(SlowCalibrateCommand, SweepsGoesOnWhereItWasAndIsDescribed) {
  const TemporaryFolder folder;
  const std::string out = folder / "calibration";
  const std::string command = "calibrate " + kScene + kSmall + "-o '" + out + "'";
  ASSERT_EQ(run_program(command).status, 0);
  const std::string whole = read_bytes(out + "/calibration.json");
  ASSERT_FALSE(whole.empty());
  // as if it had been interrupted
  std::filesystem::remove(out + "/calibration.json");
  std::filesystem::remove(out + "/measurements/focus_01_target_02.json");
  const auto kept = std::filesystem::last_write_time(out + "/measurements/focus_00_target_00.json");
  ASSERT_EQ(run_program(command).status, 0);
  EXPECT_TRUE(read_bytes(out + "/calibration.json") == whole);
  EXPECT_EQ(std::filesystem::last_write_time(out + "/measurements/focus_00_target_00.json"), kept);

  const Outcome info = run_program("info '" + out + "' --json -o '" + (folder / "page.html") + "'");
  EXPECT_EQ(info.status, 0) << info.err;
  EXPECT_NE(info.out.find("\"kind\": \"calibration\""), std::string::npos);
  EXPECT_NE(read_bytes(folder / "page.html").find("Disparity over inverse depth"), std::string::npos);

  expect_one_line_refusal(run_program(command + " --set lens.f_number=2.8"));
  expect_one_line_refusal(run_program("calibrate " + kScene + kSmall + "-o '" + folder.path.string() + "'"));
  expect_one_line_refusal(run_program("calibrate -o '" + (folder / "none") + "'"));
  expect_one_line_refusal(
      run_program("calibrate --captures '" + folder.path.string() + "' -o '" + (folder / "captured") + "'"));
  EXPECT_FALSE(std::filesystem::exists(folder / "captured"));
}

}  // namespace
}  // namespace dualpixel::tools
