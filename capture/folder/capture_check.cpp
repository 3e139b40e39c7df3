#include "capture/folder/capture_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "capture/error.h"
#include "capture/views.h"

namespace dualpixel {

CaptureCheck::CaptureCheck(std::string where) : where_(std::move(where)) {}

void CaptureCheck::require(bool holds, const std::string& field, const std::string& why) const {
  if (!holds) throw InputError(fmt::format("{}: {}: {}", printable(where_), field, why));
}

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check_frame(const Frame& frame, const Capture& capture, const std::string& field, const CaptureCheck& check) {
  const Camera& camera = capture.camera;
  if (!frame.mosaic.empty()) check.require_size(frame.mosaic, camera.width_px, camera.height_px, 1, field + "/mosaic");
  check.require(frame.mosaic.empty() == capture.frames.front().mosaic.empty(), field + "/mosaic",
                "either every frame has a mosaic or none");
  check.require(frame.left.empty() == capture.frames.front().left.empty(), field + "/left",
                "either every frame has views or none");
  if (has_views(capture) || frame.mosaic.empty()) {
    check.require_size(frame.left, camera.dp_width(), camera.dp_height(), 1, field + "/left");
    check.require_size(frame.right, camera.dp_width(), camera.dp_height(), 1, field + "/right");
  }
  const int largest = (1 << capture.exposure.bits) - 1;
  for (const ImageU16* image : {&frame.mosaic, &frame.left, &frame.right}) {
    const auto high = std::max_element(image->data.begin(), image->data.end());
    check.require(
        image->empty() || *high <= largest, field,
        fmt::format("holds the digital number {}, beyond {} bits", image->empty() ? 0 : *high, capture.exposure.bits));
  }
  for (const double value : frame.camera_from_world) {
    check.require(std::isfinite(value), field + "/camera_from_world", "must be finite");
  }
}

void check_truth(const Truth& truth, const Camera& camera, const CaptureCheck& check) {
  const int width = camera.width_px, height = camera.height_px;
  check.require(truth.photograph_aperture_scale > 0, "/truth/photograph_aperture_scale", "must be positive");
  check.require_size(truth.depth_m, width, height, 1, "/truth/Z");
  check.require_size(truth.blur_px, width, height, 1, "/truth/blur_px");
  check.require_size(truth.disparity_dp_px, width, height, 1, "/truth/disparity_dp_px");
  check.require_size(truth.normal, width, height, 3, "/truth/N");
  check.require_size(truth.object_id, width, height, 1, "/truth/id");
  check.require_size(truth.person_mask, width, height, 1, "/truth/person");
  check.require_size(truth.valid, width, height, 1, "/truth/valid");
  check.require_size(truth.all_in_focus, width, height, 3, "/truth/all_in_focus");
  check.require_size(truth.photograph, width, height, 3, "/truth/photograph");

  for (std::size_t i = 0; i < truth.motion.size(); ++i) {
    const std::string field = fmt::format("/truth/motion/{}", i);
    check.require_size(truth.motion[i], width, height, 2, field);
    check.require(std::none_of(truth.motion[i].data.begin(), truth.motion[i].data.end(),
                               [](float v) { return std::isnan(v) || v == -kInfinity; }),
                  field, "must be finite, or infinite behind the camera");
  }
  if (!truth.left.empty() || !truth.right.empty()) {
    check.require_size(truth.left, width, height, 3, "/truth/views");
    check.require_size(truth.right, width, height, 3, "/truth/views");
  }
  const auto sigma_or_none = [&](const Image& sigma, const char* field) {
    if (!sigma.empty()) check.require_size(sigma, width, height, 1, field);
    check.require(std::all_of(sigma.data.begin(), sigma.data.end(), [](float v) { return v >= 0 && std::isfinite(v); }),
                  field, "must be finite and 0 or more");
  };
  sigma_or_none(truth.views_sigma, "/truth/views/sigma");
  sigma_or_none(truth.all_in_focus_sigma, "/truth/all_in_focus/sigma");
  sigma_or_none(truth.photograph_sigma, "/truth/photograph/sigma");
  sigma_or_none(truth.render_sigma, "/truth/render_sigma");
  if (!truth.samples.empty() || !truth.render_sigma.empty()) {
    check.require_size(truth.samples, width, height, 1, "/truth/samples");
    check.require_size(truth.render_sigma, width, height, 1, "/truth/render_sigma");
  }

  const auto all = [](const Image& image, auto holds) {
    return std::all_of(image.data.begin(), image.data.end(), holds);
  };
  const auto finite = [](float v) { return std::isfinite(v); };
  check.require(all(truth.valid, [](float v) { return v == 0 || v == 1; }), "/truth/valid", "must be 0 or 1");
  check.require(all(truth.person_mask, [](float v) { return v >= 0 && v <= 1; }), "/truth/person",
                "must lie in [0, 1]");
  check.require(all(truth.blur_px, finite), "/truth/blur_px", "must be finite");
  check.require(all(truth.disparity_dp_px, finite), "/truth/disparity_dp_px", "must be finite");
  check.require(all(truth.normal, finite), "/truth/N", "must be finite");
  check.require(all(truth.all_in_focus, finite), "/truth/all_in_focus", "must be finite");
  check.require(all(truth.photograph, finite), "/truth/photograph", "must be finite");
  check.require(all(truth.left, finite) && all(truth.right, finite), "/truth/views", "must be finite");
  check.require(all(truth.samples, [](float v) { return v >= 1 && v <= 65536; }), "/truth/samples",
                "must lie in [1, 65536]");
  for (std::size_t i = 0; i < truth.depth_m.data.size(); ++i) {
    const float depth_m = truth.depth_m.data[i];
    check.require(truth.valid.data[i] == 1 ? depth_m > 0 && std::isfinite(depth_m) : depth_m == kInfinity, "/truth/Z",
                  "must be positive and finite where valid is 1, infinite where it is 0");
  }
}

}  // namespace

