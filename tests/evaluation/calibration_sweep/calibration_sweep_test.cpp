#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/image/resample.h"
#include "evaluation/calibration_sweep/calibration_remainder.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/experiments/aberrations_experiment.h"
#include "evaluation/report/calibration_page.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/calibration/nodes.h"
#include "pipeline/calibration/tilt.h"
#include "pipeline/portrait/run_portrait.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/sampling/hash.h"
#include "tests/evaluation/calibration_sweep/camera_with.h"
#include "tests/evaluation/calibration_sweep/target_wall.h"
#include "tests/run_program.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::kCalibrationColumns;
using pipeline::kCalibrationRows;

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

TEST(SlowCalibrationSweep, AThinLensHasTheClosedFormsLine) {
  const simulator::Simulation simulation = camera_with("phone_thin_4.4mm_f1.8", 1344, 1008);
  for (const double focus_m : {0.6, 3.0}) {
    const FocusSweep sweep(simulation, focus_m, {});
    const pipeline::Calibration calibration =
        pipeline::fit_calibration(describe_camera(simulation), measure_all(sweep, 1));
    const simulator::ThinLens& thin = sweep.lens().lens().thin;
    const double f = thin.focal_length_m, diameter = f / 1.8, alpha = 1 / (4 * 1.19);
    const double slope = -alpha * diameter * f / (1 - f / focus_m) / 2.8e-6;
    const pipeline::FocusCalibration& lines = calibration.focuses[0];
    double mean_slope = 0, mean_intercept = 0, squares = 0, worst = 0, count = 0;
    for (int j = 0; j < kCalibrationRows; ++j) {
      for (int i = 0; i < kCalibrationColumns; ++i) {
        if (!inside(i, j)) continue;
        mean_slope += lines.slope_dp_px_m.at(i, j);
        mean_intercept += lines.intercept_dp_px.at(i, j);
        squares += std::pow(lines.slope_dp_px_m.at(i, j) / slope - 1, 2);
        worst = std::max(worst, std::abs(lines.slope_dp_px_m.at(i, j) / slope - 1));
        ++count;
      }
    }
    std::printf("thin lens, focus %g m: slope RMS error %.4f, worst position %.4f\n", focus_m,
                std::sqrt(squares / count), worst);
    EXPECT_NEAR(mean_slope / count / slope, 1, 0.01);
    EXPECT_LT(std::sqrt(squares / count), 0.01);
    EXPECT_NEAR(mean_intercept / count, -slope / focus_m, 0.01 * std::abs(slope / focus_m) + 0.003);
    EXPECT_GT(lines.r_squared, 0.999);
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
  // of views of 672 DP px, nodes at the border hold many blocks that lack neighbors to be matched by
  for (const pipeline::TargetMeasurement& m : measurements) {
    EXPECT_EQ(std::count(m.usable.data.begin(), m.usable.data.end(), 1.0f), kCalibrationColumns * kCalibrationRows);
  }
  const pipeline::TargetTilt tilt = pipeline::estimate_tilt(calibration.camera, measurements);
  EXPECT_NEAR(tilt.x_deg, 3, 0.3);
  EXPECT_LT(tilt.x_error_deg, 0.3);
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
    // the RMS hides no few large errors: of normal errors with this root mean square 68 % lie within
    EXPECT_GT(a.slope_within, 0.68);
    EXPECT_GT(a.intercept_within, 0.95);  // readings by planes left 91 % behind the 7p
    EXPECT_GT(calibration.focuses[0].r_squared, 0.999);
  }
}

