#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/resample.h"
#include "capture/json_fields.h"
#include "capture/timing.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/paper/match.h"
#include "pipeline/disparity/paper/normalize.h"
#include "pipeline/disparity/upsample.h"
#include "simulator/simulate.h"
#include "tools/commands/commands.h"
#ifdef DUALPIXEL_OPENCV
#include <opencv2/calib3d.hpp>
#endif

namespace dualpixel::tools {
namespace {

struct BenchDisparityOptions {
  std::vector<std::string> scenes = {"build/release/scenes/portrait.json", "build/release/scenes/slanted_planes.json"};
  std::string page;
  bool json = false;
};

struct Views {
  Image left, right;  // normalised signal
  pipeline::ViewNoise noise;
};

/// Disparity of every pixel; not a number where the method gives none. Sigma and confidence where it has them.
using Found = pipeline::PixelDisparity;

struct Method {
  std::string name;
  std::function<Found(const Views&)> match;
};

Found match_as_the_paper(const Views& views) {
  const pipeline::TileDisparity tiles =
      pipeline::match_tiles(pipeline::normalize_locally(views.left), pipeline::normalize_locally(views.right));
  return pipeline::upsample_tiles(tiles, views.left.width, views.left.height);
}

Found match_likelihood(const Views& views) {
  const pipeline::TileDisparity tiles = pipeline::match_by_likelihood(views.left, views.right, {.noise = views.noise});
  return pipeline::upsample_tiles(tiles, views.left.width, views.left.height);
}

#ifdef DUALPIXEL_OPENCV
constexpr int kBlock = 9, kRange = 16;

cv::Mat eight_bits(const Image& view, double gain) {
  cv::Mat out(view.height, view.width, CV_8U);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) out.at<uchar>(y, x) = cv::saturate_cast<uchar>(gain * view.at(x, y));
  }
  return out;
}

/// Both peers take 8-bit pictures, here exposed to their brightest 0.1 %, and give left(x) = right(x - disparity).
Found match_opencv(const Views& views, cv::StereoMatcher& matcher) {
  std::vector<float> sorted = views.left.data;
  const auto rank = sorted.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), rank, sorted.end());
  const double gain = 255 / std::max(*rank, 1e-6f);
  cv::Mat sixteenths;
  matcher.compute(eight_bits(views.left, gain), eight_bits(views.right, gain), sixteenths);
  Found found{Image(views.left.width, views.left.height), {}};
  for (int y = 0; y < found.disparity_dp_px.height; ++y) {
    for (int x = 0; x < found.disparity_dp_px.width; ++x) {
      const short value = sixteenths.at<short>(y, x);
      found.disparity_dp_px.at(x, y) =
          value < -16 * kRange ? std::numeric_limits<float>::quiet_NaN() : -static_cast<float>(value) / 16;
    }
  }
  return found;
}
#endif

std::vector<Method> methods() {
  std::vector<Method> all = {{"paper", match_as_the_paper}, {"likelihood", match_likelihood}};
#ifdef DUALPIXEL_OPENCV
  all.push_back({"OpenCV StereoBM", [](const Views& views) {
                   const auto matcher = cv::StereoBM::create(2 * kRange, kBlock);
                   matcher->setMinDisparity(-kRange);
                   return match_opencv(views, *matcher);
                 }});
  all.push_back({"OpenCV StereoSGBM", [](const Views& views) {
                   // smoothness as OpenCV's manual suggests for one channel: 8 and 32 times the block's area
                   const auto matcher =
                       cv::StereoSGBM::create(-kRange, 2 * kRange, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock);
                   return match_opencv(views, *matcher);
                 }});
#endif
  return all;
}

/// A quarter of the scene's photosites, one frame, 64 samples each: rendering noise is common to both views, and fewer
/// samples would draw every matcher to 0.
Capture render(const std::string& scene_file) {
  nlohmann::json document = read_json_file(scene_file);
  for (const char* assignment :
       {"sensor.width_px=1344", "sensor.height_px=1008", "sensor.pixel_pitch_um=2.8", "sensor.dp_downsample_x=2",
        "sensor.dp_downsample_y=4", "burst.frames=1", "render.samples_per_pixel=64",
        "render.photograph_samples_per_pixel=1", "render.all_in_focus_samples_per_pixel=1"}) {
    apply_override(document, assignment);
  }
  const simulator::Simulation s = simulator::read_simulation(document, scene_file);
  return simulator::simulate(s, simulator::load_scene(s));
}

