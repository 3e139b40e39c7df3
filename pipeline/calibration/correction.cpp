#include "pipeline/calibration/correction.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/error.h"
#include "capture/image/rows.h"
#include "pipeline/calibration/meters.h"
#include "pipeline/calibration/nodes.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kLeastSlope = 0.2;  ///< of the principal point's
constexpr double kFocusReach_per_m = 0.5;

/// Confidence and warning of a focus distance that lies outside the calibrated range.
void set_focus_confidence(const Calibration& calibration, double focus_distance_m, Correction& correction) {
  const double far = calibration.focuses.front().focus_distance_m, near = calibration.focuses.back().focus_distance_m;
  const double wanted = 1 / focus_distance_m;
  const double outside = std::max({1 / far - wanted, wanted - 1 / near, 0.0});
  if (outside <= 1e-9) return;
  correction.confidence = static_cast<float>(std::exp(-outside / kFocusReach_per_m));
  correction.warning =
      fmt::format("focus distance {} lies outside the calibrated {} to {}; the nearest calibration, {}, is used",
                  meters(focus_distance_m), meters(near), meters(far), meters(wanted < 1 / far ? far : near));
}

}  // namespace

FocusCalibration focus_at(const Calibration& calibration, double focus_distance_m) {
  const std::vector<FocusCalibration>& focuses = calibration.focuses;  // 1/z ascends
  const double wanted = 1 / focus_distance_m;
  const auto next = std::find_if(focuses.begin(), focuses.end(),
                                 [&](const FocusCalibration& f) { return 1 / f.focus_distance_m >= wanted; });
  const FocusCalibration& near = next == focuses.end() ? focuses.back() : *next;
  const FocusCalibration& far = next == focuses.begin() ? near : *(next - 1);
  const double span = 1 / near.focus_distance_m - 1 / far.focus_distance_m;
  const auto t = static_cast<float>(span > 0 && next != focuses.end() ? (wanted - 1 / far.focus_distance_m) / span : 1);
  if (t >= 1) return {focus_distance_m, 0, near.slope_dp_px_m, near.intercept_dp_px, {}, near.skew};
  FocusCalibration between{focus_distance_m, 0, node_image(), node_image(), {}, mixed(far.skew, near.skew, t)};
  for (std::size_t i = 0; i < between.slope_dp_px_m.data.size(); ++i) {
    if (far.slope_dp_px_m.data[i] == 0 || near.slope_dp_px_m.data[i] == 0) continue;
    between.slope_dp_px_m.data[i] = std::lerp(far.slope_dp_px_m.data[i], near.slope_dp_px_m.data[i], t);
    between.intercept_dp_px.data[i] = std::lerp(far.intercept_dp_px.data[i], near.intercept_dp_px.data[i], t);
  }
  return between;
}

void require_same_camera(const Camera& own, const Camera& camera, const std::string& what) {
  const auto refuse = [&](const std::string& field, const auto& expected, const auto& found) {
    throw InputError(fmt::format("{}: /camera/{}: {}: another camera; must be {}", what, field, found, expected));
  };
  if (own.name != camera.name) refuse("name", printable(own.name), printable(camera.name));
  const auto same = [&](const char* field, double expected, double found) {
    if (!(std::abs(expected - found) <= 1e-6 * std::max(std::abs(expected), std::abs(found)))) {
      refuse(field, expected, found);
    }
  };
  same("width_px", own.width_px, camera.width_px);
  same("height_px", own.height_px, camera.height_px);
  same("pixel_pitch_um", own.pixel_pitch_um, camera.pixel_pitch_um);
  same("dp_downsample_x", own.dp_downsample_x, camera.dp_downsample_x);
  same("dp_downsample_y", own.dp_downsample_y, camera.dp_downsample_y);
  same("focal_length_mm", own.focal_length_mm, camera.focal_length_mm);
  same("f_number", own.f_number, camera.f_number);
  same("principal_point_px/0", own.principal_point_px[0], camera.principal_point_px[0]);
  same("principal_point_px/1", own.principal_point_px[1], camera.principal_point_px[1]);
}

