// Views whose every half-photosite is kept, under the mosaic's colors, against views of 2 x 2 photosites of the same
// light and against the truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "capture/json_fields.h"
#include "evaluation/calibration_sweep/calibration_captures.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/nodes.h"
#include "pipeline/disparity/match_pixels.h"
#include "pipeline/portrait/run_portrait.h"
#include "simulator/lens/lens_file.h"
#include "simulator/simulate.h"
#include "tests/evaluation/calibration_sweep/target_wall.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

/// Slanted planes at 384 x 288 photosites, DP pixels of `side` x `side`, as bright as the sensor bears.
Capture slanted_planes(int side) {
  const std::string path = DUALPIXEL_SCENES_DIR "/slanted_planes.json";
  nlohmann::json scene = read_json_file(path);
  const std::string downsample = std::to_string(side);
  for (const std::string& assignment :
       {std::string("sensor.width_px=384"), std::string("sensor.height_px=288"),
        std::string("sensor.pixel_pitch_um=2.8"), "sensor.dp_downsample_x=" + downsample,
        "sensor.dp_downsample_y=" + downsample, std::string("burst.frames=1"),
        std::string("render.samples_per_pixel=64"), std::string("render.photograph_samples_per_pixel=1"),
        std::string("render.all_in_focus_samples_per_pixel=1")}) {
    apply_override(scene, assignment);
  }
  return simulator::simulate(simulator::read_simulation(scene, path),
                             simulator::load_scene(simulator::read_simulation(scene, path)));
}

/// RMS over the confident of `found` minus the truth at the same places, in photosites.
double error_px(const pipeline::PortraitResult& found, const Capture& capture) {
  const Camera& camera = capture.camera;
  double squares = 0, count = 0;
  for (int y = 0; y < camera.dp_height(); ++y) {
    for (int x = 0; x < camera.dp_width(); ++x) {
      const int u = x * camera.dp_downsample_x + camera.dp_downsample_x / 2;
      const int v = y * camera.dp_downsample_y + camera.dp_downsample_y / 2;
      if (found.matched_confidence.at(x, y) < 0.5f || capture.truth->valid.at(u, v) != 1) continue;
      const double error = found.matched_disparity_dp_px.at(x, y) - capture.truth->disparity_dp_px.at(u, v);
      squares += error * error, ++count;
    }
  }
  EXPECT_GT(count, 0.3 * camera.dp_width() * camera.dp_height());
  return camera.dp_downsample_x * std::sqrt(squares / count);
}

TEST(SlowDenseCapture, MatchesAsOneOfTwoByTwoDoes) {
  const Capture dense = slanted_planes(1), two = slanted_planes(2);
  // The same electrons: a 2 x 2 pixel is the mean of its green ones, but for rounding, 1/2 DN of either and of the mean
  const Image means = pipeline::green_means(normalized(dense.frames[0].left, dense.exposure), dense.camera.cfa);
  const Image left = normalized(two.frames[0].left, two.exposure);
  ASSERT_TRUE(means.same_size(left));
  const auto step = static_cast<float>(1 / (dense.exposure.white_level_dn - dense.exposure.black_level_dn));
  for (std::size_t i = 0; i < left.data.size(); ++i) ASSERT_NEAR(means.data[i], left.data[i], 1.01f * step) << i;

  for (const char* matcher : {"paper", "likelihood", "split"}) {
    SCOPED_TRACE(matcher);
    const pipeline::PortraitOptions options = pipeline::default_options(matcher);
    const pipeline::PortraitResult of_dense = run_portrait(dense, options), of_two = run_portrait(two, options);
    ASSERT_EQ(of_dense.matched_disparity_dp_px.width, 384);
    const double dense_px = error_px(of_dense, dense), two_px = error_px(of_two, two);
    std::printf("%s: RMS error %.3f photosites dense, %.3f at 2 x 2\n", matcher, dense_px, two_px);
    // the same matches: rounding adds less than a tenth of the noise, and bilinear maps lose nothing on planes
    EXPECT_LT(dense_px, 1.1 * two_px);
  }
}

TEST(SlowDenseCapture, TakesAGivenDisparity) {
  const Capture dense = slanted_planes(1);
  pipeline::PortraitOptions options;
  const pipeline::PortraitResult matched = run_portrait(dense, options);
  options.disparity = {matched.matched_disparity_dp_px, matched.matched_confidence, {}};
  const pipeline::PortraitResult given = run_portrait(dense, options);
  EXPECT_EQ(given.portrait.data, matched.portrait.data);
  EXPECT_EQ(given.disparity_dp_px.data, matched.disparity_dp_px.data);

  // the truth is taken as it is, and smoothed along edges nearer to the truth than what was matched
  options.disparity = {dense.truth->disparity_dp_px, {}, {}};
  const pipeline::PortraitResult of_truth = run_portrait(dense, options);
  EXPECT_EQ(of_truth.matched_disparity_dp_px.data, dense.truth->disparity_dp_px.data);
  const auto error = [&](const Image& found) {
    double sum = 0;
    for (std::size_t i = 0; i < found.data.size(); ++i) {
      sum += std::abs(found.data[i] - dense.truth->disparity_dp_px.data[i]);
    }
    return sum / static_cast<double>(found.data.size());
  };
  EXPECT_LT(error(of_truth.disparity_dp_px), error(matched.disparity_dp_px));
}

