#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

/// Wadhwa et al. 2018, supplement, "Controlled Experiments on DP Data": noise of disparity over light and over depth. A
/// textured, fronto-parallel target in the central quarter of the field; one disparity per tile; since it should be the
/// same everywhere, its standard deviation over the tiles is the error.
namespace dualpixel::evaluation {

/// Of each burst.
inline constexpr int kNoiseFrames = 6;

struct NoiseExperimentOptions {
  int width_px = 1344;  ///< photosites: the central quarter of 2688 x 2016
  int height_px = 1008;
  int samples_per_pixel = 128;
  int depth_samples_per_pixel = 64;  ///< of the depth sweep, at half the width and height
  std::vector<double> light_lux = {5, 10, 20, 50, 100, 200, 1000};
  double target_m = 0.88;  ///< of the light sweep
  double focus_m = 0.95;
  std::vector<double> focus_distances_m = {0.4, 0.7, 0.95, 1.5};  ///< of the depth sweep
  std::vector<double> depths_m = {0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.82, 0.95, 1.2, 1.5, 2};
  double depth_lux = 10;  ///< dim enough for noise to exceed the floor of the paper's matcher
  double prnu = 0.007;    ///< of the sensor with a fixed pattern (IMX363 class)
  std::uint64_t seed = 1;
};

/// Deviations over the tiles, DP px.
struct DisparitySpread {
  double sigma = 0;     ///< standard deviation, outliers included
  double robust = 0;    ///< 1.4826 times the median absolute deviation
  double temporal = 0;  ///< of two bursts' difference, robust, over sqrt(2): what varies from burst to burst
  double floor = 0;     ///< sqrt(robust^2 - temporal^2), at least 0: what merging does not reduce
};

struct LightPoint {
  double lux = 0;
  DisparitySpread one, six;  ///< from one frame, and from six merged ones
};
struct LightSweep {
  std::string matcher;  ///< its name in pipeline/disparity/matchers.h
  double prnu = 0;
  std::vector<LightPoint> points;
};

struct DepthPoint {
  double depth_m = 0;
  double sigma_dp_px = 0;    ///< from six frames, outliers included
  double depth_sigma_m = 0;  ///< the same by the slope of disparity over depth
};
struct DepthSweep {
  std::string matcher;  ///< its name in pipeline/disparity/matchers.h
  double focus_m = 0;
  std::vector<DepthPoint> points;
};

struct NoiseExperiment {
  std::vector<LightSweep> light;
  std::vector<DepthSweep> depth;
};

/// Renders the target, exposes static bursts of six (1/15 s, the ISO or a shorter time such that 18 % gray lies at
/// 0.108 of the white level), merges and matches. A minute or two. The same for any number of threads.
NoiseExperiment measure_noise(const NoiseExperimentOptions& options,
                              const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const NoiseExperiment& experiment, const NoiseExperimentOptions& options);
/// One self-contained HTML page with the plots.
std::string to_page(const NoiseExperiment& experiment, const NoiseExperimentOptions& options);

}  // namespace dualpixel::evaluation
