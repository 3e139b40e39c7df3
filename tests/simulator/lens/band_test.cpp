// A filter's band through a prescription: each draw is one wavelength of it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/render/render_scene.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

const std::string kPhone = DUALPIXEL_SOURCE_DIR "/lens_models/phone_6p_4.2mm_f1.8.json";

Lens phone(const nlohmann::json& more) {
  nlohmann::json json = {{"file", kPhone}};
  json.update(more);
  return read_lens(json, "s.json", "/lens", 1);
}

// The three samples of an 80 nm band lie 26.67 nm apart: rays of the draws are those of lenses made for these
// wavelengths; the first draw is the middle.
TEST(SlowBand, DrawsAreTheRaysOfTheBandsWavelengths) {
  const SensorGrid sensor = phone_sensor(2000, 1500, 1.4e-6);
  const LensSampler band(phone({{"band_samples", 3}, {"band_width_nm", 80}}), sensor);
  alignas(64) float s[4][kPacket];
  for (int i = 0; i < kPacket; ++i) {
    for (int d = 0; d < 4; ++d) s[d][i] = unit_float(static_cast<std::uint32_t>(hash(i, d) >> 32));
  }
  const double step = 80.0 / 3;
  double moved = 0;
  for (const auto& [draw, nm] : {std::pair{3u, 0.0}, {4u, step}, {2u, -step}}) {
    const LensSampler one(phone({{"wavelengths_nm", {610 + nm, 540 + nm, 465 + nm}}}), sensor);
    for (int color = 0; color < 3; ++color) {
      LensPacket a, b, middle;
      band.sample(1700, 400, color, s, a, draw);
      one.sample(1700, 400, color, s, b);
      band.sample(1700, 400, color, s, middle);
      for (int i = 0; i < kPacket; ++i) {
        // both turn within the photosite by the green chief ray, whose wavelength differs: far below the colors' shift
        EXPECT_NEAR(a.slope_x[i], b.slope_x[i], 1e-6f);
        EXPECT_NEAR(a.slope_y[i], b.slope_y[i], 1e-6f);
        moved = std::max(moved, static_cast<double>(std::abs(a.slope_x[i] - middle.slope_x[i])));
      }
    }
  }
  EXPECT_GT(moved, 1e-5);
}

/// A lens of one element, f/16, in a glass that disperses much: its paraxial focus at 513.3 and 566.7 nm lies .460 mm
/// ahead and .404 mm behind that at 540 nm, where the sensor is.
Lens dispersing() {
  const nlohmann::json front = {{"stop", true},
                                {"radius_mm", 70},
                                {"thickness_mm", 2},
                                {"glass", {{"nd", 1.7}, {"vd", 20}}},
                                {"semi_diameter_mm", 1.5502}};
  const nlohmann::json back = {{"radius_mm", -70}, {"thickness_mm", 49.017989}, {"semi_diameter_mm", 5}};
  return read_lens({{"model", "prescription"},
                    {"image_radius_mm", 0.5},
                    {"reference_nm", 540},
                    {"wavelengths_nm", {620, 540, 460}},
                    {"band_samples", 3},
                    {"band_width_nm", 80},
                    {"surfaces", {front, back}}},
                   "s.json", "/lens", 100);
}

// A point, rendered through that lens: a third of its light comes to a focus, a third each fills discs of 14.37 and
// 12.61 um. Spherical aberration is 1.9 um at the rim of the focused third. Some 4000 samples of green photosites meet
// the source: a share of .37 has a standard error of .008; four of these. The middle wavelength alone would give 1.
TEST(SlowBand, ARenderedPointHasEveryWavelengthOfTheBand) {
  constexpr int kSide = 36;
  constexpr double kPitch_m = 1e-6, kCore_px = 4;
  const CameraView camera{glm::mat4(1), LensSampler(dispersing(), phone_sensor(kSide, kSide, kPitch_m))};
  const auto half = static_cast<float>(100 * 0.5 * kPitch_m / camera.lens.lens().thin.image_distance_m());
  Scene scene;
  scene.materials = {glowing(1000)};
  scene.meshes = {make_quad({-half, -half, 100}, {2 * half, 0, 0}, {0, 2 * half, 0}, 0)};
  const Image seen = undivided(render_views(RenderScene(scene), camera, {.samples_per_pixel = 8192}));
  double core = 0, all = 0;
  int core_photosites = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (cfa_color(x, y) != 1) continue;
      const bool in_core = std::hypot(x + 0.5 - kSide / 2, y + 0.5 - kSide / 2) < kCore_px;
      core_photosites += in_core;
      core += in_core ? seen.at(x, y, 1) : 0;
      all += seen.at(x, y, 1);
    }
  }
  double expected = 1.0 / 3;
  for (const double radius_px : {14.37, 12.61}) expected += core_photosites / (M_PI * radius_px * radius_px / 2) / 3;
  EXPECT_NEAR(core / all, expected, 0.032);
}

TEST(Band, RefusesEvenNumbersAndInvisibleLight) {
  EXPECT_THROW(phone({{"band_samples", 2}}), InputError);
  EXPECT_THROW(phone({{"band_samples", 3}, {"wavelengths_nm", {540, 540, 540}}}), InputError);
  EXPECT_THROW(phone({{"band_samples", 3}, {"wavelengths_nm", {610, 540, 360}}, {"band_width_nm", 80}}), InputError);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
