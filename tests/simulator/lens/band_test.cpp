// A filter's band through a prescription: each draw is one wavelength of it.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/sampling/hash.h"
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

TEST(Band, RefusesEvenNumbersAndInvisibleLight) {
  EXPECT_THROW(phone({{"band_samples", 2}}), InputError);
  EXPECT_THROW(phone({{"band_samples", 3}, {"wavelengths_nm", {610, 540, 360}}, {"band_width_nm", 80}}), InputError);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
