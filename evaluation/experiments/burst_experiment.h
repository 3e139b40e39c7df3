#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"

/// Bursts from end to end: what aligning and merging 1 to 15 frames leaves of the noise, and what it does to what is
/// made of them, where nothing moves, where the hand shakes, an arm moves, or the light flickers. The scene: a card
/// before a wall, both textured, on each side of the focus, through the paper's phone.
namespace dualpixel::evaluation {

/// What a merge leaves. Errors are against the clean pictures: RMS, over that of the first frame.
struct MergeError {
  double views_kept = 0;
  double mosaic_kept = 0;
  double ghost_share = 0;  ///< of squares of 4 x 4 DP px: their mean is off by 4 sigma and more of the first frame's
  double cpu_s = 0;        ///< aligning and merging
};

/// With so many frames of a burst.
struct BurstPoint {
  int frames = 0;
  MergeError merge;         ///< the pipeline's
  MergeError six_channels;  ///< merge_six_channels(), to compare with
  struct Disparity {
    std::string matcher;
    double error_68_dp_px = 0;  ///< what 68 % of the pixels stay under
  };
  std::vector<Disparity> disparity;
  /// Of the portrait, without its synthetic noise, against that of all frames at rest: PSNR of the sRGB pictures.
  /// None where the portrait takes another frame than the first as its base: it shows another pose.
  std::optional<double> portrait_db;
};

struct BurstSweep {
  std::string condition;  ///< "still", "shake", "arm", "flicker"
  double lux = 0;
  std::vector<BurstPoint> points;
};

inline constexpr int kBurstFrames[] = {1, 2, 3, 4, 6, 8, 10, 15};

/// Every condition at 5 and at 100 lux; "still" is the first of each. Results but times are the same for any number of
/// threads.
std::vector<BurstSweep> measure_bursts(const std::function<void(double fraction)>& progress = {});

/// The burst of "shake". Draws differ in textures and in noise.
Capture take_shaken_burst(double lux, unsigned draw);

/// What aligning and merging leaves and costs, without what is made of it: no disparity, no portrait. The burst has
/// truth.
std::vector<BurstPoint> measure_merge(const Capture& burst, const std::vector<int>& frames);

/// Points of one burst; `registered`: a burst of the same scene at rest. Both hold truth.
std::vector<BurstPoint> measure_burst(const Capture& burst, const Capture& registered, const std::vector<int>& frames);

nlohmann::ordered_json to_json(const std::vector<BurstSweep>& sweeps);
/// One self-contained HTML page with the plots.
std::string to_page(const std::vector<BurstSweep>& sweeps);

}  // namespace dualpixel::evaluation