Correction make_correction(const Calibration& calibration, const Camera& camera) {
  require_same_camera(calibration.camera, camera, "capture does not fit the calibration");
  const FocusCalibration focus = focus_at(calibration, camera.focus_distance_m);
  Correction correction{node_image(1), node_image(), focus.skew, node_image(), 1, ""};
  set_focus_confidence(calibration, camera.focus_distance_m, correction);
  // the line at the principal point, between nodes that all have one
  Image slopes = focus.slope_dp_px_m, intercepts = focus.intercept_dp_px;
  fill_holes(focus.slope_dp_px_m, slopes);
  fill_holes(focus.slope_dp_px_m, intercepts);
  const double x = camera.principal_point_px[0] / camera.width_px, y = camera.principal_point_px[1] / camera.height_px;
  const double slope = bicubic(slopes, x, y), intercept = bicubic(intercepts, x, y);
  if (!(slope * focus.slope_dp_px_m.data[principal_node(camera)] > 0)) {
    throw InputError(
        fmt::format("calibration: focus distance {}: disparity at the principal point does not change "
                    "with depth: there is nothing to correct to",
                    meters(camera.focus_distance_m)));
  }
  for (std::size_t i = 0; i < slopes.data.size(); ++i) {
    const double share = focus.slope_dp_px_m.data[i] / slope;
    if (!(share >= kLeastSlope)) continue;  // also none, and a slope of the wrong sign
    correction.usable.data[i] = 1;
    correction.gain.data[i] = static_cast<float>(1 / share);
    correction.offset_dp_px.data[i] = static_cast<float>(intercept - focus.intercept_dp_px.data[i] / share);
  }
  fill_holes(correction.usable, correction.gain);
  fill_holes(correction.usable, correction.offset_dp_px);
  return correction;
}

Correction of_part(const Correction& whole, double x, double y, double width, double height) {
  Correction part = whole;
  part.skew = of_part(whole.skew, x, y, width, height);
  for (int row = 0; row < kCalibrationRows; ++row) {
    for (int column = 0; column < kCalibrationColumns; ++column) {
      const double u = x + width * column / (kCalibrationColumns - 1), v = y + height * row / (kCalibrationRows - 1);
      part.gain.at(column, row) = static_cast<float>(bicubic(whole.gain, u, v));
      part.offset_dp_px.at(column, row) = static_cast<float>(bicubic(whole.offset_dp_px, u, v));
      const int i = node_interval(u, kCalibrationColumns).first, j = node_interval(v, kCalibrationRows).first;
      part.usable.at(column, row) =
          whole.usable.at(i, j) * whole.usable.at(i + 1, j) * whole.usable.at(i, j + 1) * whole.usable.at(i + 1, j + 1);
    }
  }
  return part;
}

void correct_disparity(const Correction& correction, Image& disparity_dp_px, Image& confidence, Image* sigma_dp_px) {
  const int width = disparity_dp_px.width, height = disparity_dp_px.height;
  // first pixel of each interval of columns
  std::array<int, kCalibrationColumns> begin{};
  for (int i = 1; i < kCalibrationColumns; ++i) {
    begin[i] = std::clamp(static_cast<int>(std::ceil(1.0 * i * width / (kCalibrationColumns - 1) - 0.5)), 0, width);
  }
  begin[kCalibrationColumns - 1] = width;
  const float per_px = static_cast<float>(kCalibrationColumns - 1) / static_cast<float>(width);
  for_rows(height, [&](int y) {
    const NodeInterval row = node_interval((y + 0.5) / height, kCalibrationRows);
    const auto gains = node_row(correction.gain, row), offsets = node_row(correction.offset_dp_px, row);
    float* d = disparity_dp_px.row(y);
    float* confidences = confidence.row(y);
    float* sigma = sigma_dp_px != nullptr ? sigma_dp_px->row(y) : nullptr;
    const float *above = correction.usable.row(row.first), *below = correction.usable.row(row.first + 1);
    for (int i = 0; i + 1 < kCalibrationColumns; ++i) {
      const std::array<float, 4> gain = cubic_over(gains.data(), 1, kCalibrationColumns, i);
      const std::array<float, 4> offset = cubic_over(offsets.data(), 1, kCalibrationColumns, i);
      const bool usable = above[i] * above[i + 1] * below[i] * below[i + 1] != 0;
      const float factor = usable ? correction.confidence : 0.0f;
      for (int x = begin[i]; x < begin[i + 1]; ++x) {
        const float t = (static_cast<float>(x) + 0.5f) * per_px - static_cast<float>(i);
        const float g = evaluate(gain, t);
        d[x] = d[x] * g + evaluate(offset, t);
        confidences[x] *= factor;
        if (sigma != nullptr) sigma[x] = usable ? sigma[x] * std::abs(g) : INFINITY;
      }
    }
  });
}

}  // namespace dualpixel::pipeline
