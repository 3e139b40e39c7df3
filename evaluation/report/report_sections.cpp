#include "evaluation/report/report_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/folder/capture_json.h"
#include "capture/views.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/scoring.h"
#include "evaluation/report/report_images.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kErrorLimitDpPx = 0.5;
constexpr float kMostGain = 64;
constexpr double kFineStep = 1.0 / 256;  ///< of confidence and masks, which need no more

/// Pictures as wide as the page shows them.
Image page_sized(const Image& picture) {
  const int width = std::min(kViewerWidthPx, picture.width);
  const double ratio = static_cast<double>(picture.height) / picture.width;
  return resized(picture, width, std::max(1, static_cast<int>(std::lround(width * ratio))));
}

/// Brings the brightest hundredth to white; never darkens.
float display_gain(const Image& linear) {
  return std::clamp(1 / std::max(percentile(linear, 0.99), 1e-6f), 1.0f, kMostGain);
}

/// Over several lines; bytes that are no UTF-8 are replaced.
std::string text_of(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Strings that are paths of the machine become paths from the page.
nlohmann::json with_page_paths(nlohmann::json json, const std::string& page_folder) {
  if (json.is_string()) {
    const std::string text = json.get<std::string>();
    if (text.starts_with('/')) json = path_from_page(text, page_folder);
  } else if (json.is_structured()) {
    for (nlohmann::json& entry : json) entry = with_page_paths(entry, page_folder);
  }
  return json;
}

/// NaN where nothing was hit.
Image known_disparity(const Truth& truth) {
  Image disparity = truth.disparity_dp_px;
  for (std::size_t i = 0; i < disparity.data.size(); ++i) {
    if (truth.valid.data[i] != 1) disparity.data[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return disparity;
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
  if (camera.focus_distance_m > 0) facts += fmt::format(", focused at {:.3g} m", camera.focus_distance_m);
  if (capture.exposure.time_s > 0) {
    facts += fmt::format("; {:.3g} s at ISO {:.0f}", capture.exposure.time_s, capture.exposure.iso);
  }
  return facts + fmt::format("; {} frame{}", capture.frames.size(), capture.frames.size() == 1 ? "" : "s");
}

ViewerLayer& layer_named(Viewer& viewer, const std::string& name) {
  return *std::find_if(viewer.layers.begin(), viewer.layers.end(),
                       [&](const ViewerLayer& layer) { return layer.name == name; });
}

/// All that a page can show of a capture and its results, in the order of the keys; what there is none of is left out.
std::vector<ViewerLayer> report_layers() {
  using Colors = LayerColors;
  std::vector<ViewerLayer> layers = {
      {"Left view", "What the left half-pixels saw in the first frame. What moves between the views is out of focus.",
       "DN", Colors::light, 0, 1, 1},
      {"Right view", "What the right half-pixels saw in the first frame.", "DN", Colors::light, 0, 1, 1},
      {"Picture", "The merged burst, not blurred.", "sRGB"},
      {"Portrait", "The result.", "sRGB"},
      {"True photograph", "What a lens with a wider pupil takes of the scene.", "sRGB"},
      {"Disparity", "As estimated. Blue is in front of the focus plane, orange behind.", "DP px", Colors::diverging},
      {"True disparity", "From geometry and optics; gray where nothing was hit.", "DP px", Colors::diverging},
      {"Error", "Estimated minus true disparity.", "DP px", Colors::diverging, 0, kErrorLimitDpPx},
      {"Confidence", "Of the estimated disparity.", "", Colors::gray, 0, 1, kFineStep},
      {"Blur radius", "Of the synthetic defocus.", "px", Colors::gray, 0, 1, 1.0 / 16},
      {"Person mask", "After filtering.", "", Colors::gray, 0, 1, kFineStep},
      {"Error after fit", "Scale times estimate plus offset, minus truth: the least squares of each result.", "DP px",
       Colors::diverging, 0, kErrorLimitDpPx}};
  for (ViewerLayer& layer : layers) {
    for (const auto& [name, against] : {std::pair{"Left view", "Right view"},
                                        {"Right view", "Left view"},
                                        {"Picture", "Portrait"},
                                        {"Portrait", "True photograph"},
                                        {"Disparity", "True disparity"}}) {
      if (layer.name == name) layer.against = against;
    }
  }
  return layers;
}

/// Scale and offset of the affine fit; (1, 0) where there is none.
std::pair<double, double> fit_of(const std::optional<Score>& score) {
  if (!score || score->disparity.empty() || !score->disparity.front().fit) return {1, 0};
  const AffineFit& fit = *score->disparity.front().fit;
  return {fit.scale, fit.offset};
}

}  // namespace

std::string path_from_page(const std::string& path, const std::string& folder) {
  namespace fs = std::filesystem;
  const fs::path full = fs::absolute(path).lexically_normal();
  const fs::path relative = full.lexically_relative(fs::absolute(folder).lexically_normal());
  const auto up = std::count(relative.begin(), relative.end(), fs::path(".."));
  if (!relative.empty() && up <= 1) return relative.string();
  return (full.has_filename() ? full : full.parent_path()).filename().string();
}

CaptureSection make_capture_section(const Capture& capture, const std::string& path, const std::string& page_folder) {
  CaptureSection section;
  section.name = path_from_page(path, page_folder);
  section.facts = facts_of(capture);
  section.provenance = text_of(with_page_paths(to_json(capture.provenance, path), page_folder));
  Viewer& viewer = section.viewer;
  viewer.width = capture.camera.width_px;
  viewer.height = capture.camera.height_px;
  viewer.layers = report_layers();
  if (!has_views(capture)) return section;
  const Frame& frame = capture.frames.front();
  const double black = capture.exposure.black_level_dn, range = capture.exposure.white_level_dn - black;
  const double white = black + range / display_gain(normalized(frame.left, capture.exposure));
  for (const auto& [name, raw] : {std::pair{"Left view", &frame.left}, {"Right view", &frame.right}}) {
    ViewerLayer& layer = layer_named(viewer, name);
    layer.low = black;
    layer.high = white;
    Image& numbers = layer.images.emplace_back(raw->width, raw->height);
    std::copy(raw->data.begin(), raw->data.end(), numbers.data.begin());
  }
  return section;
}

void add_result(CaptureSection& section, const Capture& capture, const std::string& capture_path,
                const pipeline::StoredResult& stored, const std::string& result_path, const std::string& page_folder) {
  const pipeline::PortraitResult& result = stored.result;
  const std::optional<Truth>& truth = capture.truth;
  ResultSection added;
  added.name = path_from_page(result_path, page_folder);
  added.provenance = text_of(with_page_paths(stored.json["provenance"], page_folder));
  added.stages = result.stages;
  added.mode = stored.mode;
  added.disparity_from = disparity_from(with_page_paths(stored.json["provenance"], page_folder));
  if (truth) added.score = score_result(capture, capture_path, stored, result_path);

  Viewer& viewer = section.viewer;
  const auto add = [&](const char* name, Image image) -> ViewerLayer& {
    ViewerLayer& layer = layer_named(viewer, name);
    layer.images.push_back(std::move(image));
    return layer;
  };
  const bool first = viewer.results.empty();
  viewer.results.push_back(added.name);
  const auto seen = [&](const Image& image, std::optional<float> outside = {}) {
    return truth ? seen_from_first(image, result, *truth, outside) : image;
  };
  const Image shown = page_sized(truth ? truth->photograph : result.input);
  const float gain = display_gain(shown);
  add("Picture", displayed(page_sized(seen(result.input)), gain));
  add("Portrait", displayed(page_sized(seen(result.portrait)), gain));
  if (truth && first) {
    add("True photograph", displayed(shown, gain));
    add("True disparity", known_disparity(*truth)).high = disparity_limit(truth->disparity_dp_px);
  }
  ViewerLayer& disparity = add("Disparity", seen(result.disparity_dp_px, NAN));
  if (truth) {
    disparity.high = layer_named(viewer, "True disparity").high;
    if (!result.disparity_dp_px.empty()) {
      layer_named(viewer, "Error").difference_of = {"Disparity", "True disparity"};
      layer_named(viewer, "Error after fit").difference_of = {"Disparity", "True disparity"};
    }
    layer_named(viewer, "Error after fit").fits.push_back(fit_of(added.score));
  } else if (!result.disparity_dp_px.empty()) {
    disparity.high = std::max<double>(disparity_limit(result.disparity_dp_px), first ? 0 : disparity.high);
  }
  add("Confidence", seen(result.confidence, 0.0f));
  ViewerLayer& radius = add("Blur radius", seen(result.blur_radius_px));
  radius.high = std::max<double>(radius.high, percentile(result.blur_radius_px, 0.995));
  add("Person mask", seen(result.mask));
  section.results.push_back(std::move(added));
}

}  // namespace dualpixel::evaluation
