#include "evaluation/report/report_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/folder/capture_json.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/scoring.h"
#include "evaluation/report/report_images.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kWidestPx = 1344;
constexpr float kErrorLimitDpPx = 0.5f;
constexpr float kMostGain = 64;

/// Reduces pictures of one capture to the size at which the page shows them.
struct PageSize {
  int width = 0;
  int height = 0;

  explicit PageSize(const Camera& camera) : width(std::min(kWidestPx, camera.width_px)) {
    height =
        std::max(1, static_cast<int>(std::lround(static_cast<double>(camera.height_px) * width / camera.width_px)));
  }
  Image operator()(const Image& image) const { return resized(image, width, height); }
};

/// Brings the brightest hundredth to white; never darkens.
float display_gain(const Image& linear) {
  return std::clamp(1 / std::max(percentile(linear, 0.99), 1e-6f), 1.0f, kMostGain);
}

Picture picture(const std::string& title, const std::string& caption, const Image& srgb) {
  return {title, caption, jpeg_data_uri(srgb)};
}

Image ramp(float low, float high) {
  Image values(256, 1);
  for (int x = 0; x < 256; ++x) values.at(x, 0) = std::lerp(low, high, static_cast<float>(x) / 255);
  return values;
}

Picture signed_map(const std::string& title, const std::string& caption, const Image& values, float limit) {
  return {title,
          caption,
          jpeg_data_uri(diverging_colors(values, limit)),
          jpeg_data_uri(diverging_colors(ramp(-limit, limit), limit)),
          fmt::format("{:+.1f}", -limit),
          fmt::format("{:+.1f} DP px", limit)};
}

Picture gray_map(const std::string& title, const std::string& caption, const Image& values, float limit,
                 const std::string& unit) {
  return {title,
          caption,
          jpeg_data_uri(gray_levels(values, limit)),
          jpeg_data_uri(gray_levels(ramp(0, limit), limit)),
          "0",
          fmt::format("{:.3g}{}", limit, unit)};
}

/// Over several lines; bytes that are no UTF-8 are replaced.
std::string text_of(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// estimate - truth, NaN where the truth is not valid or nothing was estimated.
Image disparity_error(const Truth& truth, const Image& estimate, const AffineFit& fit) {
  Image error(estimate.width, estimate.height);
  for (std::size_t i = 0; i < error.data.size(); ++i) {
    error.data[i] = truth.valid.data[i] == 1
                        ? static_cast<float>(fit.scale * estimate.data[i] + fit.offset - truth.disparity_dp_px.data[i])
                        : std::numeric_limits<float>::quiet_NaN();
  }
  return error;
}

/// A round number of DP px that all but the most extreme disparities stay within.
float disparity_limit(const Image& disparity) {
  Image magnitude = disparity;
  for (float& value : magnitude.data) value = std::abs(value);
  return std::max(0.5f, std::ceil(2 * percentile(magnitude, 0.995)) / 2);
}

/// Who says how far things are: the user's file, or a matcher.
std::string disparity_from(const nlohmann::json& provenance) {
  for (const auto& [field, word] : {std::pair{"disparity", "given, "}, {"matcher", "matcher "}}) {
    const auto found = provenance.find(field);
    if (found != provenance.end() && found->is_string()) return word + found->get<std::string>();
  }
  return "";
}

/// One line; what the camera does not know is left out.
std::string facts_of(const Capture& capture) {
  const Camera& camera = capture.camera;
  std::string facts = fmt::format("{}: {} × {} photosites", printable(camera.name), camera.width_px, camera.height_px);
  if (camera.focal_length_mm > 0 && camera.f_number > 0) {
    facts += fmt::format(", f = {:.3g} mm, f/{:.3g}", camera.focal_length_mm, camera.f_number);
  }
  facts += fmt::format(", focused at {:.3g} m", camera.focus_distance_m);
  if (capture.exposure.time_s > 0) {
    facts += fmt::format("; {:.3g} s at ISO {:.0f}", capture.exposure.time_s, capture.exposure.iso);
  }
  return facts + fmt::format("; {} frame{}", capture.frames.size(), capture.frames.size() == 1 ? "" : "s");
}

std::vector<Picture> result_maps(const pipeline::PortraitResult& result, const std::optional<Truth>& truth,
                                 const std::optional<Score>& score, const PageSize& to_page) {
  std::vector<Picture> maps;
  if (!result.disparity_dp_px.empty()) {
    const Image estimate = to_page(result.disparity_dp_px);
    const Image true_disparity = truth ? to_page(truth->disparity_dp_px) : Image();
    const float limit = disparity_limit(truth ? true_disparity : estimate);
    maps.push_back(
        signed_map("Estimated disparity", "Blue is in front of the focus plane, orange behind.", estimate, limit));
    if (truth) {
      const Image seen = disparity_seen_from_first(result, *truth);
      maps.push_back(signed_map("True disparity", "From geometry and optics.", true_disparity, limit));
      maps.push_back(signed_map("Error", "Estimate minus truth; gray where nothing was hit.",
                                to_page(disparity_error(*truth, seen, {})), kErrorLimitDpPx));
      if (const std::optional<AffineFit>& fit = score->disparity.front().fit) {
        maps.push_back(signed_map("Error after the affine fit",
                                  fmt::format("{:.3f} × estimate {:+.3f}, minus truth.", fit->scale, fit->offset),
                                  to_page(disparity_error(*truth, seen, *fit)), kErrorLimitDpPx));
      }
    }
    maps.push_back(gray_map("Confidence", "Of the estimated disparity.", to_page(result.confidence), 1, ""));
  }
  if (!result.mask.empty()) maps.push_back(gray_map("Person mask", "After filtering.", to_page(result.mask), 1, ""));
  if (!result.blur_radius_px.empty()) {
    const Image radius = to_page(result.blur_radius_px);
    maps.push_back(
        gray_map("Blur radius", "Of the synthetic defocus.", radius, std::max(1.0f, percentile(radius, 0.995)), " px"));
  }
  return maps;
}

}  // namespace

