#include "pipeline/calibration/calibration.h"
#include "pipeline/calibration/flow.h"
#include "pipeline/calibration/nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "capture/error.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/calibration/tilt.h"
#include "tests/pipeline/texture.h"
#include "tests/temporary_folder.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kColumns = kCalibrationColumns, kRows = kCalibrationRows;

Camera test_camera() {
  Camera camera;
  camera.name = "test";
  camera.width_px = 2688;
  camera.height_px = 2016;
  camera.pixel_pitch_um = 1.4;
  camera.dp_downsample_y = 4;
  camera.focal_length_mm = 4.4;
  camera.f_number = 1.8;
  camera.focus_distance_m = 0.8;
  camera.principal_point_px = {1344, 1008};
  return camera;
}

/// A lens by formula, u and v from -1 to 1 over the picture: even slope, an intercept that a thin lens would have,
/// bent.
double slope_at(double u, double v) { return -0.8 * (1 - 0.2 * u * u + 0.1 * v * v); }
double intercept_at(double u, double v, double focus_m) { return 0.8 / focus_m + 0.3 * u * u - 0.1 * u * v; }

TargetMeasurement measurement(double focus_m, double target_m, double tilt_x_deg = 0) {
  TargetMeasurement m{focus_m, target_m, Image(kColumns, kRows), Image(kColumns, kRows, 1, 1.0f)};
  const double half_field = 1344 * 1.4e-3 / (4.4 / (1 - 4.4e-3 / focus_m));  // slope of the chief ray at u = 1
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const double u = 2.0 * i / (kColumns - 1) - 1, v = 2.0 * j / (kRows - 1) - 1;
      // z = D + x tan(tilt) and x = u half_field z: 1/z is linear in u
      const double inverse = (1 - std::tan(tilt_x_deg * std::numbers::pi / 180) * u * half_field) / target_m;
      m.disparity_dp_px.at(i, j) = static_cast<float>(slope_at(u, v) * inverse + intercept_at(u, v, focus_m));
    }
  }
  return m;
}

std::vector<TargetMeasurement> sweep(const std::vector<double>& focuses_m, double tilt_x_deg = 0) {
  std::vector<TargetMeasurement> measurements;
  for (const double focus : focuses_m) {
    for (const double target : {0.25, 0.4, 1.0, 2.5}) measurements.push_back(measurement(focus, target, tilt_x_deg));
  }
  return measurements;
}

std::string refusal_of(const std::vector<TargetMeasurement>& measurements) {
  return message_of<InputError>([&] { fit_calibration(test_camera(), measurements); });
}

TEST(CalibrationFlow, FindsASmoothFieldUnderShadingThatDiffersBetweenTheViews) {
  const int width = 672, height = 252;
  const Texture texture(3, 1.0 / 32);
  // right(x + d) = left(x) with d = shift + stretch (x - middle): right(x) = left at x' where x' + d(x') = x
  const double shift = 0.9, stretch = 0.002, middle = width / 2.0;
  Image left = texture.raster(width, height, 0.5, 1, 0.5, 1);
  const double first = (0.5 - shift + stretch * middle) / (1 + stretch);
  Image right = texture.raster(width, height, first, 1 / (1 + stretch), 0.5, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = 2 * (x + 0.5) / width - 1;
      left.at(x, y) = static_cast<float>((0.5 + 0.2 * left.at(x, y)) * (0.5 - 0.2 * u * u + 0.05 * u));
      right.at(x, y) = static_cast<float>((0.5 + 0.2 * right.at(x, y)) * (0.5 - 0.2 * u * u - 0.05 * u));
    }
  }
  const Flow flow = match_target(left, right);
  double square = 0, count = 0;
  for (int y = flow.disparity_dp_px.height / 20; y < flow.disparity_dp_px.height * 19 / 20; ++y) {
    for (int x = flow.disparity_dp_px.width / 20; x < flow.disparity_dp_px.width * 19 / 20; ++x) {
      const double at = (x + 0.5) * width / flow.disparity_dp_px.width;
      square += std::pow(flow.disparity_dp_px.at(x, y) - (shift + stretch * (at - middle)), 2);
      ++count;
      EXPECT_LT(flow.mismatch.at(x, y), 0.05);
    }
  }
  // The views' ratio falls from 1 to 0.71: 0.1 % of light that is left in it reads as 0.03 DP px on this texture.
  EXPECT_LT(std::sqrt(square / count), 0.03);
}