TEST_P(CalibrationLens, MakesPlanesFlatAtDepthsAndFocusesThatTheSweepDidNotUse) {
  const simulator::Simulation simulation = camera_with(GetParam());
  // the two of twenty focus distances on either side of 0.69 m
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

/// Root mean square error of the confident matches, near the axis and far from it (r = 1 in the corners).
struct FieldError {
  double center = 0, periphery = 0;
};
FieldError field_error(const pipeline::PortraitResult& result, const Image& wanted) {
  FieldError squares, count;
  const Image& d = result.matched_disparity_dp_px;
  for (int y = d.height / 20; y < d.height * 19 / 20; ++y) {
    for (int x = d.width / 20; x < d.width * 19 / 20; ++x) {
      if (result.matched_confidence.at(x, y) < 0.5f) continue;
      const double u = 2 * (x + 0.5) / d.width - 1, v = 2 * (y + 0.5) / d.height - 1;
      const double r = std::hypot(4 * u, 3 * v) / 5, error = std::pow(d.at(x, y) - wanted.at(x, y), 2);
      if (r < 0.4) squares.center += error, ++count.center;
      if (r > 0.7) squares.periphery += error, ++count.periphery;
    }
  }
  return {std::sqrt(squares.center / count.center), std::sqrt(squares.periphery / count.periphery)};
}

class CalibratedScene : public testing::TestWithParam<const char*> {};

// A wall that runs away to the right, rendered in full, exposed, matched and corrected, with a texture of its own.
TEST_P(CalibratedScene, HasAnErrorAtThePeripheryLikeTheCenters) {
  simulator::Simulation simulation = camera_with(GetParam());
  const double focus_m = 0.69;
  std::vector<pipeline::TargetMeasurement> measurements;
  for (const double per_m : {5 * 5.0 / 19, 6 * 5.0 / 19}) {
    const std::vector<pipeline::TargetMeasurement> more = measure_all(FocusSweep(simulation, 1 / per_m, {}), 2);
    measurements.insert(measurements.end(), more.begin(), more.end());
  }
  const simulator::LensSampler lens = focused_lens(simulation, focus_m);
  const CalibrationTarget wall{0.7, 30, 77, 16};
  simulation.lens = lens.lens();
  simulation.burst_frames = 4;
  simulation.render.samples_per_pixel = 256;  // both views share their noise, which few samples let draw matches to 0
  simulation.photograph_samples_per_pixel = simulation.all_in_focus_samples_per_pixel = 1;
  const Capture capture = simulate(simulation, target_wall(wall, print_target(wall, lens)));
  const simulator::DisparityCoefficients axis =
      simulator::trace_disparity(lens, simulation.sensor.width_px / 2, simulation.sensor.height_px / 2);
  Image wanted = capture.truth->depth_m;
  for (float& value : wanted.data) value = static_cast<float>(axis.slope_dp_px_m / value + axis.intercept_dp_px);
  wanted = resize_area(wanted, capture.camera.dp_width(), capture.camera.dp_height());
  pipeline::PortraitOptions options;
  const FieldError before = field_error(run_portrait(capture, options), wanted);
  options.calibration = pipeline::fit_calibration(capture.camera, measurements);
  const FieldError after = field_error(run_portrait(capture, options), wanted);
  std::printf("%s, RMS error of disparity: center %.4f, periphery %.4f; corrected %.4f, %.4f DP px\n", GetParam(),
              before.center, before.periphery, after.center, after.periphery);
  EXPECT_LT(after.periphery, before.periphery);
  EXPECT_LT(after.periphery, 1.1 * after.center);
}

constexpr const char* kLenses[] = {"phone_aberrated_4.4mm_f1.8", "phone_6p_4.2mm_f1.8", "phone_7p_4.9mm_f1.85"};
INSTANTIATE_TEST_SUITE_P(Slow, CalibrationLens, testing::Values(kLenses[0], kLenses[1]));
INSTANTIATE_TEST_SUITE_P(Sweep, CalibrationLens, testing::Values(kLenses[2]));
INSTANTIATE_TEST_SUITE_P(Sweep, CalibratedScene, testing::ValuesIn(kLenses));

/// Half the photosites along each side, on the same sensor.
simulator::Simulation small_camera(const std::string& lens) {
  simulator::Simulation simulation = camera_with(lens, 1344, 1008);
  simulation.sensor.pixel_pitch_um = 2.8;
  return simulation;
}

// The sweep's renderer casts few rays, spread over whole blocks, and takes the shading from a fit. The real one,
// through the same lens and with the same print, must give the same disparity. Their
// difference varies over the field by 0.0064 with 256 samples a photosite, by 0.012 with 64.
void expect_target_as_rendered(double distance_m) {
  simulator::Simulation simulation = small_camera("phone_aberrated_4.4mm_f1.8");
  const FocusSweep sweep(simulation, 0.6, {});
  simulation.lens = sweep.lens().lens();
  const pipeline::TargetMeasurement blocks = sweep.measure(distance_m, 9);
  const CalibrationTarget target{distance_m, 0, 9, 32};
  const simulator::Scene scene = target_wall(target, print_target(target, sweep.lens()));
  const simulator::RenderScene world(scene);
  simulator::RenderOptions options;
  options.samples_per_pixel = 256;
  const simulator::Views views = render_views(world, place_camera(simulation, scene), options);
  const auto reduced = [](const Image& view) {
    Image dp(view.width / 2, view.height / 4);
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) {
        if ((x + y) % 2 == 1) dp.at(x / 2, y / 4) += view.at(x, y, 1) / 4;  // green photosites of RGGB
      }
    }
    return dp;
  };
  const pipeline::TargetMeasurement rendered =
      pipeline::measure_target(reduced(views.left), reduced(views.right), 0.6, distance_m);
  double sum = 0, squares = 0, count = 0;
  for (int j = 0; j < kCalibrationRows; ++j) {
    for (int i = 0; i < kCalibrationColumns; ++i) {
      if (!inside(i, j)) continue;
      const double difference = rendered.disparity_dp_px.at(i, j) - blocks.disparity_dp_px.at(i, j);
      sum += difference, squares += difference * difference, ++count;
    }
  }
  std::printf("target at %g m: rendered less block-rendered, mean %.4f, RMS %.4f DP px\n", distance_m, sum / count,
              std::sqrt(squares / count));
  EXPECT_LT(std::abs(sum / count), 0.003);
  EXPECT_LT(std::sqrt(squares / count), 0.01);
}

