#pragma once
#include <cmath>

#include "capture/capture.h"
#include "pipeline/portrait/result_io.h"

/// A capture and a portrait result made without simulator and pipeline: small, and with figures known by construction.
namespace dualpixel::pipeline {

/// width x height photosites. The left half lies at disparity -1, the right half on a ramp from 0.5 to 1.5; a person
/// fills the top left quarter; the bottom row was hit by nothing. The photograph is a smooth pattern.
inline Capture synthetic_capture(int width = 64, int height = 48) {
  Capture capture;
  Camera& camera = capture.camera;
  camera.name = "synthetic";
  camera.width_px = width;
  camera.height_px = height;
  camera.pixel_pitch_um = 1.4;
  camera.focal_length_mm = 4.4;
  camera.f_number = 1.8;
  camera.focus_distance_m = 1;
  camera.principal_point_px = {width / 2.0, height / 2.0};
  camera.alpha = 0.21;
  capture.exposure.bits = 10;
  capture.exposure.black_level_dn = 64;
  capture.exposure.white_level_dn = 1023;
  Frame& frame = capture.frames.emplace_back();
  frame.mosaic = ImageU16(width, height, 1, 500);
  frame.left = ImageU16(camera.dp_width(), camera.dp_height(), 1, 300);
  frame.right = ImageU16(camera.dp_width(), camera.dp_height(), 1, 250);

  Truth& truth = capture.truth.emplace();
  truth.depth_m = truth.blur_px = truth.disparity_dp_px = truth.person_mask = truth.valid = Image(width, height);
  truth.object_id = ImageU32(width, height);
  truth.normal = truth.all_in_focus = truth.photograph = Image(width, height, 3);
  truth.photograph_aperture_scale = 4;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool valid = y < height - 1;
      const int middle = width / 2;
      const bool left = x < middle;
      truth.valid.at(x, y) = valid ? 1.0f : 0.0f;
      truth.depth_m.at(x, y) = valid ? (left ? 0.5f : 2.0f) : INFINITY;
      truth.disparity_dp_px.at(x, y) = left ? -1.0f : 0.5f + (x - middle) / (middle - 1.0f);
      truth.person_mask.at(x, y) = left && y < height / 2 ? 1.0f : 0.0f;
      truth.object_id.at(x, y) = valid ? 1 : 0;
      truth.normal.at(x, y, 2) = valid ? -1.0f : 0.0f;
      for (int c = 0; c < 3; ++c) {
        truth.photograph.at(x, y, c) = 0.4f + 0.2f * std::sin(0.2f * x + c) * std::cos(0.3f * y);
      }
    }
  }
  return capture;
}

/// Estimated disparity = (truth - 0.2) / 2, confidence 1 in the top half and 0.25 below, portrait = photograph + 0.1
/// and input = photograph + 0.2, in linear light.
inline PortraitResult synthetic_result(const Capture& capture) {
  const Truth& truth = *capture.truth;
  const int width = capture.camera.width_px, height = capture.camera.height_px;
  PortraitResult result;
  result.input = result.portrait = result.portrait_srgb = truth.photograph;
  for (float& value : result.input.data) value += 0.2f;
  for (float& value : result.portrait.data) value += 0.1f;
  result.disparity_dp_px = truth.disparity_dp_px;
  for (float& value : result.disparity_dp_px.data) value = (value - 0.2f) / 2;
  result.confidence = Image(width, height, 1, 1.0f);
  for (int y = height / 2; y < height; ++y) std::fill_n(result.confidence.row(y), width, 0.25f);
  result.blur_radius_px = Image(width, height, 1, 3.0f);
  result.matched_disparity_dp_px = Image(capture.camera.dp_width(), capture.camera.dp_height(), 1, -0.75f);
  result.matched_confidence = Image(capture.camera.dp_width(), capture.camera.dp_height(), 1, 0.5f);
  result.focus_disparity_dp_px = -0.125;
  result.stages = {{"merge", 12.5, 300}, {"blur", 20.25, 350}};
  return result;
}

/// As read_result() would give it.
inline StoredResult synthetic_stored(const Capture& capture) {
  const nlohmann::json stages = {{{"name", "merge"}, {"ms", 12.5}, {"peak_rss_mb", 300}}};
  return {synthetic_result(capture), {{"provenance", {{"mode", "dp"}}}, {"stages", stages}}, "dp"};
}

}  // namespace dualpixel::pipeline