TEST(CalibrationFlow, ViewsWithoutTextureAreFiniteAndMatchNowhere) {
  const Flow flow = match_target(Image(336, 126, 1, 0.5f), Image(336, 126, 1, 0.4f));
  for (const float d : flow.disparity_dp_px.data) ASSERT_TRUE(std::isfinite(d));
  for (const float mismatch : flow.mismatch.data) ASSERT_EQ(mismatch, 2);
}

TEST(CalibrationFlow, RefusesWhatItCannotMatch) {
  const Image view(64, 32, 1, 0.5f);
  EXPECT_THROW(match_target(view, Image(64, 31, 1, 0.5f)), InputError);
  EXPECT_THROW(match_target(Image(), Image()), InputError);
  EXPECT_THROW(match_target(Image(64, 32, 3), Image(64, 32, 3)), InputError);
  for (int FlowOptions::*field : {&FlowOptions::block_width_px, &FlowOptions::block_height_px, &FlowOptions::warps,
                                  &FlowOptions::refinements, &FlowOptions::sweeps}) {
    FlowOptions options;
    options.*field = 0;
    EXPECT_THROW(match_target(view, view, options), InputError);
  }
}

TEST(Calibration, AMeasurementOfViewsOfOnePixelIsFinite) {
  const TargetMeasurement m = measure_target(Image(1, 1, 1, 0.5f), Image(1, 1, 1, 0.5f), 1, 1);
  for (const float d : m.disparity_dp_px.data) ASSERT_TRUE(std::isfinite(d));
  for (const float usable : m.usable.data) ASSERT_EQ(usable, 0);
}

// At one field position the targets all say a slope that is 0.1 more. Smoothing spreads that over the positions around,
// and loses none of it; the position's line still goes through the middle of its own targets.
TEST(Calibration, AveragesSlopesOverTheFieldButNotWhatTargetsSaw) {
  constexpr int kColumn = 8, kRow = 6;  // so far from the border that every window that holds it is whole
  std::vector<TargetMeasurement> measurements = sweep({0.5});
  const Calibration even = fit_calibration(test_camera(), measurements);
  double middle_per_m = 0;
  for (TargetMeasurement& m : measurements) {
    m.disparity_dp_px.at(kColumn, kRow) += static_cast<float>(0.1 / m.target_distance_m);
    middle_per_m += 1 / m.target_distance_m / static_cast<double>(measurements.size());
  }
  const Calibration other = fit_calibration(test_camera(), measurements);
  const FocusCalibration& bumped = other.focuses[0];
  const FocusCalibration& before = even.focuses[0];
  double sum = 0;
  for (std::size_t i = 0; i < bumped.slope_dp_px_m.data.size(); ++i) {
    sum += bumped.slope_dp_px_m.data[i] - before.slope_dp_px_m.data[i];
  }
  EXPECT_NEAR(sum, 0.1, 1e-4);
  const double slope = bumped.slope_dp_px_m.at(kColumn, kRow) - before.slope_dp_px_m.at(kColumn, kRow);
  const double intercept = bumped.intercept_dp_px.at(kColumn, kRow) - before.intercept_dp_px.at(kColumn, kRow);
  // What a quadratic surface under tent weights, three nodes to either side, keeps of its middle: 1 / (S - 2 Sxx^2 /
  // (Sxxxx + Sxxyy)) of the weights' moments S = 9, Sxx = 4/3, Sxxxx = 4/9, Sxxyy = 16/81.
  EXPECT_NEAR(slope, 0.1 * 13 / 45, 2e-5);
  EXPECT_NEAR(intercept + slope * middle_per_m, 0.1 * middle_per_m, 1e-4);
}