/// Mean error over a sparsification curve's steps.
double mean_of(const std::vector<double>& curve) {
  double sum = 0;
  for (const double value : curve) sum += value;
  return sum / static_cast<double>(curve.size());
}

/// What area over the oracle's would be left were every error drawn from its predicted sigma: no confidence can know
/// more of an error than its scale.
double area_of_exact_sigma(const std::vector<float>& sigma) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::vector<float> error, confidence;
  for (const float value : sigma) {
    error.push_back(std::abs(value * normal(random)));
    confidence.push_back(-value);
  }
  const evaluation::Sparsification curves = evaluation::sparsification(error, confidence);
  return mean_of(curves.error) / mean_of(curves.oracle);
}

nlohmann::ordered_json errors_of(const Found& found, const Image& truth, const Image& valid) {
  std::vector<float> estimate, expected, error, confidence, sigmas;
  double within_one = 0, within_two = 0, pixels = 0, wrong_and_sure = 0;
  for (int y = 0; y < found.disparity_dp_px.height; ++y) {
    for (int x = 0; x < found.disparity_dp_px.width; ++x) {
      // truth of the photosite at the DP pixel's middle
      const int u = (2 * x + 1) * truth.width / (2 * found.disparity_dp_px.width);
      const int v = (2 * y + 1) * truth.height / (2 * found.disparity_dp_px.height);
      if (valid.at(u, v) != 1) continue;
      pixels += 1;
      const float d = found.disparity_dp_px.at(x, y);
      if (!std::isfinite(d)) continue;
      estimate.push_back(d);
      expected.push_back(truth.at(u, v));
      error.push_back(std::abs(d - truth.at(u, v)));
      if (!found.confidence.empty()) confidence.push_back(found.confidence.at(x, y));
      if (found.sigma_dp_px.empty()) continue;
      const float sigma = found.sigma_dp_px.at(x, y);
      sigmas.push_back(sigma);
      within_one += error.back() < sigma;
      within_two += error.back() < 2 * sigma;
      wrong_and_sure += error.back() > 0.5f && sigma < 0.2f;
    }
  }
  const auto count = static_cast<double>(estimate.size());
  nlohmann::ordered_json figures = {{"answered_share", count / pixels},
                                    {"rmse_dp_px", evaluation::rmse(estimate, expected)},
                                    {"wrong_share", evaluation::bad_pixel_rate(estimate, expected, 0.5)},
                                    {"aiwe1_dp_px", evaluation::aiwe1(estimate, expected)}};
  if (!confidence.empty()) {
    const evaluation::Sparsification curves = evaluation::sparsification(error, confidence);
    figures["sparsification_area_over_oracle"] = mean_of(curves.error) / mean_of(curves.oracle);
    figures["ause"] = curves.ause ? nlohmann::ordered_json(*curves.ause) : nullptr;
  }
  if (!found.sigma_dp_px.empty()) {
    figures["sparsification_area_over_oracle_of_exact_sigma"] = area_of_exact_sigma(sigmas);
    figures["within_one_sigma_share"] = within_one / count;
    figures["within_two_sigma_share"] = within_two / count;
    figures["wrong_and_sure_share"] = wrong_and_sure / count;
  }
  return figures;
}

/// Milliseconds, the best of a few, at the size of a phone's Bayer plane; turn by turn, so that a busy machine slows
/// all.
std::vector<double> times_ms(const std::vector<Method>& all, const Views& views) {
  constexpr int kWidth = 1344, kHeight = 1008, kRepeats = 9;
  const Views large{resize_bilinear(views.left, kWidth, kHeight), resize_bilinear(views.right, kWidth, kHeight),
                    views.noise};
  std::vector<double> best(all.size(), std::numeric_limits<double>::infinity());
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      best[i] = std::min(best[i], 1e3 * seconds([&] { all[i].match(large); }));
    }
  }
  return best;
}

/// What a copy of 1344 x 1008 floats takes, ms, read and written once.
double copy_ms() {
  const Image from(1344, 1008, 1, 0.5f);
  Image to = from;
  double best = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < 20; ++repeat) {
    best = std::min(
        best, 1e3 * seconds([&] { std::memcpy(to.data.data(), from.data.data(), from.data.size() * sizeof(float)); }));
  }
  return best;
}