/// 512 x 384 photosites of a target that fills the picture.
simulator::Simulation target_camera(int side) {
  simulator::Simulation simulation;
  simulation.lens = simulator::read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/phone_thin_4.4mm_f1.8.json", 1);
  simulation.sensor.width_px = 512;
  simulation.sensor.height_px = 384;
  simulation.sensor.pixel_pitch_um = 5.6;
  simulation.sensor.dp_downsample_x = simulation.sensor.dp_downsample_y = side;
  simulation.burst_frames = 1;
  simulation.render.samples_per_pixel = 32;
  simulation.photograph_samples_per_pixel = simulation.all_in_focus_samples_per_pixel = 1;
  return simulation;
}

/// The mean over the inner nodes, in photosites.
double mean_px(const pipeline::TargetMeasurement& measurement, int side) {
  double sum = 0, count = 0;
  for (int j = 3; j < pipeline::kCalibrationRows - 3; ++j) {
    for (int i = 3; i < pipeline::kCalibrationColumns - 3; ++i) sum += measurement.disparity_dp_px.at(i, j), ++count;
  }
  return side * sum / count;
}

TEST(SlowDenseCapture, IsCalibratedFromCapturesAndBySweeps) {
  constexpr double kFocus_m = 0.8, kTarget_m = 0.5;
  double captured_px[3] = {}, swept_px[3] = {};
  for (const int side : {1, 2}) {
    const TemporaryFolder folder;
    simulator::Simulation simulation = target_camera(side);
    const simulator::LensSampler lens = focused_lens(simulation, kFocus_m);
    simulation.lens = lens.lens();
    const CalibrationTarget target{kTarget_m, 0, 5, 32};
    write_capture(simulate(simulation, target_wall(target, print_target(target, lens))), folder / "one");
    folder.write("distances.json", R"({"captures": [{"capture": "one", "target_distance_m": 0.5}]})");
    captured_px[side] = mean_px(measure_captures(folder.path, [](double) {}).measurements.front(), side);
    swept_px[side] = mean_px(FocusSweep(simulation, kFocus_m, {}).measure(kTarget_m, 5), side);
  }
  std::printf("captured %.4f dense, %.4f at 2 x 2; swept %.4f, %.4f photosites\n", captured_px[1], captured_px[2],
              swept_px[1], swept_px[2]);
  // As near as the renderer's and the sweep's means of a larger picture are (SlowCalibrationTarget): .003 px of two
  // photosites. That captures of so small a picture measure less than sweeps do is no matter of dense views.
  EXPECT_NEAR(captured_px[1], captured_px[2], 0.006);
  EXPECT_NEAR(swept_px[1], swept_px[2], 0.006);
  EXPECT_LT(captured_px[1], -0.2);
}

// Of a picture so small that the polynomial which evens out the views' light has as many terms as there are means to
// fit it to.
TEST(SlowDenseCapture, ADigitalNumberHereAndThereHardlyMovesACalibration) {
  simulator::Simulation simulation = target_camera(2);
  const simulator::LensSampler lens = focused_lens(simulation, 0.8);
  simulation.lens = lens.lens();
  const CalibrationTarget target{0.5, 0, 5, 32};
  const Capture capture = simulate(simulation, target_wall(target, print_target(target, lens)));
  const auto mean_with = [&](int every) {
    std::vector<Frame> frames = capture.frames;
    std::mt19937 random(every);
    for (ImageU16* view : {&frames[0].left, &frames[0].right}) {
      for (std::uint16_t& value : view->data) value += every > 0 && random() % every == 0 ? 1 : 0;
    }
    const pipeline::MergedBurst burst = pipeline::align_and_merge(frames, capture.exposure);
    return mean_px(pipeline::measure_target(burst.left, burst.right, 0.8, 0.5), 2);
  };
  // One DN in one of 1600 pixels is a hundredth of the noise, which is some 2.5 DN a pixel: a tenth of what is allowed
  // above for all of it.
  const double mean = mean_with(0);
  for (const int every : {1598, 1599, 1600, 1601}) EXPECT_NEAR(mean_with(every), mean, 0.0006) << every;
}

}  // namespace
}  // namespace dualpixel::evaluation