TEST(Calibration, RecoversExactLines) {
  const Calibration calibration = fit_calibration(test_camera(), sweep({0.5, kInfinity, 1.5}));
  ASSERT_EQ(calibration.focuses.size(), 3u);
  EXPECT_EQ(calibration.focuses[0].focus_distance_m, kInfinity);
  EXPECT_EQ(calibration.focuses[2].focus_distance_m, 0.5);
  EXPECT_TRUE(calibration.warnings.empty());
  for (const FocusCalibration& focus : calibration.focuses) {
    for (const auto& [i, j] : {std::pair{0, 0}, {10, 7}, {16, 2}, {20, 14}}) {
      const double u = 2.0 * i / (kColumns - 1) - 1, v = 2.0 * j / (kRows - 1) - 1;
      EXPECT_NEAR(focus.slope_dp_px_m.at(i, j), slope_at(u, v), 1e-5);
      EXPECT_NEAR(focus.intercept_dp_px.at(i, j), intercept_at(u, v, focus.focus_distance_m), 1e-5);
      EXPECT_NEAR(focus.residual_dp_px.at(i, j), 0, 1e-5);
    }
    EXPECT_NEAR(focus.r_squared, 1, 1e-5);
  }
}

TEST(Calibration, RefusesWhatGivesNoLine) {
  EXPECT_EQ(refusal_of({measurement(1, 0.5), measurement(1, 0.5), measurement(1, 1)}),
            "calibration: focus distance 1 m: 2 target distances: a line needs at least 3");
  EXPECT_EQ(refusal_of({measurement(1, 0.99), measurement(1, 1), measurement(1, 1.02)}),
            "calibration: focus distance 1 m: targets from 0.99 m to 1.02 m: too close together; their inverses must "
            "differ by 0.2 / m");
  std::vector<TargetMeasurement> unseen = sweep({1});
  for (std::size_t k = 0; k < 2; ++k) unseen[k].usable = Image(kColumns, kRows);
  const std::string principal = "calibration: focus distance 1 m: at the principal point ";
  EXPECT_EQ(refusal_of(unseen),
            principal +
                "the views of only 2 targets match; 3 are needed: is the target textured and within "
                "range?");
  std::vector<TargetMeasurement> close = {measurement(1, 0.5), measurement(1, 0.98), measurement(1, 1),
                                          measurement(1, 1.02)};
  close[0].usable = Image(kColumns, kRows);
  EXPECT_EQ(refusal_of(close), principal +
                                   "the 3 targets whose views match are too close together: their inverses differ by "
                                   "0.04 / m; must be 0.2 / m");
  std::vector<TargetMeasurement> equal = sweep({1});
  for (TargetMeasurement& m : equal) m.disparity_dp_px = Image(kColumns, kRows);
  EXPECT_EQ(refusal_of(equal),
            principal + "disparity does not change with distance: are the two views the same picture?");
  EXPECT_EQ(refusal_of({}), "calibration: no measurements");
}

TEST(Calibration, SaysWhenTheTargetWasTilted) {
  for (const double tilt : {-5.0, -2.0, 1.0, 5.0}) {
    const std::vector<TargetMeasurement> measurements = sweep({0.8, 2}, tilt);
    const TargetTilt found = estimate_tilt(test_camera(), measurements);
    EXPECT_NEAR(found.x_deg, tilt, 0.01);
    EXPECT_NEAR(found.y_deg, 0, 0.01);
    const Calibration calibration = fit_calibration(test_camera(), measurements);
    ASSERT_EQ(calibration.warnings.size(), 1u);
    EXPECT_NE(calibration.warnings[0].find("the target seems tilted"), std::string::npos);
  }
}

