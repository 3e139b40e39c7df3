// Every lens model of the table can be read, refocused, written down by its name, planned with and rendered through.
#include "simulator/lens/models.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/plan/lens_candidates.h"
#include "simulator/plan/lens_report.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

/// A shipped lens of each model.
Lens shipped_lens(const std::string& model) {
  const std::string name = model == "thin"        ? "phone_thin_4.4mm_f1.8"
                           : model == "aberrated" ? "phone_aberrated_4.4mm_f1.8"
                                                  : "full_frame_50mm_f1.8";
  return read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/" + name + ".json", 2);
}

TEST(SlowLensModels, EveryRowReadsTheModelOfItsName) {
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

// Another split behind the same rays is the lens with that split.
TEST(SlowLensModels, AnotherSplitSharesTheLens) {
  for (const LensModelRow& row : kLensModels) {
    Lens lens = shipped_lens(row.name);
    const SensorGrid sensor = phone_sensor(16, 12, 1e-4);
    SplitPixel other;
    other.kind = SplitKind::microlens;
    other.microlens.shift = 0.1;
    const LensSampler changed = LensSampler(lens, sensor).with_split(other);
    lens.split = other;
    const LensSampler made(lens, sensor);
    EXPECT_EQ(changed.lens().split.kind, SplitKind::microlens);
    alignas(64) float s[4][LensSampler::kRays];
    joint_samples(0, 0, s);
    LensPacket a, b;
    changed.sample(3, 5, 1, s, a);
    made.sample(3, 5, 1, s, b);
    for (int i = 0; i < LensSampler::kRays; ++i) {
      EXPECT_EQ(a.slope_x[i], b.slope_x[i]) << row.name;
      EXPECT_EQ(a.left[i], b.left[i]) << row.name;
      EXPECT_EQ(a.right[i], b.right[i]) << row.name;
    }
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

TEST(LensModels, AnUnknownModelOverALensFileIsRefusedWithTheTable) {
  const std::string file = DUALPIXEL_SOURCE_DIR "/lens_models/phone_thin_4.4mm_f1.8.json";
  EXPECT_EQ(message_of<InputError>([&] {
              read_lens({{"file", file}, {"model", "thinn"}}, "a.json", "/lens", 1);
            }),
            "a.json: /lens/model: \"thinn\": must be one of 'thin', 'aberrated', 'prescription'; did you mean 'thin'?");
  const std::string other = message_of<InputError>([&] {
    read_lens({{"file", file}, {"model", "aberrated"}}, "a.json", "/lens", 1);
  });
  EXPECT_TRUE(other.starts_with("a.json: /lens/model: differs from that of " + file)) << other;
}

TEST(LensModels, AFaultNamesTheFileThatHoldsIt) {
  const std::string file = DUALPIXEL_SOURCE_DIR "/lens_models/phone_thin_4.4mm_f1.8.json";
  EXPECT_EQ(message_of<InputError>([&] {
              read_lens({{"file", file}, {"f_number", -2}}, "a.json", "/lens", 1);
            }),
            "a.json: /lens/f_number: -2: must be a number in [0.1, 1000]");
  EXPECT_EQ(message_of<InputError>([&] {
              read_lens({{"file", file}, {"split", {{"k", 0}}}}, "a.json", "/lens", 1);
            }),
            "a.json: /lens/split/k: 0: must be a number in [1, 1e+06]");
  // what the scene leaves to the lens file is that file's fault
  EXPECT_TRUE(message_of<InputError>([&] {
                read_lens({{"file", file}}, "a.json", "/lens", 0.001);
              }).starts_with(file + ": "));
}

// Captures state alpha from 0 on.
TEST(LensModels, ASplitOfExchangedHalvesIsRefused) {
  const auto refusal = [](bool exchanged) {
    nlohmann::json split = {{"model", "table"}, {"p", {-1, 1}}, {"left", {1, 0}}, {"right", {0, 1}}};
    if (exchanged) split["left"].swap(split["right"]);
    return message_of<InputError>([&] { read_lens({{"split", split}}, "a.json", "/lens", 1e9); });
  };
  EXPECT_EQ(refusal(false), "");
  EXPECT_EQ(refusal(true),
            "a.json: /lens/split: gives each view the light of the other half of the pupil (alpha below 0): exchange "
            "left and right");
}

// A picture in which heights in the scene come to lie in the reverse order would be black there.
TEST(LensModels, ADistortionThatFoldsThePictureIsRefused) {
  const auto refusal = [](double d) {
    const nlohmann::json lens = {{"model", "aberrated"}, {"image_radius_mm", 3}, {"distortion", {d}}};
    return message_of<InputError>([&] { read_lens(lens, "a.json", "/lens", 1e9); });
  };
  EXPECT_EQ(refusal(-0.5), "");
  EXPECT_EQ(refusal(0.9), "");  // h / (1 + d h^2) grows up to h = 1 / sqrt(d)
  EXPECT_EQ(refusal(3), "a.json: /lens/distortion: folds the picture at h = 0.59: h / (1 + it) must grow with h");
}

// f/1.8 lets the light of the middle's microlens land within .78 / 3.6 = .22 photosites of 0, and its disc reaches .23
// around each point: beyond .45 less the diodes' .3, one half gets nothing; beyond .75, neither does.
TEST(LensModels, ASplitThatKeepsAHalfDarkIsRefused) {
  const auto refusal = [](double shift) {
    const nlohmann::json split = {{"model", "microlens"}, {"shift_px", shift}};
    return message_of<InputError>([&] { read_lens({{"split", split}}, "a.json", "/lens", 1e9); });
  };
  EXPECT_EQ(refusal(0.44), "");
  EXPECT_EQ(refusal(0.46),
            "a.json: /lens/split: lets no light of the lens's pupil into the right half: must into both");
  EXPECT_EQ(refusal(-0.46),
            "a.json: /lens/split: lets no light of the lens's pupil into the left half: must into both");
  EXPECT_EQ(refusal(10),
            "a.json: /lens/split: lets no light of the lens's pupil into the left and the right half: must into both");
}

TEST(LensModels, AFocusOutOfReachIsRefused) {
  for (const LensModelRow& row : kLensModels) {
    const Lens lens = shipped_lens(row.name);
    const std::string refusal = message_of<InputError>([&] { refocused(lens, 0.5 * lens.thin.focal_length_m); });
    EXPECT_TRUE(refusal.starts_with("focus_distance_m: ")) << row.name << ": " << refusal;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