CaptureSection make_capture_section(const Capture& capture, const std::string& path) {
  const Camera& camera = capture.camera;
  CaptureSection section;
  section.name = path;
  section.facts = facts_of(capture);
  const PageSize to_page(camera);
  const Frame& frame = capture.frames.front();
  const Image left = to_page(normalized(frame.left, capture.exposure));
  const Image right = to_page(normalized(frame.right, capture.exposure));
  const float gain = display_gain(left);
  const std::string caption = fmt::format(
      "The two dual-pixel views of the first frame, shown at a gain of {:.3g}. "
      "What moves between them is out of focus.",
      gain);
  section.flicker = {picture("left view", caption, displayed(left, gain)),
                     picture("right view", caption, displayed(right, gain))};
  section.provenance = text_of(to_json(capture.provenance, path));
  return section;
}

ResultSection make_result_section(const Capture& capture, const std::string& capture_path,
                                  const pipeline::StoredResult& stored, const std::string& result_path) {
  const pipeline::PortraitResult& result = stored.result;
  const std::optional<Truth>& truth = capture.truth;
  ResultSection section;
  section.name = result_path;
  section.provenance = text_of(stored.json["provenance"]);
  section.stages = result.stages;
  section.mode = stored.mode;
  section.disparity_from = disparity_from(stored.json["provenance"]);
  if (truth) section.score = score_result(capture, capture_path, stored, result_path);

  const PageSize to_page(capture.camera);
  const float gain = display_gain(to_page(truth ? truth->photograph : result.input));
  const std::string caption = fmt::format("All shown at a gain of {:.3g}. Drag the divider.", gain);
  const auto add = [&](const char* title, const Image& linear) {
    section.photographs.push_back(picture(title, caption, displayed(to_page(linear), gain)));
  };
  add("portrait", result.portrait);
  add("input, not blurred", result.input);
  if (truth) add("true photograph", truth->photograph);

  section.maps = result_maps(result, truth, section.score, to_page);
  return section;
}

}  // namespace dualpixel::evaluation
