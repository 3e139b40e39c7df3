#include "simulator/lens/lens_shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/shading.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/lens/prescription/lens_analysis.h"
#include "simulator/simulate.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// A thin lens whose stop lies in it, with the natural falloff of its chief rays.
Lens lens_with_natural_falloff() {
  Lens lens;
  Aberrations aberrations;
  aberrations.falloff = Aberrations::Falloff::cos4;
  lens.model = aberrations;
  lens.thin = {4.442e-3, 1.8, 1.0};
  return lens;
}

TEST(RelativeLight, BehindAThinLensIsNotStated) {
  Lens lens;
  lens.thin = {4.442e-3, 1.8, 1.0};
  EXPECT_TRUE(relative_light(LensSampler(lens, phone_sensor(2688, 2016))).empty());
}

// cos^4, and between the nodes of the grid at most what a straight line errs there.
TEST(RelativeLight, OfNaturalFalloffIsCos4) {
  const Lens lens = lens_with_natural_falloff();
  const SensorGrid sensor = phone_sensor(2688, 2016);
  Camera camera;
  camera.width_px = sensor.width_px;
  camera.height_px = sensor.height_px;
  camera.relative_light = relative_light(LensSampler(lens, sensor));
  const Image gain = shading_gain(camera);
  ASSERT_EQ(gain.width, sensor.width_px);
  ASSERT_EQ(gain.height, sensor.height_px);
  const double distance_m = lens.thin.image_distance_m();
  // A line between points h apart errs by h^2 / 8 times the second derivative, along both axes: that of 1 / (1 + r^2)^2
  // is 4 at most, on the axis.
  const double step = (sensor.width_px - 1) / 16.0 * sensor.pixel_pitch_m / distance_m;
  const double tolerance = 2 * step * step / 8 * 4 + 1e-5;
  for (int y = 0; y < gain.height; y += 31) {
    for (int x = 0; x < gain.width; x += 29) {
      const double slope = glm::length(sensor.middle_m(x, y)) / distance_m;
      ASSERT_NEAR(1 / gain.at(x, y), std::pow(1 + slope * slope, -2), tolerance) << x << ' ' << y;
    }
  }
  const double corner = glm::length(sensor.middle_m(0, 0)) / distance_m;
  EXPECT_NEAR(1 / gain.at(0, 0), std::pow(1 + corner * corner, -2), 1e-5);
}

// Against the lens designer's relative illumination, from directions counted in double precision, of an object at
// infinity. The lens is focused there, too, and the split pixel loses nothing.
TEST(SlowRelativeLight, OfAPrescriptionIsItsRelativeIllumination) {
  Lens lens = read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/phone_6p_4.2mm_f1.8.json", INFINITY);
  lens.split = {};
  const Prescription& prescription = *prescription_of(lens);
  const FieldAnalysis field = analyze_fields(prescription, 550, {28 * M_PI / 180}).front();
  ASSERT_TRUE(field.reached);
  ASSERT_LT(field.relative_illumination, 0.8);
  // a sensor whose corner is where that chief ray arrives
  constexpr int kWidth = 2688, kHeight = 2016;
  const SensorGrid sensor =
      phone_sensor(kWidth, kHeight, field.chief_height * 1e-3 / std::hypot(0.5 * kWidth, 0.5 * kHeight));
  const Image light = relative_light(LensSampler(lens, sensor));
  ASSERT_FALSE(light.empty());
  // 16384 rays, some of which are lost, and the analysis's grid of directions: each some tenths of a per cent
  EXPECT_NEAR(light.at(0, 0), field.relative_illumination, 0.01);
  EXPECT_NEAR(light.at(light.width - 1, light.height - 1), field.relative_illumination, 0.01);
  EXPECT_NEAR(light.at(light.width / 2, light.height / 2), 1, 0.002);
}

// An even wall through a lens with cos^4: frames times the gain are as bright as the photograph, which has none.
TEST(RelativeLight, MakesFramesAsEvenAsThePhotograph) {
  const nlohmann::json document = {
      {"version", 1},
      {"gltf", "scene.glb"},
      {"sensor", {{"width_px", 128}, {"height_px", 96}, {"pixel_pitch_um", 29.4}, {"dp_downsample_y", 4}}},
      {"burst", {{"frames", 1}}},
      {"exposure", {{"time_s", 0.004}}},
      {"lens", {{"model", "aberrated"}, {"falloff", "cos4"}, {"focal_length_mm", 4.442}, {"f_number", 1.8}}}};
  const Simulation s = read_simulation(document, "s.json");
  Scene scene;
  scene.materials = {glowing(500)};
  scene.meshes = {make_quad({-5, -5, -1}, {10, 0, 0}, {0, 10, 0}, 0)};
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  const Capture capture = simulate(s, scene);
  const Image gain = shading_gain(capture.camera);
  ASSERT_EQ(gain.width, 128);
  EXPECT_GT(gain.at(0, 0), 1.4f);
  Image signal = normalized(capture.frames[0].mosaic, capture.exposure);
  correct_shading(signal, gain, 1);
  const double range = capture.exposure.white_level_dn - capture.exposure.black_level_dn;
  const auto expect_even = [&](int x0, int y0) {
    constexpr int kSide = 16;
    double sum = 0, variance = 0;
    int count = 0;
    for (int y = y0; y < y0 + kSide; ++y) {
      for (int x = x0 + (y & 1 ? 0 : 1); x < x0 + kSide; x += 2) {  // green
        sum += signal.at(x, y) - capture.truth->photograph.at(x, y, 1);
        variance += gain.at(x, y) * capture.exposure.mosaic_noise.shot_dn * signal.at(x, y) / range;
        ++count;
      }
    }
    // four standard errors of the sensor's noise, and .3 % between the grid's nodes
    EXPECT_NEAR(sum / count, 0, 4 * std::sqrt(variance) / count + 0.003 * capture.truth->photograph.at(x0, y0, 1));
  };
  expect_even(0, 0);
  expect_even(56, 40);
  expect_even(112, 80);
  expect_even(112, 0);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
