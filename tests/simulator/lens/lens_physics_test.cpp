// Every parameter of the lens and of the split pixel against its closed form (lens_models/README.md), by Monte Carlo
// over the sampler that rendering uses. N samples of a net err less than N independent ones; tolerances are three
// standard errors of the latter, so a failure is a wrong formula.
#include <gtest/gtest.h>

#include <cmath>

#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr int kSamples = 65536;
constexpr double kPitch = 1.4e-6;
constexpr double kFocus = 1.0;

Lens base_lens(SplitKind split = SplitKind::hard) {
  Lens lens;
  lens.model = Aberrations{};
  lens.thin = {4.442e-3, 1.8, kFocus};
  lens.split.kind = split;
  return lens;
}

Aberrations& aberrations(Lens& lens) { return std::get<Aberrations>(lens.model); }

/// A sensor whose photosite (0, 0) has its center at (x, y), in field radii of the lens.
SensorGrid photosite_at(const Lens& lens, double x, double y) {
  const double radius_mm = image_radius_mm(lens) > 0 ? image_radius_mm(lens) : Aberrations{}.image_radius_mm;
  const double per_radius = field_radius_m(radius_mm, lens.thin) / kPitch;
  return {1, 1, kPitch, {0.5 - x * per_radius, 0.5 - y * per_radius}};
}

DisparityCoefficients at(const Lens& lens, double x, double y) {
  return trace_disparity(LensSampler(lens, photosite_at(lens, x, y)), 0, 0, kSamples);
}

double blur_scale_px_m(const Lens& lens) {
  return lens.thin.pupil_diameter_m() * lens.thin.image_distance_m() / kPitch;
}
/// alpha from the slope of disparity in 1/D: d = alpha L z_i (1/z - 1/D), two photosites to a DP pixel.
double alpha(const Lens& lens, const DisparityCoefficients& c) { return -2 * c.slope_dp_px_m / blur_scale_px_m(lens); }
double light(const DisparityCoefficients& c) { return c.left_light + c.right_light; }
double binomial_error(double p) { return 3 * std::sqrt(p * (1 - p) / kSamples); }
/// Of a mean over the half pupil, in pupil radii: the half disc's standard deviation along x is 0.264.
constexpr double kAlphaError = 3 * 0.264 / 181;

// Disparity is counted in DP pixels: a sensor whose are one photosite wide sees twice as many, blur stays.
TEST(DisparityField, CountsInTheSensorsOwnDpPixels) {
  Lens lens = base_lens(SplitKind::ramp);
  for (const LensModel& model : {LensModel(ThinModel{}), LensModel(Aberrations{})}) {
    lens.model = model;
    SensorGrid sensor = photosite_at(lens, 0.4, -0.3);
    const DisparityCoefficients two = DisparityField(LensSampler(lens, sensor)).at(0.5, 0.5);
    sensor.dp_downsample_x = 1;
    const DisparityCoefficients one = DisparityField(LensSampler(lens, sensor)).at(0.5, 0.5);
    EXPECT_DOUBLE_EQ(one.slope_dp_px_m, 2 * two.slope_dp_px_m);
    EXPECT_DOUBLE_EQ(one.intercept_dp_px, 2 * two.intercept_dp_px);
    EXPECT_DOUBLE_EQ(one.blur_slope_px_m, two.blur_slope_px_m);
  }
}

/// A sensor of 64 x 48 photosites that holds the whole image circle.
SensorGrid whole_field(const Lens& lens, int width = 64, int height = 48) {
  const double side_m = 2 * field_radius_m(image_radius_mm(lens), lens.thin) / std::hypot(width, height);
  return {width, height, side_m, {width / 2.0, height / 2.0}};
}

