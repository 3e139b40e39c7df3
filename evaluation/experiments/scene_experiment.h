#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/metrics/image_statistics.h"

/// Drawn scenes (scenes/drawn/draw_scene.h) one seed after the other: whether each draws, loads and renders without a
/// warning, what that costs, and the statistics by which its picture is compared with photographs.
namespace dualpixel::evaluation {

struct SceneExperimentOptions {
  std::string kind;
  std::uint64_t first_seed = 1;
  int count = 36;
  int width_px = 256;          ///< of the pictures, a multiple of 16 from 64; 3/4 as high
  int samples_per_pixel = 64;  ///< in four parts with noise of their own; a multiple of 4
};

struct DrawnSceneResult {
  std::uint64_t seed = 0;
  std::vector<std::string> faults;  ///< warnings, and what was thrown; empty: none
  double draw_cpu_s = 0, draw_s = 0, draw_peak_mb = 0, render_s = 0;
  bool rendered = false;       ///< what follows is set
  double slope = 0;            ///< amplitude_slope() of log luminance
  GradientMoments gradients;   ///< of log luminance
  double contrast = 0;         ///< deviation of log luminance
  std::vector<float> depth_m;  ///< of all pixels that show a surface
  double sky = 0;              ///< share of pixels that show none
  Image thumbnail;             ///< sRGB, as exposed and one stop brighter; empty beyond the sheet's
};

struct SceneExperiment {
  std::vector<DrawnSceneResult> scenes;
  Image sheet;  ///< the first 36 side by side, sRGB
};

/// `scratch`: a folder for the scene under test. The same for any number of threads, times apart.
SceneExperiment measure_scenes(const SceneExperimentOptions& options, const std::string& scratch,
                               const std::function<void(double fraction)>& progress = {});

nlohmann::ordered_json to_json(const SceneExperiment& experiment, const SceneExperimentOptions& options);

}  // namespace dualpixel::evaluation