// A slope that is even about the principal point, wherever that lies, is a symmetric lens's. Between nodes the slope is
// taken as linear, which leaves .1 degrees of the 5 that a mirror in the picture's middle would find.
TEST(Calibration, ASymmetricLensOffTheMiddleIsNoTiltedTarget) {
  for (const double off : {-0.05, 0.02, 0.05}) {  // of the width
    Camera camera = test_camera();
    camera.principal_point_px[0] += off * camera.width_px;
    for (const double tilt_deg : {0.0, 3.0}) {
      std::vector<TargetMeasurement> measurements = sweep({0.8});
      for (TargetMeasurement& m : measurements) {
        for (int j = 0; j < kRows; ++j) {
          for (int i = 0; i < kColumns; ++i) {
            const double u = 2.0 * i / (kColumns - 1) - 1 - 2 * off, v = 2.0 * j / (kRows - 1) - 1;
            const double per_u = 1344 * 1.4e-3 / (4.4 / (1 - 4.4e-3 / 0.8));
            const double inverse = (1 - std::tan(tilt_deg * std::numbers::pi / 180) * u * per_u) / m.target_distance_m;
            m.disparity_dp_px.at(i, j) = static_cast<float>(-0.8 * (1 - 0.2 * (u * u + v * v)) * inverse + 1);
          }
        }
      }
      EXPECT_NEAR(estimate_tilt(camera, measurements).x_deg, tilt_deg, 0.1) << off;
      EXPECT_EQ(fit_calibration(camera, measurements).warnings.empty(), tilt_deg == 0) << off;
    }
  }
}

// Student's t of which 0.27 % lies beyond, from tables.
TEST(Calibration, FewTargetsMustShowATiltMoreClearly) {
  EXPECT_NEAR(significant_errors(4), 6.62, 0.2);
  EXPECT_NEAR(significant_errors(6), 4.90, 0.1);
  EXPECT_NEAR(significant_errors(10), 3.96, 0.04);
  EXPECT_NEAR(significant_errors(120), 3.06, 0.01);
  EXPECT_EQ(significant_errors(0), std::numeric_limits<double>::infinity());
}

// A tilt about one axis that is certain, but too small to warn of, must not make the other's count, which is chance.
TEST(Calibration, WarnsOfATiltByTheAxesThatAreMoreThanChance) {
  constexpr int kSweeps = 20;
  std::mt19937 random(7);
  std::normal_distribution<float> normal(0, 0.1f);
  int large = 0, warned = 0;
  for (int k = 0; k < kSweeps; ++k) {
    std::vector<TargetMeasurement> measurements = sweep({kInfinity, 0.8, 0.5}, 0.3);
    for (TargetMeasurement& m : measurements) {  // noise that is the same in each row's columns leaves x as it is
      for (int third = 0; third < 3; ++third) {
        const float error = normal(random);
        for (int j = third * kRows / 3; j < (third + 1) * kRows / 3; ++j) {
          for (int i = 0; i < kColumns; ++i) m.disparity_dp_px.at(i, j) += error;
        }
      }
    }
    const TargetTilt found = estimate_tilt(test_camera(), measurements);
    ASSERT_LT(std::abs(found.x_deg), 0.7);
    ASSERT_GT(std::abs(found.x_deg), significant_errors(found.degrees_of_freedom) * found.x_error_deg);
    large += std::abs(found.y_deg) > 0.7 ? 1 : 0;
    warned += fit_calibration(test_camera(), measurements).warnings.empty() ? 0 : 1;
  }
  EXPECT_GT(large, kSweeps / 4);
  EXPECT_LE(warned, 1);
}

