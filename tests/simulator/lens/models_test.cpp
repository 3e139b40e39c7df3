// Every lens model of the table can be read, refocused, written down by its name, planned with and rendered through.
#include "simulator/lens/models.h"

#include <gtest/gtest.h>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/plan/lens_candidates.h"
#include "simulator/plan/lens_report.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// A shipped lens of each model.
Lens shipped_lens(const std::string& model) {
  const std::string name = model == "thin"        ? "phone_thin_4.4mm_f1.8"
                           : model == "aberrated" ? "phone_aberrated_4.4mm_f1.8"
                                                  : "full_frame_50mm_f1.8";
  return read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/" + name + ".json", 2);
}

TEST(LensModels, EveryRowReadsTheModelOfItsName) {
  for (const LensModelRow& row : kLensModels) {
    const Lens lens = shipped_lens(row.name);
    EXPECT_EQ(lens.model.index(), row.value) << row.name;
    EXPECT_STREQ(name_of(kLensModels, lens.model.index()), row.name);
    EXPECT_DOUBLE_EQ(refocused(lens, 3).thin.focus_distance_m, 3);
    EXPECT_EQ(lens_candidates(lens).back().lens.model.index(), row.value) << "what it is comes last";
    const LensSampler sampler(lens, phone_sensor(16, 12, 1e-4));
    EXPECT_NEAR(sampler.lux_per_nit(), lens.thin.lux_per_nit(), 0.05 * lens.thin.lux_per_nit()) << row.name;
  }
}

TEST(LensModels, AnUnknownModelIsRefusedWithTheTable) {
  try {
    read_lens({{"model", "aberated"}}, "lens.json", "", 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "lens.json: /model: \"aberated\": must be one of 'thin', 'aberrated', 'prescription'; did you mean "
                 "'aberrated'?");
  }
}

TEST(LensModels, AFocusOutOfReachIsRefused) {
  for (const LensModelRow& row : kLensModels) {
    const Lens lens = shipped_lens(row.name);
    EXPECT_THROW(refocused(lens, 0.5 * lens.thin.focal_length_m), InputError) << row.name;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
