#include "evaluation/experiments/paper_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/report_images.h"
#include "evaluation/study/crops.h"
#include "pipeline/burst/merge.h"
#include "pipeline/defocus/scatter.h"
#include "pipeline/disparity/paper/normalize.h"
#include "pipeline/portrait/run_portrait.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::PortraitOptions;
using pipeline::PortraitResult;

constexpr int kWidest_px = 640;

/// At most as wide as the page's columns. `pixel_aspect`: the height of a pixel over its width, as views have it.
std::string figure(const std::string& title, const std::string& caption, const Image& srgb, double pixel_aspect = 1) {
  const int width = std::min(srgb.width, kWidest_px);
  const double height = pixel_aspect * srgb.height * width / srgb.width;
  return html_figure({title, caption, jpeg_data_uri(resized(srgb, width, std::max(1L, std::lround(height))), 92)});
}

/// `columns`: "pair" for two, "maps" for as many as there is room for.
std::string section(const std::string& title, const std::string& text, const std::string& figures,
                    const char* columns = "pair") {
  return fmt::format("<h2>{}</h2>\n<p>{}</p>\n<div class=\"{}\">\n{}</div>\n", escape_html(title), escape_html(text),
                     columns, figures);
}

std::string disparity_figure(const std::string& title, const PortraitResult& result, float limit) {
  const Image &matched = result.matched_disparity_dp_px, &picture = result.input;
  return figure(title, fmt::format("disparity, blue to orange: -{0:.2f} to {0:.2f} DP px", limit),
                diverging_colors(matched, limit),
                1.0 * picture.height / matched.height * matched.width / picture.width);
}

float disparity_limit(const Image& disparity_dp_px) {
  Image magnitude = disparity_dp_px;
  for (float& value : magnitude.data) value = std::abs(value);
  return std::max(percentile(magnitude, 0.99), 0.01f);
}

/// Both results' matches and portraits, the first one's beside the second's.
std::string compared(const char* first_name, const PortraitResult& first, const char* second_name,
                     const PortraitResult& second) {
  const float limit = disparity_limit(second.matched_disparity_dp_px);
  return disparity_figure(first_name, first, limit) + disparity_figure(second_name, second, limit) +
         figure(first_name, "portrait", first.portrait_srgb) + figure(second_name, "portrait", second.portrait_srgb);
}

std::string burst_section(const PaperFigures& figures, const PortraitOptions& options, const PortraitResult& whole) {
  Capture single;
  single.camera = figures.capture.camera;
  single.exposure = figures.capture.exposure;
  single.face_px = figures.capture.face_px;
  single.frames = {figures.capture.frames.front()};
  const PortraitResult one = run_portrait(single, options);
  return section("Fig. 7: a burst denoised", "Matches before smoothing, from one frame and from all.",
                 compared("One frame", one, fmt::format("{} frames", figures.capture.frames.size()).c_str(), whole));
}

std::string calibration_section(const PaperFigures& figures, PortraitOptions options, const PortraitResult& without) {
  options.calibration = figures.calibration;
  return section("Fig. 8: calibration", "What the lens adds to disparity over the field, taken out.",
                 compared("Without", without, "With calibration", run_portrait(figures.capture, options)));
}

std::string sharp_range_section(const PaperFigures& figures, PortraitOptions options, const PortraitResult& with) {
  options.blur_radius.sharp_px = 0;
  const PortraitResult physical = run_portrait(figures.capture, options);
  const float most = std::max(percentile(with.blur_radius_px, 0.99), percentile(physical.blur_radius_px, 0.99));
  const auto radius = [&](const char* title, const PortraitResult& result) {
    return figure(title, fmt::format("blur radius, black to white: 0 to {:.1f} px", most),
                  gray_levels(result.blur_radius_px, std::max(most, 0.01f)));
  };
  return section("Fig. 11: what is sharp",
                 "Blur that follows a lens leaves only one depth sharp; Eq. 5 keeps a range of depths around it sharp.",
                 radius("Physical mapping", physical) + radius("Sharp range", with) +
                     figure("Physical mapping", "portrait", physical.portrait_srgb) +
                     figure("Sharp range", "portrait", with.portrait_srgb));
}

/// What one pixel of radius `radius_px` is scattered to, alpha alone.
Image disc(float radius_px, bool by_gradient) {
  const int side = 2 * static_cast<int>(std::ceil(radius_px)) + 5;
  pipeline::Layer layer{Image(side, side, 4), Image(side, side)};
  for (int c = 0; c < 4; ++c) layer.rgba.at(side / 2, side / 2, c) = 1;
  layer.radius_px.at(side / 2, side / 2) = radius_px;
  Image scattered(side, side, 4);
  by_gradient ? pipeline::scatter_gradient(layer, scattered) : pipeline::scatter_direct(layer, scattered);
  Image alpha(side, side);
  for (std::size_t i = 0; i < alpha.data.size(); ++i) alpha.data[i] = scattered.data[4 * i + 3];
  return alpha;
}

/// Each pixel a square of `side` pixels.
Image magnified(const Image& image, int side) {
  Image large(image.width * side, image.height * side, image.channels);
  for (int y = 0; y < large.height; ++y) {
    for (int x = 0; x < large.width; ++x) {
      for (int c = 0; c < image.channels; ++c) large.at(x, y, c) = image.at(x / side, y / side, c);
    }
  }
  return large;
}