// Rims that darken the corners, or one view on one side of the picture: truth stays finite, and wherever light passes
// blur is that of the lens.
TEST(DisparityField, IsFiniteWhereNoLightPasses) {
  for (const SplitKind kind : {SplitKind::ramp, SplitKind::hard}) {
    for (const auto& [radius, shift] : {std::pair{0.6, 2.5}, {0.6, 1.5}, {1.0, 1.9}, {0.3, 4.0}}) {
      Lens lens = base_lens(kind);
      aberrations(lens).rims = {{radius, shift}};
      const SensorGrid sensor = whole_field(lens);
      const DisparityField field(LensSampler(lens, sensor));
      const double blur = field.at(32, 24).blur_slope_px_m, alpha = field.at(32, 24).slope_dp_px_m;
      for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) {
          const DisparityCoefficients c = field.at(x + 0.5, y + 0.5);
          // a half disc that is cut has its center elsewhere, at most at the rim
          EXPECT_NEAR(c.blur_slope_px_m / blur, 1, 1e-3) << radius << ' ' << shift << ' ' << x << ' ' << y;
          EXPECT_TRUE(std::abs(c.slope_dp_px_m) < 4 * std::abs(alpha))
              << radius << ' ' << shift << ' ' << x << ' ' << y;
        }
      }
    }
  }
}

TEST(LensParameters, AllZeroIsTheThinLens) {
  Lens aberrated = base_lens(SplitKind::ramp);
  Lens thin = aberrated;
  thin.model = ThinModel{};
  const SensorGrid sensor = photosite_at(aberrated, 0.4, -0.3);
  const LensSampler a(aberrated, sensor), b(thin, sensor);
  alignas(64) float s[4][kPacket];
  LensPacket pa, pb;
  joint_samples(0, 5, s);
  a.sample(0, 0, 1, s, pa);
  b.sample(0, 0, 1, s, pb);
  for (int i = 0; i < kPacket; ++i) {
    EXPECT_NEAR(pa.slope_x[i], pb.slope_x[i], 1e-6);
    EXPECT_NEAR(pa.slope_y[i], pb.slope_y[i], 1e-6);
    EXPECT_NEAR(pa.origin_x[i], pb.origin_x[i], 1e-9);
    EXPECT_NEAR(pa.right[i], pb.right[i], 1e-6);
  }
}

// Two equal discs displaced by e: area, and alpha and the left view's share where the split stays in the middle.
TEST(LensParameters, CatsEye) {
  struct Row {
    double e, area, alpha_along, left_along, alpha_across;
  };
  for (const Row& row : {Row{0, 1, .424, .5, .424}, Row{.4, .747, .338, .34, .400}, Row{.8, .505, .268, .10, .363}}) {
    Lens lens = base_lens();
    aberrations(lens).rims = {{1, row.e}};
    const DisparityCoefficients along = at(lens, 1, 0), across = at(lens, 0, 1);
    const double exact = row.e == 0 ? 1 : (2 * std::acos(row.e / 2) - row.e / 2 * std::sqrt(4 - row.e * row.e)) / M_PI;
    EXPECT_NEAR(exact, row.area, 5e-4);
    EXPECT_NEAR(light(along), exact, binomial_error(exact) + 1e-6);
    EXPECT_NEAR(light(across), exact, binomial_error(exact) + 1e-6);
    // the table's last digit on top
    EXPECT_NEAR(alpha(lens, along), row.alpha_along, kAlphaError / std::sqrt(exact * row.left_along * 2) + 5e-4);
    EXPECT_NEAR(along.left_light / light(along), row.left_along, binomial_error(row.left_along) + 5e-3);
    EXPECT_NEAR(alpha(lens, across), row.alpha_across, kAlphaError / std::sqrt(exact) + 5e-4);
    EXPECT_NEAR(across.left_light / light(across), 0.5, binomial_error(0.5));
  }
  // the rim beyond h = 1 in the other direction blocks the other side
  Lens lens = base_lens();
  aberrations(lens).rims = {{1, 0.8}};
  EXPECT_LT(at(lens, -1, 0).right_light, at(lens, -1, 0).left_light);
  EXPECT_LT(at(lens, 1, 0).left_light, at(lens, 1, 0).right_light);
}