TEST(SlowCalibrationTarget, LooksAsTheRendererSeesIt) { expect_target_as_rendered(0.4); }

TEST(SweepCalibrationTarget, LooksAsTheRendererSeesItBehindTheFocus) { expect_target_as_rendered(1.2); }

// Sweeps end at 0.2 m; a camera that is focused there or nearer is calibrated all the same. The sweep's own tests bound
// what a correction leaves by less than a quarter of what this lens does farther away.
TEST(SlowAberrations, AreCalibratedWhereASweepEndsAndNearer) {
  for (const double focus_m : {0.2, 0.15}) {
    simulator::Simulation simulation = small_camera("phone_aberrated_4.4mm_f1.8");
    simulation.lens = simulator::refocused(simulation.lens, focus_m);
    const AberratedField f = measure_aberrated_field(simulation);
    EXPECT_DOUBLE_EQ(f.focus_distance_m, focus_m);
    std::printf("focus %.2f m: deviation %.4f, calibrated %.4f DP px\n", focus_m, f.before_sigma_dp_px,
                f.after_sigma_dp_px);
    EXPECT_LT(f.after_sigma_dp_px, 0.25 * f.before_sigma_dp_px) << focus_m;
  }
}

TEST(SlowAberrations, InterpolationIsNotWhatLimitsThem) {
  const std::vector<CalibrationRemainder> left =
      measure_remainders(camera_with("phone_aberrated_4.4mm_f1.8", 1344, 1008), 3);
  ASSERT_EQ(left.size(), 6u);
  const double grid = left[0].sigma_dp_px, focus = left[1].sigma_dp_px, targets = left[2].sigma_dp_px;
  EXPECT_NEAR(focus, grid, 0.1 * grid);  // lines are nearly linear in 1/z: correction.h
  EXPECT_GT(targets, 2 * grid);
  for (std::size_t i = 3; i < 6; ++i) EXPECT_GT(left[i].sigma_dp_px, targets) << left[i].cause;
}

TEST(SlowAberrations, NothingIsMatchedAtInfinityOrOnAFewPixels) {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto matching = [](int width_px, double plane_m) {
    return measure_remainders(camera_with("phone_thin_4.4mm_f1.8", width_px, width_px * 3 / 4), plane_m)[5].sigma_dp_px;
  };
  EXPECT_TRUE(std::isnan(matching(1344, infinity)));
  EXPECT_TRUE(std::isnan(matching(256, 3)));
}

// A thin lens has one disparity and no vignetting; what the sweep leaves is under the traced lenses' .03 DP px.
TEST(SlowAberrations, OfAThinLensAreNone) {
  simulator::Simulation simulation = small_camera("phone_thin_4.4mm_f1.8");
  simulation.lens = simulator::refocused(simulation.lens, 0.6);
  const AberratedField f = measure_aberrated_field(simulation);
  EXPECT_LT(f.before_sigma_dp_px, 1e-3);
  EXPECT_LT(f.after_sigma_dp_px, 0.03);
  EXPECT_EQ(*std::min_element(f.light.data.begin(), f.light.data.end()), 1);
  EXPECT_NEAR(f.left_share.at(3, 3), 0.5, 1e-3);
}

/// Deviation over the field of a plane's matched disparity, means over an eighth of the width: noise averages out.
double spread_of_plane(const Capture& capture, const pipeline::PortraitOptions& options) {
  const Image d = resize_area(run_portrait(capture, options).matched_disparity_dp_px, 10, 8);
  double sum = 0, squares = 0, count = 0;
  for (int y = 1; y < 7; ++y) {
    for (int x = 1; x < 9; ++x) sum += d.at(x, y), squares += d.at(x, y) * d.at(x, y), ++count;
  }
  return std::sqrt(std::max(squares / count - sum / count * (sum / count), 0.0));
}

