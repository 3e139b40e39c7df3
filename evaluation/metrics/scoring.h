#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "capture/capture.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "pipeline/portrait/result_io.h"

/// How well a portrait result agrees with what the simulator knows.
///
///   disparity.<region>.<metric>   absent in mode seg. Regions, all where the truth is valid and the estimate finite:
///       everything
///       confident     confidence >= 0.5
///       depth_edges   at most 8 full-resolution px from a jump of the true disparity by more than 0.1 DP px
///       person        true person mask > 0.5
///     pixels, coverage (pixels over all valid ones), bias_px, rmse_px, bad_0p1, bad_0p25, bad_0p5 (share of pixels
///     that err by more than that many DP px); after the least-squares affine fit to the truth of that very region:
///     affine_scale, affine_offset_px, rmse_affine_px (Garg's AIWE(2), also given as aiwe2), bad_*_affine; aiwe1;
///     one_minus_rho_average_ranks (1 - |Spearman's rho|, ties get average ranks); ause and sparsification (of the
///     absolute error after the fit, by confidence).
///   image.<metric>   against the true photograph through the wider aperture, of the portrait and of the un-blurred
///     input: psnr_srgb_db, psnr_linear_db, ssim_srgb, ssim_linear, and each as <metric>_input. Linear: signal clipped
///     to 0..1. sRGB: the same, encoded. psnr_db, psnr_input_db, ssim, ssim_input are the sRGB ones.
///   stages.<name>.ms, .peak_rss_mb
///   notes   why a figure is null: one line each
///
/// Truth is the first frame's. Where a result's base is a later one, its maps and pictures are first looked up where
/// truth says that frame sees the first one's points. What lies outside of it counts as not estimated in the maps; the
/// pictures go on there as their border does.
namespace dualpixel::evaluation {

inline constexpr float kConfidentThreshold = 0.5f;
inline constexpr float kEdgeJumpDpPx = 0.1f;
inline constexpr int kEdgeReachPx = 8;
inline constexpr float kPersonThreshold = 0.5f;

/// The result's disparity where the first frame sees it; not a number outside of the frame that it was estimated for.
Image disparity_seen_from_first(const pipeline::PortraitResult& result, const Truth& truth);

/// Figures as above. `capture_path` and `result_path` are named in messages and in the figures. Throws InputError where
/// the capture holds no truth or the sizes differ.
nlohmann::ordered_json score_result(const Capture& capture, const std::string& capture_path,
                                    const pipeline::StoredResult& stored, const std::string& result_path);

/// The same as text for a terminal.
std::string score_table(const nlohmann::ordered_json& score);

}  // namespace dualpixel::evaluation
