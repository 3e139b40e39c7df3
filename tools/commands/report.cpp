#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "capture/capture.h"
#include "capture/capture_json.h"
#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/scoring.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/report_page.h"
#include "pipeline/portrait/result_io.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

constexpr int kWidestPx = 1344;
constexpr float kErrorLimitDpPx = 0.5f;
constexpr float kMostGain = 64;

struct ReportOptions {
  std::vector<std::string> results;
  std::string output;
  std::string capture;
};

/// Reduces pictures of one capture to the size at which the page shows them.
struct PageSize {
  int width = 0;
  int height = 0;

  explicit PageSize(const Camera& camera) : width(std::min(kWidestPx, camera.width_px)) {
    height =
        std::max(1, static_cast<int>(std::lround(static_cast<double>(camera.height_px) * width / camera.width_px)));
  }
  Image operator()(const Image& image) const { return evaluation::resized(image, width, height); }
};

/// Brings the brightest hundredth to white; never darkens.
float display_gain(const Image& linear) {
  return std::clamp(1 / std::max(evaluation::percentile(linear, 0.99), 1e-6f), 1.0f, kMostGain);
}

evaluation::Picture picture(const std::string& title, const std::string& caption, const Image& srgb) {
  return {title, caption, evaluation::jpeg_data_uri(srgb), "", "", ""};
}

Image ramp(float low, float high) {
  Image values(256, 1);
  for (int x = 0; x < 256; ++x) values.at(x, 0) = std::lerp(low, high, static_cast<float>(x) / 255);
  return values;
}

evaluation::Picture signed_map(const std::string& title, const std::string& caption, const Image& values, float limit) {
  return {title,
          caption,
          evaluation::jpeg_data_uri(evaluation::diverging_colors(values, limit)),
          evaluation::jpeg_data_uri(evaluation::diverging_colors(ramp(-limit, limit), limit)),
          fmt::format("{:+.1f}", -limit),
          fmt::format("{:+.1f} DP px", limit)};
}

evaluation::Picture gray_map(const std::string& title, const std::string& caption, const Image& values, float limit,
                             const std::string& unit) {
  return {title,
          caption,
          evaluation::jpeg_data_uri(evaluation::gray_levels(values, limit)),
          evaluation::jpeg_data_uri(evaluation::gray_levels(ramp(0, limit), limit)),
          "0",
          fmt::format("{:.3g}{}", limit, unit)};
}

evaluation::CaptureSection capture_section(const Capture& capture, const std::string& path) {
  const Camera& camera = capture.camera;
  evaluation::CaptureSection section;
  section.name = path;
  section.facts = fmt::format(
      "{}: {} × {} photosites, f = {:.3g} mm, f/{:.3g}, focused at {:.3g} m; {:.3g} s at ISO {:.0f}; "
      "{} frame{}",
      printable(camera.name), camera.width_px, camera.height_px, camera.focal_length_mm, camera.f_number,
      camera.focus_distance_m, capture.exposure.time_s, capture.exposure.iso, capture.frames.size(),
      capture.frames.size() == 1 ? "" : "s");
  const PageSize to_page(camera);
  const Frame& frame = capture.frames.front();
  const Image left = to_page(normalised(frame.left, capture.exposure));
  const Image right = to_page(normalised(frame.right, capture.exposure));
  const float gain = display_gain(left);
  const std::string caption = fmt::format(
      "The two dual-pixel views of the first frame, shown at a gain of {:.3g}. "
      "What moves between them is out of focus.",
      gain);
  section.flicker = {picture("left view", caption, evaluation::displayed(left, gain)),
                     picture("right view", caption, evaluation::displayed(right, gain))};
  section.provenance = to_json(capture.provenance, path);
  return section;
}

/// estimate - truth, NaN where the truth is not valid or nothing was estimated.
Image disparity_error(const Truth& truth, const Image& estimate, const evaluation::AffineFit& fit) {
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
  return std::max(0.5f, std::ceil(2 * evaluation::percentile(magnitude, 0.995)) / 2);
}

