#include "evaluation/experiments/defocus_experiment.h"

#include <gtest/gtest.h>

#include "evaluation/simulated_scene.h"
#include "tests/run_program.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

// The paper's figure of color halos: ours leaves what is in focus as it is, bit for bit but for the blend to 1.5 px,
// and brings no foreground into the wall; a gather does the second, a single pass the first.
TEST(DefocusExperiment, HalosAreOthers) {
  for (const float radius_px : {5.0f, 9.0f}) {
    const std::vector<Halo> halos = measure_halos(radius_px);
    ASSERT_EQ(halos.size(), 3u);
    const Halo &ours = halos[0], &gather = halos[1], &single = halos[2];
    EXPECT_EQ(ours.inside, 0);
    EXPECT_EQ(gather.inside, 0);
    EXPECT_GT(single.inside, 0.03);
    EXPECT_GT(gather.outside, 0.03);
    // What lies behind the disc is not in the picture: lights there are missing from ours as from the single pass.
    EXPECT_LT(ours.outside, 0.1 * gather.outside);
    EXPECT_LT(ours.outside, 1.3 * single.outside + 0.001);
  }
}

TEST(SlowDefocusExperiment, BadLensesAreRefused) {
  const TemporaryFolder folder;
  for (const std::string lens : {"f/0@50mm-equivalent", "f/1.4@50mm-equivalents"}) {
    expect_one_line_refusal(run_program("portrait nowhere -o '" + (folder / "out") + "' --match-lens '" + lens + "'"));
  }
  const Outcome seg = run_program("portrait nowhere -o '" + (folder / "out") +
                                  "' --mode seg --true-mask --match-lens f/1.4@50mm-equivalent");
  expect_one_line_refusal(seg);
  EXPECT_NE(seg.err.find("--match-lens"), std::string::npos) << seg.err;
}

SceneDefocus measure(const std::string& name) {
  const std::string path = std::string(DUALPIXEL_SCENES_DIR "/") + name + ".json";
  return measure_defocus(
      simulate_scene(path, {"sensor.width_px=672", "sensor.height_px=504", "sensor.pixel_pitch_um=5.6",
                            "lens.file=../lens_models/phone_thin_4.4mm_f1.8.json", "render.samples_per_pixel=32",
                            "render.photograph_samples_per_pixel=160", "render.all_in_focus_samples_per_pixel=64"}),
      name);
}

// Through the thin lens, whose disparity tells the ideal photograph's blur. That of a prescription holds its field
// curvature and aberrations, too, which the photograph has not: through phone_6p the portrait reaches 27 dB.
// True disparity and physically true blur against the ray-traced photograph, on a sixteenth of the photosites. From
// the picture that the phone took there is its noise, its own blur and its clipped highlights on top.
TEST(SweepDefocusExperiment, TrueDisparityComesNearThePhotograph) {
  for (const auto& [name, floor_db] : {std::pair{"slanted_planes", 34.0}, {"portrait", 30.0}}) {
    const SceneDefocus scene = measure(name);
    EXPECT_GT(scene.steps[0].psnr.all_db, floor_db) << name;
    EXPECT_GT(scene.steps[1].psnr.all_db, scene.not_blurred.all_db + 8) << name;
    // sunlit leaves are clipped in the one, nothing is in the other
    const double won_db = scene.recovered.psnr.all_db - scene.steps[1].psnr.all_db;
    EXPECT_GT(won_db, name == std::string("portrait") ? 0.3 : -0.01) << name;
  }
}

}  // namespace
}  // namespace dualpixel::evaluation