// Noise that is one number over a third of the field, as large as a single frame's at ISO 1600: the errors stated must
// be those seen, and a level target must not be called tilted.
TEST(Calibration, StatesTheErrorOfATiltAndWarnsOfNoneThatChanceMakes) {
  constexpr int kSweeps = 60;
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0, 0.1f);
  double squares = 0, stated = 0;
  int warned = 0;
  for (int k = 0; k < kSweeps; ++k) {
    std::vector<TargetMeasurement> measurements = sweep({kInfinity, 0.8, 0.5});
    for (TargetMeasurement& m : measurements) {
      for (int third = 0; third < 3; ++third) {
        const float error = normal(random);
        for (int j = 0; j < kRows; ++j) {
          for (int i = third * kColumns / 3; i < (third + 1) * kColumns / 3; ++i) m.disparity_dp_px.at(i, j) += error;
        }
      }
    }
    const TargetTilt found = estimate_tilt(test_camera(), measurements);
    squares += found.x_deg * found.x_deg / kSweeps;
    stated += found.x_error_deg * found.x_error_deg / kSweeps;
    warned += fit_calibration(test_camera(), measurements).warnings.empty() ? 0 : 1;
  }
  EXPECT_GT(std::sqrt(squares), 0.7);  // without its error, a tilt of so much would be warned of
  // both variances are known to a fifth from 60 sweeps
  EXPECT_GT(std::sqrt(stated / squares), 0.8);
  EXPECT_LT(std::sqrt(stated / squares), 1.25);
  EXPECT_LE(warned, 2);
}

TEST(Calibration, AFrontoParallelPlaneIsFlatAfterCorrectionAtAnyDepth) {
  const Calibration calibration = fit_calibration(test_camera(), sweep({kInfinity, 1.5, 0.5}));
  Camera camera = test_camera();
  const Correction correction = make_correction(calibration, camera);
  EXPECT_EQ(correction.warning, "");
  for (const double depth : {0.3, 0.8, 5.0}) {
    Image d(1344, 504), confidence(1344, 504, 1, 0.7f);
    for (int y = 0; y < d.height; ++y) {
      for (int x = 0; x < d.width; ++x) {
        const double u = 2 * (x + 0.5) / d.width - 1, v = 2 * (y + 0.5) / d.height - 1;
        d.at(x, y) = static_cast<float>(slope_at(u, v) / depth + intercept_at(u, v, camera.focus_distance_m));
      }
    }
    Image more = d, sigma(d.width, d.height, 1, 0.125f), ignored(d.width, d.height);
    for (float& value : more.data) value += 0.125f;
    correct_disparity(correction, more, ignored);
    correct_disparity(correction, d, confidence, &sigma);
    // an error becomes what a difference becomes; disparities of up to 8 px round by 5e-7 each
    for (std::size_t i = 0; i < sigma.data.size(); ++i) ASSERT_NEAR(sigma.data[i], more.data[i] - d.data[i], 4 * 5e-7);
    const double axis = slope_at(0, 0) / depth + intercept_at(0, 0, camera.focus_distance_m);
    for (const float value : d.data) ASSERT_NEAR(value, axis, 2e-3);
    for (const float value : confidence.data) ASSERT_EQ(value, 0.7f);
  }
}

TEST(Calibration, VanishingSlopesAreNotUsableAndStayFinite) {
  Calibration calibration = fit_calibration(test_camera(), sweep({0.8}));
  calibration.focuses[0].slope_dp_px_m.at(3, 3) = -1e-30f;
  calibration.focuses[0].slope_dp_px_m.at(15, 10) = 0.5f;  // of the wrong sign
  const Correction correction = make_correction(calibration, test_camera());
  Image d(400, 280, 1, 1.0f), confidence(400, 280, 1, 1.0f);
  correct_disparity(correction, d, confidence);
  for (const float value : d.data) ASSERT_LT(std::abs(value), 10);
  EXPECT_EQ(confidence.at(59, 59), 0);  // node (3, 3) is at (60, 60)
  EXPECT_EQ(confidence.at(41, 60), 0);
  EXPECT_EQ(confidence.at(79, 79), 0);
  EXPECT_EQ(confidence.at(39, 60), 1);
  EXPECT_EQ(confidence.at(300, 200), 0);
  EXPECT_EQ(confidence.at(200, 140), 1);
}