TEST(LensParameters, SplitOffset) {
  for (double e : {-0.2, 0.0, 0.1, 0.3}) {
    Lens lens = base_lens();
    aberrations(lens).split_offset.constant = e;
    const DisparityCoefficients c = at(lens, 0, 0);
    const double right = (std::acos(e) - e * std::sqrt(1 - e * e)) / M_PI, left = 1 - right;
    EXPECT_NEAR(c.right_light, right, binomial_error(right));
    EXPECT_NEAR(alpha(lens, c), std::pow(1 - e * e, 1.5) / (3 * M_PI * left * right), kAlphaError);
  }
  Lens lens = base_lens();
  aberrations(lens).split_offset.gradient_x = 0.1;
  EXPECT_NEAR(at(lens, 1, 0).right_light, 0.436, binomial_error(0.436) + 5e-4);
  EXPECT_NEAR(at(lens, -1, 0).left_light, 0.436, binomial_error(0.436) + 5e-4);
}

TEST(LensParameters, SplitOffsetMapIsBilinearBetweenItsCells) {
  FieldMap map;
  map.columns = 2;
  map.rows = 1;
  map.cells = {-0.1f, 0.3f};  // cells centered on x = -1/2 and 1/2
  EXPECT_NEAR(map(-0.5, 0.7), -0.1, 1e-6);
  EXPECT_NEAR(map(0, 0), 0.1, 1e-6);
  EXPECT_NEAR(map(0.25, 0), 0.2, 1e-6);
  EXPECT_NEAR(map(1, 0), 0.3, 1e-6);
}

// Field curvature moves the image behind the sensor by dz: b = -L dz / z_i, at the depth that would else be sharp.
TEST(LensParameters, FieldCurvature) {
  Lens lens = base_lens();
  aberrations(lens).tangential_focus_um.c = {30, -10};
  aberrations(lens).sagittal_focus_um.c = {-8};
  aberrations(lens).focus_um_per_diopter = 3;
  const double h = 0.7, h2 = h * h;
  const double dz_t = 1e-6 * (30 * h2 - 10 * h2 * h2 + 3 / kFocus), dz_s = 1e-6 * (-8 * h2 + 3 / kFocus);
  const double b_per_dz = -lens.thin.pupil_diameter_m() / lens.thin.image_distance_m() / kPitch;
  const auto in_focus = [&](const DisparityCoefficients& c) { return c.slope_dp_px_m / kFocus + c.intercept_dp_px; };
  const double full = 4 / (3 * M_PI) / 2;
  EXPECT_NEAR(in_focus(at(lens, h, 0)), full * b_per_dz * dz_t, kAlphaError * std::abs(b_per_dz * dz_t) + 1e-4);
  EXPECT_NEAR(in_focus(at(lens, 0, h)), full * b_per_dz * dz_s, kAlphaError * std::abs(b_per_dz * dz_s) + 1e-4);
  EXPECT_NEAR(in_focus(at(lens, 0, 0)), full * b_per_dz * 3e-6, kAlphaError * 2);
}

// d = 2 [(b/2) 4/(3 pi) + c3 4/(5 pi)] for the hard split; the fifth power has 4/(7 pi).
TEST(LensParameters, SphericalAberration) {
  Lens lens = base_lens();
  aberrations(lens).spherical_um = {5, -2};
  const DisparityCoefficients c = at(lens, 0, 0);
  const double depth = 2, b_px = blur_scale_px_m(lens) * (1 / kFocus - 1 / depth);
  const double c3_px = 5e-6 / kPitch, c5_px = -2e-6 / kPitch;
  const double expected_px = 2 * (b_px / 2 * 4 / (3 * M_PI) + c3_px * 4 / (5 * M_PI) + c5_px * 4 / (7 * M_PI));
  EXPECT_NEAR(2 * (c.slope_dp_px_m / depth + c.intercept_dp_px), expected_px, 2 * kAlphaError * std::abs(b_px));
}