std::vector<evaluation::Picture> result_maps(const pipeline::PortraitResult& result, const std::optional<Truth>& truth,
                                             const nlohmann::ordered_json& score, const PageSize& to_page) {
  std::vector<evaluation::Picture> maps;
  if (!result.disparity_dp_px.empty()) {
    const Image estimate = to_page(result.disparity_dp_px);
    const Image true_disparity = truth ? to_page(truth->disparity_dp_px) : Image();
    const float limit = disparity_limit(truth ? true_disparity : estimate);
    maps.push_back(
        signed_map("Estimated disparity", "Blue is in front of the focus plane, orange behind.", estimate, limit));
    if (truth) {
      const Image seen = evaluation::disparity_seen_from_first(result, *truth);
      maps.push_back(signed_map("True disparity", "From geometry and optics.", true_disparity, limit));
      maps.push_back(signed_map("Error", "Estimate minus truth; grey where nothing was hit.",
                                to_page(disparity_error(*truth, seen, {})), kErrorLimitDpPx));
      const nlohmann::ordered_json& everything = score["disparity"]["everything"];
      if (everything["affine_scale"].is_number()) {
        const evaluation::AffineFit fit{everything["affine_scale"].get<double>(),
                                        everything["affine_offset_px"].get<double>()};
        maps.push_back(signed_map("Error after the affine fit",
                                  fmt::format("{:.3f} × estimate {:+.3f}, minus truth.", fit.scale, fit.offset),
                                  to_page(disparity_error(*truth, seen, fit)), kErrorLimitDpPx));
      }
    }
    maps.push_back(gray_map("Confidence", "Of the estimated disparity.", to_page(result.confidence), 1, ""));
  }
  if (!result.mask.empty()) maps.push_back(gray_map("Person mask", "After filtering.", to_page(result.mask), 1, ""));
  if (!result.blur_radius_px.empty()) {
    const Image radius = to_page(result.blur_radius_px);
    maps.push_back(gray_map("Blur radius", "Of the synthetic defocus.", radius,
                            std::max(1.0f, evaluation::percentile(radius, 0.995)), " px"));
  }
  return maps;
}

evaluation::ResultSection result_section(const Capture& capture, const std::string& capture_path,
                                         const pipeline::StoredResult& stored, const std::string& path) {
  const pipeline::PortraitResult& result = stored.result;
  const std::optional<Truth>& truth = capture.truth;
  evaluation::ResultSection section;
  section.name = path;
  section.provenance = stored.json["provenance"];
  section.stages = stored.json["stages"];
  section.mode = stored.mode;
  if (truth) section.score = evaluation::score_result(capture, capture_path, stored, path);

  const PageSize to_page(capture.camera);
  const float gain = display_gain(to_page(truth ? truth->photograph : result.input));
  const std::string caption = fmt::format("All shown at a gain of {:.3g}. Drag the divider.", gain);
  const auto add = [&](const char* title, const Image& linear) {
    section.photographs.push_back(picture(title, caption, evaluation::displayed(to_page(linear), gain)));
  };
  add("portrait", result.portrait);
  add("input, not blurred", result.input);
  if (truth) add("true photograph", truth->photograph);

  section.maps = result_maps(result, truth, section.score, to_page);
  return section;
}

/// The capture that a result says it was made from.
std::string capture_of(const pipeline::StoredResult& stored, const std::string& result_path) {
  const auto named = stored.json["provenance"].find("capture");
  if (named == stored.json["provenance"].end() || !named->is_string()) {
    throw InputError(printable(result_path) +
                     "/result.json: /provenance/capture: does not name the capture (a plain pair has none); give "
                     "--capture where there is one of the same picture");
  }
  std::string path = named->get<std::string>();
  if (!std::filesystem::exists(path)) {
    throw InputError(fmt::format("{}/result.json: /provenance/capture: {}: no such folder; give --capture",
                                 printable(result_path), printable(path)));
  }
  return path;
}

void run(const ReportOptions& options) {
  std::vector<evaluation::CaptureSection> sections;
  Capture capture;
  for (const std::string& path : options.results) {
    const pipeline::StoredResult stored = pipeline::read_result(path);
    const std::string capture_path = options.capture.empty() ? capture_of(stored, path) : options.capture;
    pipeline::require_own_capture(stored, capture_path, path);
    if (sections.empty() || sections.back().name != capture_path) {
      capture = read_capture(capture_path, true);
      sections.push_back(capture_section(capture, capture_path));
    }
    if (stored.result.input.width != capture.camera.width_px ||
        stored.result.input.height != capture.camera.height_px) {
      throw InputError(fmt::format("{}: {} x {} pixels; the capture {} has {} x {}", printable(path),
                                   stored.result.input.width, stored.result.input.height, printable(capture_path),
                                   capture.camera.width_px, capture.camera.height_px));
    }
    sections.back().results.push_back(result_section(capture, capture_path, stored, path));
  }
  replace_file(options.output, evaluation::report_page(sections));
}

}  // namespace

void add_report(CLI::App& program) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = program.add_subcommand("report", "Write one HTML page about portrait results");
  command->add_option("results", options->results, "Result folders")->required()->type_name("RESULT_DIR");
  command->add_option("-o,--output", options->output, "Page to write")->required()->type_name("REPORT.html");
  command->add_option("--capture", options->capture, "Capture folder; by default the one that each result names")
      ->type_name("CAPTURE_DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel report out/dp out/dp+seg -o out/report.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
