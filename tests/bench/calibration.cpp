#include <benchmark/benchmark.h>

#include "pipeline/calibration/calibration.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/calibration/flow.h"
#include "pipeline/calibration/nodes.h"
#include "tests/pipeline/texture.h"

/// What calibration costs at 1344 x 504: the flow between a target's views, and correcting a disparity.
namespace dualpixel::pipeline {
namespace {

constexpr int kWidth = 1344, kHeight = 504;

void flow(benchmark::State& state) {
  const Texture texture(3, 1.0 / 48);
  const Image left = textured(texture, kWidth, kHeight, 0), right = textured(texture, kWidth, kHeight, 1.2);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(match_target(left, right));
}
BENCHMARK(flow)->Unit(benchmark::kMillisecond)->UseRealTime();

void correction(benchmark::State& state) {
  Camera camera;
  camera.width_px = 2 * kWidth;
  camera.height_px = 4 * kHeight;
  camera.dp_downsample_y = 4;
  camera.pixel_pitch_um = 1.4;
  camera.focal_length_mm = 4.4;
  camera.f_number = 1.8;
  camera.focus_distance_m = 0.8;
  camera.principal_point_px = {kWidth, 2 * kHeight};
  std::vector<TargetMeasurement> measurements;
  for (const double target_m : {0.25, 0.4, 1.0, 2.5}) {
    const auto disparity_dp_px = static_cast<float>(0.8 / camera.focus_distance_m - 0.8 / target_m);
    measurements.push_back({camera.focus_distance_m, target_m,
                            Image(kCalibrationColumns, kCalibrationRows, 1, disparity_dp_px),
                            Image(kCalibrationColumns, kCalibrationRows, 1, 1.0F)});
  }
  const Correction map = make_correction(fit_calibration(camera, measurements), camera);
  Image disparity(kWidth, kHeight, 1, 1.0F), confidence(kWidth, kHeight, 1, 1.0F);
  for ([[maybe_unused]] auto _ : state) {
    correct_disparity(map, disparity, confidence);
    benchmark::DoNotOptimize(disparity.data.data());
  }
}
BENCHMARK(correction)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace dualpixel::pipeline
