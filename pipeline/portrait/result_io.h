#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/portrait/result.h"

/// A portrait result on disk. A folder, written to a temporary sibling and renamed:
///   result.json              format, version, provenance, focus_disparity_dp_px, base_frame, stages [{name, ms,
///                            peak_rss_mb}]
///   input.exr portrait.exr   linear RGB (half float)
///   portrait.png             8-bit sRGB
///   maps.exr                 full size, float: those of disparity_dp_px, confidence, mask, blur_radius_px that exist
///   matched.exr              DP size, float: disparity_dp_px, confidence and, where the matcher predicts it,
///                            sigma_dp_px; absent in mode seg
namespace dualpixel::pipeline {

struct StoredResult {
  PortraitResult result;
  nlohmann::json json;  ///< result.json, unchanged
  std::string mode;     ///< "dp", "dp+seg" or "seg"; empty where its provenance does not say
};

inline constexpr int kResultFormatVersion = 1;

/// What result.json holds.
nlohmann::ordered_json to_json(const PortraitResult& result, const nlohmann::ordered_json& provenance);

/// `provenance` records how the result was made: "mode" ("dp", "dp+seg", "seg"), "capture" (the capture's folder),
/// "capture_hash" (of its capture.json), all options. Throws InputError where `path` exists and is no result, or cannot
/// be written.
void write_result(const PortraitResult& result, const nlohmann::ordered_json& provenance, const std::string& path);

/// Reads a result and checks that the pictures and maps of full size agree in size, and that it has the disparity that
/// its mode makes. Throws InputError.
StoredResult read_result(const std::string& path);

/// Throws InputError where the capture is another than the result was made from, or has changed since: two of one size
/// would make a table of nonsense; so is a plain pair that is not the views of the capture's first frame. A result
/// without a hash (of another program) is taken at its word.
void require_own_capture(const StoredResult& stored, const std::string& capture_path, const std::string& result_path);

}  // namespace dualpixel::pipeline