TEST(LensParameters, DistortionMovesThePicture) {
  Lens lens = base_lens();
  aberrations(lens).distortion.c = {-0.04, 0.01};
  const double h = 0.8, shrink = 1 + (-0.04 * h * h + 0.01 * h * h * h * h);
  const SensorGrid sensor = photosite_at(lens, 0.6 * h, -0.8 * h);
  const LensSampler sampler(lens, sensor);
  const double radius = h * field_radius_m(image_radius_mm(lens), lens.thin);
  const glm::dvec2 slope = sampler.chief_slope(0.6 * radius, -0.8 * radius);
  EXPECT_NEAR(glm::length(slope), radius / shrink / lens.thin.image_distance_m(), 1e-12);
  // the sampled bundle's mean is the chief ray
  alignas(64) float s[4][kPacket];
  LensPacket packet;
  glm::dvec2 mean(0);
  for (int first = 0; first < 1024; first += kPacket) {
    joint_samples(first, 3, s);
    sampler.sample(0, 0, 1, s, packet);
    for (int i = 0; i < kPacket; ++i) mean += glm::dvec2(packet.slope_x[i], packet.slope_y[i]) / 1024.0;
  }
  EXPECT_NEAR(mean.x, slope.x, 2e-5);
  EXPECT_NEAR(mean.y, slope.y, 2e-5);
}

TEST(LensParameters, ColorMovesFocusAndSize) {
  Lens lens = base_lens();
  aberrations(lens).longitudinal_color_um = {12, -20};
  aberrations(lens).lateral_color = {0.001, -0.002};
  const LensSampler sampler(lens, photosite_at(lens, 0.5, 0));
  ASSERT_TRUE(sampler.has_color());
  const double radius = 0.5 * field_radius_m(image_radius_mm(lens), lens.thin);
  for (int color : {0, 1, 2}) {
    const double size = 1 + (color == 0 ? 0.001 : color == 2 ? -0.002 : 0);
    const double dz = color == 0 ? 12e-6 : color == 2 ? -20e-6 : 0;
    alignas(64) float s[4][kPacket];
    LensPacket packet;
    joint_samples(0, 1, s);
    std::fill(&s[0][0], &s[2][0], 0.5f);
    sampler.sample(0, 0, color, s, packet);
    for (int i = 0; i < kPacket; ++i) {
      // where the ray crosses the focus plane, as sensor length: X / size + p R dz / z_i
      const double there = (packet.slope_x[i] + packet.origin_x[i] / kFocus) * lens.thin.image_distance_m();
      EXPECT_NEAR(there, radius / size + packet.origin_x[i] * dz / lens.thin.image_distance_m(), 2e-9);
    }
  }
}

// The irradiance of a disc of radius R at distance d, h off its axis (the exact law), and cos^4 beside it.
TEST(LensParameters, Falloff) {
  Lens lens = base_lens();
  const double d = lens.thin.image_distance_m(), r = lens.thin.pupil_diameter_m() / 2;
  for (double field : {0.0, 0.5, 1.0}) {
    const double x = field * field_radius_m(image_radius_mm(lens), lens.thin);
    const double sum = x * x + d * d + r * r;
    const double exact =
        0.5 * (1 - (x * x + d * d - r * r) / std::sqrt(sum * sum - 4 * r * r * x * x)) / (r * r / (d * d));
    aberrations(lens).falloff = Aberrations::Falloff::disc;
    EXPECT_NEAR(light(at(lens, field, 0)), exact, 2e-3 * exact) << field;
    aberrations(lens).falloff = Aberrations::Falloff::cos4;
    EXPECT_NEAR(light(at(lens, field, 0)), std::pow(1 + x * x / (d * d), -2), 1e-5);
  }
  // 8.4 % over cos^4 at 38.5 degrees, axis against axis
  const double x = std::tan(38.5 * M_PI / 180) * 4.442e-3;
  const double disc = [&] {
    const double f = 4.442e-3, sum = x * x + f * f + r * r;
    const double off = 1 - (x * x + f * f - r * r) / std::sqrt(sum * sum - 4 * r * r * x * x);
    return off / (1 - (f * f - r * r) / (f * f + r * r));
  }();
  EXPECT_NEAR(disc / std::pow(1 + x * x / (4.442e-3 * 4.442e-3), -2), 1.084, 5e-4);
}