Capture photograph(simulator::Simulation simulation, double focus_m, const CalibrationTarget& target) {
  const simulator::LensSampler lens = focused_lens(simulation, focus_m);
  simulation.lens = lens.lens();
  simulation.burst_frames = 4;
  simulation.render.samples_per_pixel = 48;
  simulation.photograph_samples_per_pixel = simulation.all_in_focus_samples_per_pixel = 1;
  return simulate(simulation, target_wall(target, print_target(target, lens)));
}

// A user's photographs of a target, from captures on disk to a portrait's disparity.
TEST(SlowCalibrateCommand, CalibratesFromCapturesWhatPortraitThenCorrects) {
  const TemporaryFolder folder;
  const simulator::Simulation simulation = small_camera("phone_aberrated_4.4mm_f1.8");
  nlohmann::json list = nlohmann::json::array();
  for (const double focus_m : {1.0, 0.5}) {
    for (const double target_m : {0.3, 0.45, 0.8, 2.0}) {
      const std::string name = "target_" + std::to_string(list.size());
      write_capture(photograph(simulation, focus_m, {target_m, 0, list.size(), 16}), folder / name);
      list.push_back({{"capture", name}, {"target_distance_m", target_m}});
    }
  }
  write_bytes(folder / "distances.json", nlohmann::json{{"captures", list}}.dump());
  const std::string calibration = folder / "calibration";
  const Outcome made = run_program("calibrate --captures '" + folder.path.string() + "' -o '" + calibration + "'");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.err, "");

  const Capture capture = photograph(simulation, 0.7, {0.6, 0, 50, 16});
  write_capture(capture, folder / "capture");
  const Outcome portrait = run_program("portrait '" + (folder / "capture") + "' -o '" + (folder / "portrait") +
                                       "' --calibration '" + calibration + "'");
  EXPECT_EQ(portrait.status, 0) << portrait.err;
  pipeline::PortraitOptions options;
  const double before = spread_of_plane(capture, options);
  options.calibration = read_calibration_folder(calibration);
  const double after = spread_of_plane(capture, options);
  std::printf("plane, calibrated from captures: sigma %.4f, corrected %.4f DP px\n", before, after);
  EXPECT_LT(after, 0.03);
  EXPECT_LT(after, before);

  // a calibration from photographs is no sweep to resume
  expect_one_line_refusal(
      run_program("calibrate '" DUALPIXEL_SCENES_DIR "/calibration_target.json' -o '" + calibration + "'"));
}

const std::string kScene = std::string("'") + DUALPIXEL_SCENES_DIR + "/calibration_target.json' ";
const std::string kSmall = "--focuses 2 --targets 3 --set sensor.width_px=448 --set sensor.height_px=336 ";

TEST(SlowCalibrateCommand, SweepsGoesOnWhereItWasAndIsDescribed) {
  const TemporaryFolder folder;
  const std::string out = folder / "calibration";
  const std::string command = "calibrate " + kScene + kSmall + "-o '" + out + "'";
  std::filesystem::create_directory(out);
  write_bytes(out + "/.dualpixel-1-0.tmp", "{");  // of a run that was killed as it began
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
  expect_one_line_refusal(run_program(command + " --set sensor.dp_downsample_y=2"));
  // nothing depends on where the scene focuses
  EXPECT_EQ(run_program(command + " --set camera.focus_distance_m=0.5").status, 0);
  expect_one_line_refusal(run_program("calibrate " + kScene + kSmall + "-o '" + folder.path.string() + "'"));
  expect_one_line_refusal(run_program("calibrate -o '" + (folder / "none") + "'"));
  expect_one_line_refusal(
      run_program("calibrate --captures '" + folder.path.string() + "' -o '" + (folder / "captured") + "'"));
  EXPECT_FALSE(std::filesystem::exists(folder / "captured"));
}

TEST(SlowCalibrateCommand, RefusesBeforeTheWork) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  // nearer than the lens can focus
  expect_one_line_refusal(run_program("calibrate " + kScene + "--nearest-focus-m 0.05 --set lens.focal_length_mm=60 " +
                                      "-o '" + out + "'"));
  const Outcome ignored =
      run_program("calibrate --captures '" + folder.path.string() + "' --focuses 5 -o '" + out + "'");
  EXPECT_NE(ignored.status, 0);
  EXPECT_NE(ignored.err.find("--focuses"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace dualpixel::evaluation