/// Largest error of a corrected plane at 0.4 m where its confidence is 1.
double worst_trusted_error(const Calibration& calibration) {
  const Camera camera = test_camera();
  Image d(1344, 504), confidence(1344, 504, 1, 1.0f);
  for (int y = 0; y < d.height; ++y) {
    for (int x = 0; x < d.width; ++x) {
      const double u = 2 * (x + 0.5) / d.width - 1, v = 2 * (y + 0.5) / d.height - 1;
      d.at(x, y) = static_cast<float>(slope_at(u, v) / 0.4 + intercept_at(u, v, camera.focus_distance_m));
    }
  }
  correct_disparity(make_correction(calibration, camera), d, confidence);
  const double axis = slope_at(0, 0) / 0.4 + intercept_at(0, 0, camera.focus_distance_m);
  double worst = 0;
  for (std::size_t i = 0; i < d.data.size(); ++i) {
    if (confidence.data[i] == 1) worst = std::max(worst, std::abs(d.data[i] - axis));
  }
  return worst;
}

// A spline reads a node beyond those around a pixel with a weight of at most 2/27. What it finds in a hole is off by
// what gain and offset change over two nodes: up to 0.1 and 0.2 DP px here, where the disparity is about -0.8.
TEST(Calibration, DisparityBesideAHoleIsAsGoodAsElsewhere) {
  Calibration calibration = fit_calibration(test_camera(), sweep({0.8}));
  EXPECT_LT(worst_trusted_error(calibration), 2e-3);
  for (int j = 3; j <= 5; ++j) {
    for (int i = 2; i <= 4; ++i) calibration.focuses[0].slope_dp_px_m.at(i, j) = 0;
  }
  calibration.focuses[0].slope_dp_px_m.at(20, 14) = 0;
  calibration.focuses[0].slope_dp_px_m.at(12, 9) = 0;
  EXPECT_LT(worst_trusted_error(calibration), 2.0 / 27 * 0.2 + 2e-3);
}

TEST(Calibration, AHoleBesideThePrincipalPointLeavesItsLineAndOneOnItIsRefused) {
  Calibration calibration = fit_calibration(test_camera(), sweep({0.8}));
  calibration.focuses[0].slope_dp_px_m.at(11, 7) = 0;
  EXPECT_LT(worst_trusted_error(calibration), 2.0 / 27 * 0.2 + 2e-3);
  calibration.focuses[0].slope_dp_px_m.at(10, 7) = 0;
  EXPECT_EQ(message_of<InputError>([&] { make_correction(calibration, test_camera()); }),
            "calibration: focus distance 0.8 m: disparity at the principal point does not change with depth: there is "
            "nothing to correct to");
}

// Focused where it was calibrated, a camera has no use for the lines of another focus distance.
TEST(Calibration, HolesOfOtherFocusDistancesDoNotCountAtACalibratedOne) {
  std::vector<TargetMeasurement> measurements = sweep({1, 0.5});
  for (TargetMeasurement& m : measurements) {
    if (m.focus_distance_m == 1) m.usable.at(3, 4) = 0;
  }
  const Calibration calibration = fit_calibration(test_camera(), measurements);
  EXPECT_NE(focus_at(calibration, 0.5).slope_dp_px_m.at(3, 4), 0);
  EXPECT_EQ(focus_at(calibration, 0.6).slope_dp_px_m.at(3, 4), 0);
  EXPECT_EQ(focus_at(calibration, 1).slope_dp_px_m.at(3, 4), 0);
}