std::string disc_section() {
  constexpr float kRadius_px = 9.3f;
  const Image ideal = disc(kRadius_px, false), scattered = disc(kRadius_px, true);
  Image derivative(scattered.width, scattered.height);
  for (int y = 0; y < scattered.height; ++y) {
    for (int x = 1; x < scattered.width; ++x) {
      derivative.at(x, y) = scattered.at(x, y) - scattered.at(x - 1, y);
    }
  }
  const float most = *std::max_element(ideal.data.begin(), ideal.data.end());
  const int side = std::max(1, kWidest_px / ideal.width);
  return section("Fig. 13: discs",
                 fmt::format("Of a radius of {} px; the rows of the second end within pixels.", kRadius_px),
                 figure("Ideal", "the share of each pixel", gray_levels(magnified(ideal, side), most)) +
                     figure("Scattered", "rows of one weight", gray_levels(magnified(scattered, side), most)) +
                     figure("Derivative", "along x: zero but at the ends of rows",
                            diverging_colors(magnified(derivative, side), most)),
                 "maps");
}

/// Of the square that is blurred most, a quarter of the shorter side wide: the picture, and portraits without and with
/// noise.
std::string noise_section(const PaperFigures& figures, PortraitOptions options, const PortraitResult& with) {
  options.synthetic_noise = false;
  const PortraitResult without = run_portrait(figures.capture, options);
  const Image& radius = with.blur_radius_px;
  const int square = std::max(1, std::min(radius.width, radius.height) / 4);
  const Image means = resized(radius, radius.width / square, radius.height / square);
  const auto most = std::max_element(means.data.begin(), means.data.end()) - means.data.begin();
  const int x0 = static_cast<int>(most % means.width) * (radius.width / means.width);
  const int y0 = static_cast<int>(most / means.width) * (radius.height / means.height);
  const auto part = [&](const Image& picture) { return cropped(picture, {x0, y0, square}); };
  return section("Fig. 14: synthetic noise", "Blur takes the noise away, and what is blurred looks pasted in.",
                 figure("The picture", "before blurring", part(encode_for_display(with.input, options.display))) +
                     figure("Without noise", "portrait", part(without.portrait_srgb)) +
                     figure("With noise", "portrait", part(with.portrait_srgb)),
                 "maps");
}

/// Nothing where fewer than two people are found. Mode dp leaves one depth sharp.
std::string people_section(const PaperFigures& figures, PortraitOptions options, const PortraitResult& dp) {
  if (!pipeline::has_person_network()) return "";
  pipeline::PersonNetwork network;
  const pipeline::FoundPeople found = pipeline::find_people(dp.input, {}, network);
  if (found.faces.size() < 2 || !anybody_seen(found)) return "";
  options.mode = pipeline::Mode::dp_seg;
  options.faces = found.faces;
  const PortraitResult both = run_portrait(figures.capture, options, found.mask);
  return section(
      "Fig. 16b: people at several depths",
      fmt::format("All whose faces are large enough ({}) are sharp in mode dp+seg, however far apart they stand.",
                  found.faces.size()),
      figure("dp", "portrait", dp.portrait_srgb) + figure("dp+seg", "portrait", both.portrait_srgb));
}

std::string normalization_section(const PaperFigures& figures, const PortraitOptions& options) {
  const pipeline::MergedBurst merged =
      pipeline::align_and_merge(figures.capture.frames, figures.capture.exposure, options.merge);
  const auto trace = [&](const std::string& name, const Image& view) {
    Series series{name, {}};
    const int y = view.height / 2, first = view.width / 4, last = std::min(view.width, first + 200);
    for (int x = first; x < last; ++x) series.points.emplace_back(x, view.at(x, y));
    return series;
  };
  const auto plot = [&](const std::string& title, const std::string& unit, const Image& left, const Image& right) {
    return Plot{title, "column of the view, DP px", unit, {trace("left", left), trace("right", right)}};
  };
  const Image left = pipeline::normalize_locally(merged.left), right = pipeline::normalize_locally(merged.right);
  return "<h2>Fig. S2: normalization</h2>\n<p>The middle row of both views, and the same after each window's "
         "mean and deviation are made equal.</p>\n" +
         html_plots({plot("Views", "signal over white", merged.left, merged.right),
                     plot("Normalized", "deviations from the window's mean", left, right)});
}

}  // namespace

std::string paper_figures_page(const PaperFigures& figures, const std::function<void(double fraction)>& progress) {
  PortraitOptions options = pipeline::default_options(figures.matcher);
  options.mode = pipeline::Mode::dp;
  const auto report = [&](double fraction) {
    if (progress) progress(fraction);
  };
  const PortraitResult whole = run_portrait(figures.capture, options);
  report(0.2);
  std::string body = "<h1>Figures of the paper</h1>\n";
  if (figures.capture.frames.size() > 1) body += burst_section(figures, options, whole);
  report(0.4);
  if (figures.calibration) body += calibration_section(figures, options, whole);
  report(0.6);
  body += sharp_range_section(figures, options, whole) + disc_section();
  report(0.8);
  body += noise_section(figures, options, whole) + people_section(figures, options, whole) +
          normalization_section(figures, options);
  report(1);
  return html_page("Figures of the paper", body);
}

}  // namespace dualpixel::evaluation