void check_capture(const Capture& capture, const CaptureCheck& check) {
  const Camera& camera = capture.camera;
  check.require(camera.width_px % 2 == 0, "/camera/width_px", fmt::format("{}: must be even", camera.width_px));
  check.require(camera.height_px % 4 == 0, "/camera/height_px",
                fmt::format("{}: must be a multiple of 4", camera.height_px));
  check.require(camera.width_px % camera.dp_downsample_x == 0, "/camera/dp_downsample_x",
                fmt::format("{}: must divide width_px, {}", camera.dp_downsample_x, camera.width_px));
  check.require(camera.height_px % camera.dp_downsample_y == 0, "/camera/dp_downsample_y",
                fmt::format("{}: must divide height_px, {}", camera.dp_downsample_y, camera.height_px));
  check.require(
      camera.focus_distance_m > camera.focal_length_mm * 1e-3, "/camera/focus_distance_m",
      fmt::format("{:g} m lies inside the focal length of {:g} mm", camera.focus_distance_m, camera.focal_length_mm));
  const Exposure& exposure = capture.exposure;
  check.require(exposure.white_level_dn <= (1 << exposure.bits) - 1, "/exposure/white_level_dn",
                fmt::format("{:g} is beyond {} bits", exposure.white_level_dn, exposure.bits));
  check.require(
      exposure.black_level_dn < exposure.white_level_dn, "/exposure/black_level_dn",
      fmt::format("{:g} must be below the white level {:g}", exposure.black_level_dn, exposure.white_level_dn));
  for (const auto& [level_dn, field] : {std::pair{exposure.mosaic_white_level_dn, "/exposure/mosaic_white_level_dn"},
                                        {exposure.dp_white_level_dn, "/exposure/dp_white_level_dn"}}) {
    const double clips = level_dn.value_or(exposure.white_level_dn);
    check.require(clips > exposure.black_level_dn && clips <= exposure.white_level_dn, field,
                  fmt::format("{:g} must lie above the black level {:g}, and not above the white level {:g}", clips,
                              exposure.black_level_dn, exposure.white_level_dn));
  }
  check.require(std::all_of(exposure.white_balance.begin(), exposure.white_balance.end(),
                            [](double gain) { return gain > 0 && std::isfinite(gain); }),
                "/exposure/white_balance",
                fmt::format("gains {} must be positive", fmt::join(exposure.white_balance, ", ")));
  check.require(!exposure.color_matrix || std::abs(determinant(*exposure.color_matrix)) > 1e-6,
                "/exposure/color_matrix", "must have an inverse");
  check.require(!capture.frames.empty() && capture.frames.size() <= kMostFrames, "/frames",
                fmt::format("{} frames; 1 to {} are allowed", capture.frames.size(), kMostFrames));
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    check_frame(capture.frames[i], capture, fmt::format("/frames/{}", i), check);
  }
  if (!capture.truth) return;
  check_truth(*capture.truth, camera, check);
  const std::size_t moved = capture.truth->motion.size();
  check.require(moved == 0 || moved == capture.frames.size() - 1, "/truth/motion",
                fmt::format("{} of them: one for each frame but the first, or none", moved));
}

}  // namespace dualpixel