TEST(Calibration, BeyondTheCalibratedFocusTheNearestIsUsedWithLessConfidenceAndAWarning) {
  const Calibration calibration = fit_calibration(test_camera(), sweep({2, 0.5}));
  Camera camera = test_camera();
  camera.focus_distance_m = 0.4;  // 0.5 / m too near
  const Correction near = make_correction(calibration, camera);
  EXPECT_NEAR(near.confidence, std::exp(-1.0), 1e-6);
  EXPECT_EQ(near.warning,
            "focus distance 0.4 m lies outside the calibrated 0.5 m to 2 m; the nearest calibration, 0.5 m, is used");
  camera.focus_distance_m = kInfinity;
  const Correction far = make_correction(calibration, camera);
  EXPECT_NEAR(far.confidence, std::exp(-1.0), 1e-6);
  EXPECT_NE(far.warning.find("focus distance inf m"), std::string::npos);
  EXPECT_NEAR(focus_at(calibration, kInfinity).intercept_dp_px.data[principal_node(camera)], 0.8 / 2, 1e-5);
}

TEST(Calibration, RefusesAnotherCamerasCapture) {
  const Calibration calibration = fit_calibration(test_camera(), sweep({0.8}));
  Camera camera = test_camera();
  camera.name = "other\n";
  EXPECT_THROW(make_correction(calibration, camera), InputError);
  for (int Camera::*field : {&Camera::width_px, &Camera::height_px, &Camera::dp_downsample_x}) {
    camera = test_camera();
    camera.*field *= 2;
    EXPECT_THROW(make_correction(calibration, camera), InputError);
  }
  camera = test_camera();
  camera.f_number = 2;
  try {
    make_correction(calibration, camera);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "capture does not fit the calibration: /camera/f_number: 2: another camera; must be 1.8");
  }
}

TEST(Calibration, SurvivesItsFileAndRefusesADamagedOne) {
  const Calibration calibration = fit_calibration(test_camera(), sweep({kInfinity, 0.8}, 3));
  const nlohmann::json json = to_json(calibration);
  const Calibration read = read_calibration(json, "c.json");
  ASSERT_EQ(read.focuses.size(), 2u);
  EXPECT_EQ(read.warnings, calibration.warnings);
  EXPECT_EQ(nlohmann::json(to_json(read)), json);
  EXPECT_LT(json.dump().size(), 2u * 10000u);  // twenty focus distances: 200 kB

  const auto refused = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json damaged = json;
    damaged[nlohmann::json::json_pointer(pointer)] = value;
    try {
      read_calibration(damaged, "c.json");
    } catch (const InputError& error) {
      const std::string message = error.what();
      return message.starts_with("c.json: /") && message.find('\n') == std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused("/version", 1));
  EXPECT_TRUE(refused("/format", "other"));
  EXPECT_TRUE(refused("/surprise", 1));
  EXPECT_TRUE(refused("/focuses", nlohmann::json::array()));
  EXPECT_TRUE(refused("/focuses/1/focus_distance_m", "inf"));
  EXPECT_TRUE(refused("/focuses/0/slope_dp_px_m", {1, 2, 3}));
  EXPECT_TRUE(refused("/focuses/0/slope_dp_px_m/7", nullptr));
  EXPECT_TRUE(refused("/focuses/0/slope_dp_px_m/157", 0));  // at the principal point
  EXPECT_TRUE(refused("/focuses/0/r_squared", 1.5));
  EXPECT_TRUE(refused("/camera/width_px", 0));
  EXPECT_TRUE(refused("/warnings", 5));
  EXPECT_TRUE(refused("/warnings", "text"));
}

