#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "pipeline/portrait/result_io.h"

/// How well a portrait result agrees with the simulator's truth.
///
/// Truth is the first frame's. Where a result's base is a later frame, its maps and pictures are first resampled along
/// the true motion to where the first frame sees the same points. What falls outside of the base frame counts as not
/// estimated in the maps; pictures are extended by their border pixels.
namespace dualpixel::evaluation {

inline constexpr float kConfidentThreshold = 0.5f;
inline constexpr float kEdgeJumpDpPx = 0.1f;
inline constexpr int kEdgeReachPx = 8;
inline constexpr float kPersonThreshold = 0.5f;

/// Noise of the truth that changes a score by more is worth a warning.
inline constexpr double kMostTruthNoiseDb = 0.1;
/// Where a picture errs by hardly more than that noise, or by less, it is said to take so much.
inline constexpr double kTruthNoiseLimitDb = 20;

/// Thresholds of the bad-pixel rates, DP px.
inline constexpr double kBadPixelDpPx[] = {0.1, 0.25, 0.5};

/// What a method of anybody's making found in a capture; what is empty is not scored. Maps have the full sensor's size
/// or the views', each of whose pixels then stands for the photosites that it covers. They are the first frame's.
struct Estimate {
  Image disparity_dp_px;  ///< in DP pixels at either size; not finite: not estimated
  Image confidence;       ///< 0 to 1, larger is surer; "confident" from 0.5 on
  Image sigma_dp_px;      ///< predicted standard deviation of the error; stands in for a confidence that is missing
  Image portrait;         ///< linear RGB in the truth's signal, of the full sensor's size
};

/// Disparity over one region, DP px. Figures are none where the region holds no pixel.
struct RegionScore {
  std::string region;
  std::size_t pixels = 0;          ///< with valid truth and a finite estimate
  std::optional<double> coverage;  ///< pixels over all pixels with valid truth
  std::optional<double> bias_px, rmse_px;
  std::optional<double> bad[3];  ///< share of pixels whose error exceeds kBadPixelDpPx
  // After the least-squares affine fit to the truth of this region:
  std::optional<AffineFit> fit;
  std::optional<double> rmse_affine_px;  ///< AIWE(2) of Garg et al. 2019
  std::optional<double> bad_affine[3];
  std::optional<double> aiwe1;
  std::optional<double> one_minus_rho;  ///< 1 - |Spearman's rho|, average ranks for ties; none where a side is constant
  Sparsification sparsification;        ///< of the absolute error after the fit, by confidence; empty without one
  /// Shares, of the pixels with a sigma, whose error, before the fit, is within so many of it: 0.683 and 0.954 where
  /// sigma is right and errors are normal. None without sigma.
  std::optional<double> within_one_sigma, within_two_sigma;
};

/// A picture against the true photograph through the wider aperture. Linear: signal clipped to 0..1; sRGB: the same,
/// encoded. PSNR is none where the pictures are identical, SSIM where they are smaller than its window.
struct PictureScore {
  std::optional<double> psnr_srgb_db, psnr_linear_db, ssim_srgb, ssim_linear;
};

struct Score {
  std::string capture, result;  ///< paths
  std::string mode;             ///< as the result records it, or "unknown"
  /// Where the truth is valid and the estimate finite: "everything"; "confident", confidence >= 0.5; "depth_edges", at
  /// most 8 full-resolution px from a jump of the true disparity by more than 0.1 DP px; "person", true person mask >
  /// 0.5. Empty where there is no disparity. "confident" is absent without confidence; where sigma stands in for it, it
  /// is sigma < 0.2 DP px.
  std::vector<RegionScore> disparity;
  std::optional<PictureScore> portrait, input;  ///< where there is such a picture; input: before the synthetic defocus
  /// By how much the rendering noise of the true photograph lowers psnr_linear_db of the portrait or of the input,
  /// whichever suffers more; none where the noise is not known, or nothing differs.
  std::optional<double> truth_noise_db;
  std::vector<pipeline::StageTime> stages;
  std::vector<std::string> notes;  ///< why a figure is none: one line each
};

/// A picture or map of the result, which may show a later frame, where the first frame sees it, as truth does. Outside
/// of that later frame: its border, or `outside` where that is given.
Image seen_from_first(const Image& image, const pipeline::PortraitResult& result, const Truth& truth,
                      std::optional<float> outside = {});

/// `capture_path` and `result_path` are named in messages and in the score. Throws InputError where the capture holds
/// no truth or the sizes differ.
Score score_result(const Capture& capture, const std::string& capture_path, const pipeline::StoredResult& stored,
                   const std::string& result_path);

/// What was found by other means than the portrait pipeline. Throws InputError where the capture holds no truth,
/// nothing is given, confidence or sigma is given without disparity, confidence lies outside [0, 1], sigma below 0, or
/// sizes differ: all that is wrong in one line.
Score score_estimate(const Capture& capture, const std::string& capture_path, const Estimate& estimate);

/// score.json: `disparity.REGION.METRIC` (absent in mode seg), `image.METRIC`, `stages.NAME.ms` and .peak_rss_mb,
/// notes. Figures that are none are null; those of what was not given are absent. image.psnr_db, .ssim and their _input
/// are the sRGB ones; aiwe2 repeats rmse_affine_px.
nlohmann::ordered_json to_json(const Score& score);

/// The same as text for a terminal.
std::string to_text(const Score& score);

}  // namespace dualpixel::evaluation