std::string to_page(const nlohmann::ordered_json& results) {
  evaluation::Plot plot;
  plot.title = "Error against time";
  plot.x_label = "ms at 1344 x 1008";
  plot.y_label = "RMSE, DP px";
  std::string rows =
      "<table><tr><th>scene</th><th>method</th><th>ms</th><th>RMSE, DP px</th><th>wrong by &gt; 0.5 px</th>"
      "<th>answered</th></tr>";
  std::vector<evaluation::Series> series;
  for (const auto& scene : results["scenes"]) {
    std::size_t i = 0;
    for (const auto& method : scene["methods"]) {
      if (series.size() <= i) series.push_back({method["method"], {}, false, true});
      series[i++].points.emplace_back(method["ms"].get<double>(), method["rmse_dp_px"].get<double>());
      rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.1f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td></tr>",
                          evaluation::escape_html(printable(scene["scene"].get<std::string>())),
                          evaluation::escape_html(method["method"].get<std::string>()), method["ms"].get<double>(),
                          method["rmse_dp_px"].get<double>(), method["wrong_share"].get<double>(),
                          method["answered_share"].get<double>());
    }
  }
  plot.series = std::move(series);
  const std::string body =
      "<h1>Disparity: error against time</h1><p>One dot a scene. Pairs rendered at 672 x 252 DP pixels, one frame with "
      "its noise; errors against the true disparity of every pixel that the method answers. Times are those of the "
      "same pair enlarged to 1344 x 1008, all threads, normalisation and upsampling included.</p><div "
      "class=\"plots\">" +
      evaluation::svg_plot(plot) + "</div><div class=\"scroll\">" + rows + "</table></div>";
  return evaluation::html_page("Disparity: error against time",
                               std::string(evaluation::kReportStyle) + evaluation::kPlotStyle, body);
}

void run(const BenchDisparityOptions& options) {
  const std::vector<Method> all = methods();
  nlohmann::ordered_json results = {{"copy_1344x1008_ms", copy_ms()}, {"scenes", nlohmann::ordered_json::array()}};
  for (const std::string& file : options.scenes) {
    const Capture capture = render(file);
    const Views views{normalised(capture.frames[0].left, capture.exposure),
                      normalised(capture.frames[0].right, capture.exposure), pipeline::view_noise(capture.exposure)};
    const std::vector<double> ms = times_ms(all, views);
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < all.size(); ++i) {
      nlohmann::ordered_json row = {{"method", all[i].name}, {"ms", ms[i]}};
      row.update(errors_of(all[i].match(views), capture.truth->disparity_dp_px, capture.truth->valid));
      rows.push_back(row);
    }
    results["scenes"].push_back({{"scene", file}, {"methods", rows}});
  }
  if (!options.page.empty()) replace_file(options.page, to_page(results));
  if (options.json) {
    std::cout << results.dump(2) << '\n';
    return;
  }
  std::cout << fmt::format("copying one view of 1344 x 1008: {:.2f} ms\n", results["copy_1344x1008_ms"].get<double>());
  for (const auto& scene : results["scenes"]) {
    std::cout << fmt::format("{}\n{:<20}{:>8}{:>8}{:>14}{:>12}{:>10}\n", printable(scene["scene"].get<std::string>()),
                             "method", "ms", "copies", "RMSE, DP px", "> 0.5 px", "answered");
    for (const auto& method : scene["methods"]) {
      std::cout << fmt::format("{:<20}{:>8.1f}{:>8.0f}{:>14.3f}{:>12.3f}{:>10.3f}\n",
                               method["method"].get<std::string>(), method["ms"].get<double>(),
                               method["ms"].get<double>() / results["copy_1344x1008_ms"].get<double>(),
                               method["rmse_dp_px"].get<double>(), method["wrong_share"].get<double>(),
                               method["answered_share"].get<double>());
    }
  }
}

}  // namespace

void add_bench_disparity(CLI::App& bench) {
  auto options = std::make_shared<BenchDisparityOptions>();
  CLI::App* command = bench.add_subcommand(
      "disparity", "Time both matchers, and OpenCV's where it was built in; errors on rendered pairs");
  command->add_option("scene", options->scenes, "Scene JSON files (default: the portrait and the slanted planes)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->page, "Write a page with the chart")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  dualpixel bench disparity build/release/scenes/portrait.json -o bench-disparity.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