/// Two focus distances, whose kernels skew by 1 and 3 DP px^3 at the left border, none at the right.
Calibration with_skew() {
  Calibration calibration = fit_calibration(test_camera(), sweep({kInfinity, 0.8}));
  for (int i = 0; i < 2; ++i) {
    calibration.focuses[i].skew = {2, 1, std::vector<SkewCurve>(2, SkewCurve{{}, {}, 1.25f})};
    calibration.focuses[i].skew.nodes[0].xxx[0] = static_cast<float>(1 + 2 * i);
    calibration.focuses[i].skew.nodes[0].xyy[5] = 0.25f;
  }
  return calibration;
}

TEST(Calibration, KernelSkewIsThatOfTheFocusDistanceAndOfThePart) {
  const Calibration calibration = with_skew();
  EXPECT_FLOAT_EQ(focus_at(calibration, kInfinity).skew.at(0, 0).at(0).xxx, 1);
  EXPECT_FLOAT_EQ(focus_at(calibration, 1.6).skew.at(0, 0).at(0).xxx, 2);
  EXPECT_FLOAT_EQ(focus_at(calibration, 0.5).skew.at(0, 0).at(0).xxx, 3);
  Camera camera = test_camera();
  camera.focus_distance_m = 1.6;
  const Correction correction = make_correction(calibration, camera);
  EXPECT_FLOAT_EQ(correction.skew.at(0.5, 0.5).at(0).xxx, 1);
  EXPECT_FLOAT_EQ(of_part(correction, 0.5, 0, 0.5, 1).skew.at(0, 0).at(0).xxx, 1);
  EXPECT_FLOAT_EQ(of_part(correction, 0.5, 0, 0.5, 1).skew.at(1, 1).at(0).xxx, 0);
}

TEST(Calibration, KernelSkewSurvivesItsFileAndADamagedOneIsRefused) {
  const nlohmann::json json = to_json(with_skew());
  const Calibration read = read_calibration(json, "c.json");
  EXPECT_EQ(nlohmann::json(to_json(read)), json);
  EXPECT_EQ(read.focuses[1].skew.nodes[0].xxx[0], 3);
  EXPECT_EQ(read.focuses[1].skew.nodes[1].farthest_dp_px, 1.25f);
  const auto message = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json damaged = json;
    damaged[nlohmann::json::json_pointer(pointer)] = value;
    return message_of<InputError>([&] { read_calibration(damaged, "c.json"); });
  };
  EXPECT_EQ(message("/focuses/0/kernel_skew/xxx", {1, 2}),
            "c.json: /focuses/0/kernel_skew/xxx: 2 numbers: must be 6 for each of 2 x 1 nodes, row by row");
  EXPECT_TRUE(message("/focuses/0/kernel_skew/columns", 0).starts_with("c.json: /focuses/0/kernel_skew/columns"));
  EXPECT_TRUE(message("/focuses/0/kernel_skew/more", 0).starts_with("c.json: /focuses/0/kernel_skew"));
  EXPECT_TRUE(message("/focuses/0/kernel_skew/farthest_dp_px", "x").starts_with("c.json: /focuses/0/kernel_skew"));
  nlohmann::json uneven = json;
  uneven["focuses"][1].erase("kernel_skew");
  EXPECT_EQ(message_of<InputError>([&] { read_calibration(uneven, "c.json"); }),
            "c.json: /focuses/1/kernel_skew: must have as many nodes as that of the first focus distance");
}

// Whatever a capture may say of its camera must come back from the file that `calibrate` makes of it.
TEST(Calibration, ReadsWhateverCameraACaptureMayHave) {
  Calibration calibration = fit_calibration(test_camera(), sweep({0.8}));
  calibration.camera.f_number = 1e6;
  calibration.camera.principal_point_px = {-20, 5000};
  const Calibration read = read_calibration(to_json(calibration), "c.json");
  EXPECT_EQ(read.camera.f_number, 1e6);
  EXPECT_EQ(read.camera.principal_point_px[0], -20);
  EXPECT_EQ(read.camera.principal_point_px[1], 5000);
}

}  // namespace
}  // namespace dualpixel::pipeline