TEST(LensParameters, ViewGainsShadeEachView) {
  Lens lens = base_lens();
  aberrations(lens).left_gain = {0.8, -0.2, 0};
  aberrations(lens).right_gain = {0.7, 0, 0};
  EXPECT_NEAR(at(lens, 0.5, 0).left_light, 0.5 * 0.7, binomial_error(0.5));
  EXPECT_NEAR(at(lens, 0.5, 0).right_light, 0.5 * 0.7, binomial_error(0.5));
  EXPECT_NEAR(at(lens, -0.5, 0).left_light, 0.5 * 0.9, binomial_error(0.5));
}

TEST(ThinLensFocusing, ByPowerDoesNotBreathe) {
  ThinLens moved{4.442e-3, 1.8, 0.2}, powered = moved;
  powered.focusing = ThinLens::Focusing::power;
  EXPECT_DOUBLE_EQ(powered.image_distance_m(), 4.442e-3);
  EXPECT_NEAR(moved.image_distance_m(), 1 / (1 / 4.442e-3 - 1 / 0.2), 1e-15);
  EXPECT_NEAR(powered.blur_diameter_m(1e9), powered.pupil_diameter_m() * 4.442e-3 / 0.2, 1e-13);
}

TEST(SplitKinds, AlphaOfEachKind) {
  SplitPixel split;
  split.kind = SplitKind::hard;
  for (double leak : {0.0, 0.1, 0.25}) {
    split.crosstalk = leak;
    EXPECT_NEAR(split.alpha(), (1 - 2 * leak) * 4 / (3 * M_PI), 1e-12);
    Lens lens = base_lens();
    lens.split = split;
    EXPECT_NEAR(alpha(lens, at(lens, 0, 0)), split.alpha(), kAlphaError);
  }
  split = {};
  for (double k : {1.0, 1.19, 3.0}) {
    split.k = k;
    Lens lens = base_lens();
    lens.split = split;
    EXPECT_NEAR(alpha(lens, at(lens, 0, 0)), 1 / (4 * k), kAlphaError);
  }
}

// The Canon-like microlens's alpha at four f-numbers.
TEST(SplitKinds, Microlens) {
  const double expected[4][2] = {{1.4, .283}, {2, .233}, {2.8, .180}, {4, .133}};
  for (const auto& [f_number, value] : expected) {
    Lens lens = base_lens(SplitKind::microlens);
    lens.thin = {50e-3, f_number, std::numeric_limits<double>::infinity()};
    EXPECT_NEAR(lens.split.alpha(lens.thin.rim_slope()), value, 6e-4) << f_number;
    EXPECT_NEAR(alpha(lens, at(lens, 0, 0)), lens.split.alpha(lens.thin.rim_slope()), kAlphaError) << f_number;
  }
}

// h = f and a wide diode: every ray lands at h t, so the microlens is a hard split, offset by shift / (h tan theta).
TEST(SplitKinds, MicrolensInFocusIsTheHardSplit) {
  Lens lens = base_lens(SplitKind::microlens);
  lens.split.microlens = {1.0, 1.0, 5.0, 0.5, 0, 0};
  EXPECT_NEAR(alpha(lens, at(lens, 0, 0)), 4 / (3 * M_PI), kAlphaError);
  const double e = 0.2;
  lens.split.microlens.shift = e * lens.thin.rim_slope();
  const double right = (std::acos(e) - e * std::sqrt(1 - e * e)) / M_PI;
  EXPECT_NEAR(at(lens, 0, 0).right_light, right, binomial_error(right));
  // however narrow the pupil is beside the diodes
  lens.split.microlens = {1.0, 1.0, 10.0, 0.5, 0, 0};
  for (const double f_number : {8, 32, 200}) {
    lens.thin.f_number = f_number;
    EXPECT_NEAR(alpha(lens, at(lens, 0, 0)), 4 / (3 * M_PI), kAlphaError) << f_number;
  }
}

// A microlens shifted for another exit pupil looks past the real one by the difference of the two chief rays.
TEST(SplitKinds, MicrolensMadeForAnotherPupil) {
  Lens lens = base_lens(SplitKind::microlens);
  const double x = field_radius_m(image_radius_mm(lens), lens.thin), d = lens.thin.image_distance_m();
  lens.split.microlens.design_exit_pupil_mm = 2 * d * 1e3;
  Lens shifted = lens;
  shifted.split.microlens.design_exit_pupil_mm = 0;
  shifted.split.microlens.shift = -shifted.split.microlens.height * (x / d - x / (2 * d));
  const DisparityCoefficients a = at(lens, 1, 0), b = at(shifted, 1, 0);
  EXPECT_NEAR(a.left_light, b.left_light, 1e-4);
  EXPECT_NEAR(a.right_light, b.right_light, 1e-4);
  EXPECT_NEAR(a.slope_dp_px_m, b.slope_dp_px_m, 1e-3 * std::abs(b.slope_dp_px_m));
  EXPECT_NE(a.left_light, at(lens, 0, 0).left_light);
}

// What microlenses shifted for a distant pupil see of a pupil twice as far away at h = 1 is what they see of one that
// stands there everywhere.
TEST(SplitKinds, ExitPupilThatMovesOverTheField) {
  Lens moved = base_lens(SplitKind::microlens);
  moved.split.microlens.design_exit_pupil_mm = 1e3;
  const double to_the_pupil_mm = 1e3 * moved.thin.focal_length_m;
  aberrations(moved).exit_pupil_mm = to_the_pupil_mm;
  aberrations(moved).exit_pupil_growth = {{0.5, 0.5}};
  Lens farther = moved;
  aberrations(farther).exit_pupil_growth = {};
  const double moved_mm = 1e3 * (moved.thin.image_distance_m() - moved.thin.focal_length_m);
  aberrations(farther).exit_pupil_mm = 2 * (to_the_pupil_mm + moved_mm) - moved_mm;
  const DisparityCoefficients a = at(moved, 1, 0), b = at(farther, 1, 0);
  EXPECT_NEAR(a.left_light, b.left_light, 1e-6);
  EXPECT_NEAR(a.right_light, b.right_light, 1e-6);
  aberrations(farther).exit_pupil_mm = to_the_pupil_mm;
  EXPECT_GT(std::abs(at(farther, 1, 0).left_light - a.left_light), 0.01);
  EXPECT_EQ(at(farther, 0, 0).left_light, at(moved, 0, 0).left_light);
}

TEST(SplitKinds, MeasuredTableIsLinearBetweenItsRows) {
  SplitPixel split;
  split.kind = SplitKind::table;
  split.table = {{-1, 0, 1}, {0.8, 0.4, 0.1}, {0.1, 0.4, 0.7}};
  EXPECT_NEAR(split.shares(-0.5, 0).left, 0.6, 1e-12);
  EXPECT_NEAR(split.shares(0.25, 0).right, 0.475, 1e-12);
  EXPECT_NEAR(split.shares(2, 0).left, 0.1, 1e-12);
  Lens lens = base_lens();
  lens.split = split;
  EXPECT_NEAR(alpha(lens, at(lens, 0, 0)), split.alpha(), kAlphaError);
}

// Its rows beyond the pupil are those of a pupil that lies off the split: the ramp of k = 2, shifted by half a radius.
TEST(SplitKinds, AMeasuredTableCountsBeyondThePupil) {
  Lens table = base_lens();
  table.split.kind = SplitKind::table;
  table.split.table = {{-2, 2}, {1, 0}, {0, 1}};
  aberrations(table).split_offset.constant = 0.5;
  Lens ramp = table;
  ramp.split = {.kind = SplitKind::ramp, .k = 2};
  const DisparityCoefficients a = at(table, 0, 0), b = at(ramp, 0, 0);
  EXPECT_NEAR(a.left_light, b.left_light, 1e-5);
  EXPECT_NEAR(a.slope_dp_px_m, b.slope_dp_px_m, 1e-5 * std::abs(b.slope_dp_px_m));
}

}  // namespace
}  // namespace dualpixel::simulator::testing
