#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/median.h"
#include "capture/image/resample.h"
#include "capture/timing.h"
#include "evaluation/experiments/edge_failures.h"
#include "evaluation/metrics/edge_metrics.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/portrait/run_portrait.h"
#include "tools/commands/commands.h"
#ifdef DUALPIXEL_XIMGPROC
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#endif

namespace dualpixel::tools {
namespace {

using pipeline::BilateralGridOptions;
using pipeline::BilateralSolverOptions;

constexpr float kJump = 0.2f;  // DP px: a depth edge
constexpr int kEdgeReachPx = 3;

struct BenchEdgesOptions {
  std::string capture;
  std::string page;
  bool json = false;
};

/// What there is to smooth: a guide with values for its pixels, and the truth at the capture's size.
struct Problem {
  Image guide;  ///< the capture's size
  Image disparity, confidence;
  Image truth;
  evaluation::Mask valid, edges, thin, person;
};

struct Small {
  Image guide, disparity, confidence;
};

Small reduced(const Problem& problem, int divisor) {
  const int width = problem.guide.width / divisor, height = problem.guide.height / divisor;
  const auto resized = [&](const Image& map) {
    return map.width > width ? resize_area(map, width, height) : resize_bilinear(map, width, height);
  };
  Image weighted = problem.disparity;
  for (std::size_t i = 0; i < weighted.data.size(); ++i) weighted.data[i] *= problem.confidence.data[i];
  Small small{resize_area(problem.guide, width, height), resized(weighted), resized(problem.confidence)};
  for (std::size_t i = 0; i < small.disparity.data.size(); ++i) {
    small.disparity.data[i] /= std::max(small.confidence.data[i], 1e-6f);
  }
  return small;
}

struct Method {
  std::string family, name;
  int divisor = 4;  ///< of the capture's size, for what `smooth` works on
  std::function<Image(const Small&)> smooth;
};

Image solve(const Small& small, const BilateralGridOptions& cells, const BilateralSolverOptions& options) {
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(small.guide, cells);
  return pipeline::solve_bilateral(grid, small.guide, small.disparity, small.confidence, options).value;
}

Method solver(const std::string& family, const std::string& name, int divisor, const BilateralGridOptions& cells = {},
              const BilateralSolverOptions& options = {}) {
  return {family, name, divisor, [=](const Small& small) { return solve(small, cells, options); }};
}

#ifdef DUALPIXEL_XIMGPROC
cv::Mat wrapped(const Image& image) {
  return {image.height, image.width, CV_32FC(image.channels), const_cast<float*>(image.data.data())};
}

cv::Mat guide_of(const Small& small) {
  cv::Mat bytes, bgr;
  wrapped(small.guide).convertTo(bytes, CV_8UC3);
  cv::cvtColor(bytes, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

Image solve_with_opencv(const Small& small, const BilateralGridOptions& cells) {
  constexpr int kIterations = 25;  // its default
  Image out(small.guide.width, small.guide.height);
  cv::Mat solved;
  std::cout.setstate(std::ios::failbit);  // the library prints its progress there
  cv::ximgproc::fastBilateralSolverFilter(guide_of(small), wrapped(small.disparity), wrapped(small.confidence), solved,
                                          cells.cell_px, cells.cell_luma, cells.cell_chroma, 128, kIterations);
  std::cout.clear();
  solved.copyTo(wrapped(out));
  return out;
}

/// A filter that knows no confidence, used on both: filter(c t) / filter(c), no further than the targets go, since
/// filters that overshoot can find next to no confidence.
template <typename Filter>
Image normalized(const Small& small, const Filter& filter) {
  Image out(small.guide.width, small.guide.height);
  const cv::Mat guide = guide_of(small), confidence = wrapped(small.confidence) + 1e-4f;
  const auto [least, most] = std::minmax_element(small.disparity.data.begin(), small.disparity.data.end());
  cv::Mat both, filtered;
  cv::merge(std::vector<cv::Mat>{wrapped(small.disparity).mul(confidence), confidence, confidence}, both);
  filter(guide, both, filtered);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const cv::Vec3f sums = filtered.at<cv::Vec3f>(y, x);
      out.at(x, y) = std::clamp(sums[0] / std::max(sums[1], 1e-6f), *least, *most);
    }
  }
  return out;
}
#endif

std::vector<Method> methods() {
  std::vector<Method> all = {{"none", "enlarged", 4, [](const Small& small) { return small.disparity; }}};
  for (const int divisor : {1, 2, 4, 8}) all.push_back(solver("resolution", fmt::format("1/{}", divisor), divisor));
  for (const int iterations : {5, 10, 25, 50, 100}) {
    BilateralSolverOptions options;
    options.iterations = iterations;
    all.push_back(solver("iterations", fmt::format("{}", iterations), 4, {}, options));
  }
  for (const float cell_px : {4.0f, 8.0f, 16.0f}) {
    for (const float cell : {4.0f, 8.0f, 16.0f}) {
      all.push_back(solver("sigmas", fmt::format("{:g} px, {:g} levels", cell_px, cell), 4, {cell_px, cell, cell}));
    }
  }
  for (const float lambda : {2.0f, 8.0f, 32.0f, 128.0f, 512.0f}) {
    BilateralSolverOptions options;
    options.lambda = lambda;
    all.push_back(solver("lambda", fmt::format("{:g}", lambda), 4, {}, options));
  }
  for (const float scale : {0.1f, 0.25f, 0.5f}) {
    BilateralSolverOptions options;
    options.robust_rounds = 3;
    options.robust_scale = scale;
    all.push_back(solver("robust, 3 rounds", fmt::format("scale {:g} DP px", scale), 4, {}, options));
  }
#ifdef DUALPIXEL_XIMGPROC
  for (const int divisor : {2, 4, 8}) {
    all.push_back({"OpenCV's solver", fmt::format("1/{}", divisor), divisor,
                   [](const Small& small) { return solve_with_opencv(small, {}); }});
  }
  for (const int radius : {4, 8, 16}) {
    all.push_back({"OpenCV guided filter", fmt::format("radius {}", radius), 4, [=](const Small& small) {
                     return normalized(small, [&](const cv::Mat& guide, const cv::Mat& from, cv::Mat& to) {
                       cv::ximgproc::guidedFilter(guide, from, to, radius, 25);
                     });
                   }});
  }
  for (const double lambda : {100.0, 1000.0, 10000.0}) {
    all.push_back({"OpenCV fast global smoother", fmt::format("lambda {:g}", lambda), 4, [=](const Small& small) {
                     return normalized(small, [&](const cv::Mat& guide, const cv::Mat& from, cv::Mat& to) {
                       cv::ximgproc::fastGlobalSmootherFilter(guide, from, to, lambda, 8);
                     });
                   }});
  }
  for (const double sigma : {16.0, 32.0, 64.0}) {
    all.push_back({"OpenCV domain transform", fmt::format("sigma {:g} px", sigma), 4, [=](const Small& small) {
                     return normalized(small, [&](const cv::Mat& guide, const cv::Mat& from, cv::Mat& to) {
                       cv::ximgproc::dtFilter(guide, from, to, sigma, 20);
                     });
                   }});
  }
#endif
  return all;
}

/// Fits the matches to the truth, as calibration would: what is left is what smoothing can mend.
void calibrate(Problem& problem) {
  const Image large = resize_bilinear(problem.disparity, problem.truth.width, problem.truth.height);
  const Image sure = resize_bilinear(problem.confidence, problem.truth.width, problem.truth.height);
  std::vector<float> estimate, truth;
  for (std::size_t i = 0; i < large.data.size(); ++i) {
    if (!problem.valid.data[i] || sure.data[i] < 0.5f) continue;
    estimate.push_back(large.data[i]);
    truth.push_back(problem.truth.data[i]);
  }
  const evaluation::AffineFit fit = evaluation::fit_affine(estimate, truth);
  for (float& value : problem.disparity.data) value = static_cast<float>(fit.scale * value + fit.offset);
}

/// The same with the truth for matches, but for noise of 0.15 DP px, 5 % that err by up to 1 DP px, and nothing known
/// within 16 px of a depth edge, where windows of a matcher straddle it.
Problem with_known_errors(Problem problem) {
  const int width = problem.guide.width / 4, height = problem.guide.height / 4;
  problem.disparity = resize_area(problem.truth, width, height);
  problem.confidence = Image(width, height, 1, 1.0f);
  const evaluation::Mask unknown = evaluation::depth_edges(problem.truth, kJump, 16);
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.15f);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int u = 4 * x + 2, v = 4 * y + 2;
      const bool wild = std::abs(uniform(random)) < 0.05f;
      problem.disparity.at(x, y) += wild ? uniform(random) : noise(random);
      if (unknown.at(u, v) || !problem.valid.at(u, v)) problem.confidence.at(x, y) = 0;
    }
  }
  return problem;
}

/// The whole capture, with the paper's matches.
Problem make_problem(const std::string& path) {
  Capture capture = read_capture(path, true);
  if (!capture.truth) throw InputError(printable(path) + ": holds no truth to measure errors against");
  Problem problem;
  problem.truth = std::move(capture.truth->disparity_dp_px);
  const auto mask_of = [](const Image& map) {
    evaluation::Mask mask(map.width, map.height);
    for (std::size_t i = 0; i < map.data.size(); ++i) mask.data[i] = map.data[i] > 0.5f;
    return mask;
  };
  problem.valid = mask_of(capture.truth->valid);
  problem.person = mask_of(capture.truth->person_mask);
  const bool moved = !capture.truth->motion.empty();
  capture.truth.reset();
  pipeline::PortraitResult portrait = pipeline::run_portrait(capture);
  if (moved && portrait.base_frame > 0) {
    throw InputError(
        fmt::format("{}: truth/motion: the base is frame {}, and truth is frame 0's: give a burst that "
                    "stands still",
                    printable(path), portrait.base_frame));
  }
  problem.guide = pipeline::encode_guide(portrait.input, pipeline::guide_gain(portrait.input));
  problem.disparity = std::move(portrait.matched_disparity_dp_px);
  problem.confidence = std::move(portrait.matched_confidence);
  calibrate(problem);
  problem.edges = evaluation::depth_edges(problem.truth, kJump, kEdgeReachPx);
  problem.thin = evaluation::thin_structures(problem.truth, kJump);
  return problem;
}

struct Errors {
  double squares = 0, absolute = 0, pixels = 0;
  void add(double error) {
    squares += error * error;
    absolute += std::abs(error);
    pixels += 1;
  }
  double rmse() const { return pixels > 0 ? std::sqrt(squares / pixels) : 0; }
  double mae() const { return pixels > 0 ? absolute / pixels : 0; }
};

nlohmann::ordered_json figures(const Problem& problem, const Image& estimate) {
  Errors all, edges, thin;
  for (std::size_t i = 0; i < estimate.data.size(); ++i) {
    if (!problem.valid.data[i]) continue;
    const double error = estimate.data[i] - problem.truth.data[i];
    all.add(error);
    if (problem.edges.data[i]) edges.add(error);
    if (problem.thin.data[i]) thin.add(error);
  }
  return {{"rmse_dp_px", all.rmse()},
          {"mae_dp_px", all.mae()},
          {"edge_rmse_dp_px", edges.rmse()},
          {"edge_mae_dp_px", edges.mae()},
          {"edge_width_px", evaluation::edge_width_px(estimate, problem.truth, kJump)},
          {"thin_mae_dp_px", thin.mae()}};
}

/// What takes the disparity from a quarter of the size to all of it, and a mask.
nlohmann::ordered_json bench_paths(const Problem& problem) {
  const Small small = reduced(problem, 4);
  const Image mask = [&] {
    Image out(problem.person.width, problem.person.height);
    std::copy(problem.person.data.begin(), problem.person.data.end(), out.data.begin());
    return out;
  }();
  const Image coarse = resize_area(mask, 256, 256);
  Image solved, smooth, large, filtered;
  const auto [ms, cpu_ms] = times({[&] { solved = solve(small, {}, {}); }, [&] { smooth = median_3x3(solved); },
                                   [&] { large = pipeline::joint_upsample(smooth, small.guide, problem.guide); },
                                   [&] { filtered = pipeline::filter_mask(coarse, problem.guide); }},
                                  7);
  const auto f_score = [&](const Image& map, const auto& inside) {
    evaluation::Mask estimate(map.width, map.height);
    for (std::size_t i = 0; i < map.data.size(); ++i) estimate.data[i] = inside(map.data[i]);
    return evaluation::boundary_f_score(estimate, problem.person, 2);
  };
  const auto half = [](float value) { return value > 0.5f; };
  const Image rough = resize_area(mask, 64, 48);
  const int width = mask.width, height = mask.height;
  return {{"solve_ms", ms[0]},
          {"median_ms", ms[1]},
          {"upsample_ms", ms[2]},
          {"disparity_ms", ms[0] + ms[1] + ms[2]},
          {"mask_ms", ms[3]},
          {"disparity_cpu_ms", cpu_ms[0] + cpu_ms[1] + cpu_ms[2]},
          {"mask_cpu_ms", cpu_ms[3]},
          {"solve_peak_mb", peak_mb([&] { solve(small, {}, {}); })},
          {"mask_boundary_f_2px",
           {{"256x256_enlarged", f_score(resize_bilinear(coarse, width, height), half)},
            {"256x256_filtered", f_score(filtered, half)},
            {"64x48_enlarged", f_score(resize_bilinear(rough, width, height), half)},
            {"64x48_filtered", f_score(pipeline::filter_mask(rough, problem.guide), half)}}}};
}

/// Ours beside OpenCV's at 1344 x 1008 (half of a capture), same sigmas, lambda and iterations.
nlohmann::ordered_json bench_against_opencv([[maybe_unused]] const Problem& problem) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
#ifdef DUALPIXEL_XIMGPROC
  const Small half = reduced(problem, 2);
  for (const BilateralGridOptions& cells :
       {BilateralGridOptions{8, 8, 8}, BilateralGridOptions{8, 4, 4}, BilateralGridOptions{16, 16, 16}}) {
    Image ours, theirs;
    pipeline::BilateralGrid grid;
    const auto [ms, cpu_ms] =
        times({[&] { ours = solve(half, cells, {}); }, [&] { theirs = solve_with_opencv(half, cells); },
               [&] { grid = pipeline::make_bilateral_grid(half.guide, cells); }},
              3);
    const double vertices = grid.vertices;
    grid = {};
    const auto enlarged = [&](const Image& map) {
      return figures(problem, resize_bilinear(map, problem.guide.width, problem.guide.height));
    };
    nlohmann::ordered_json row = {{"cells", {cells.cell_px, cells.cell_luma, cells.cell_chroma}},
                                  {"vertices", vertices},
                                  {"ms", ms[0]},
                                  {"grid_ms", ms[2]},
                                  {"opencv_ms", ms[1]},
                                  {"cpu_ms", cpu_ms[0]},
                                  {"opencv_cpu_ms", cpu_ms[1]},
                                  {"times_faster", ms[1] / ms[0]},
                                  {"times_less_cpu", cpu_ms[1] / cpu_ms[0]},
                                  {"peak_mb", peak_mb([&] { solve(half, cells, {}); })},
                                  {"opencv_peak_mb", peak_mb([&] { solve_with_opencv(half, cells); })},
                                  {"ours", enlarged(ours)},
                                  {"opencv", enlarged(theirs)}};
    rows.push_back(row);
  }
#endif
  return rows;
}

nlohmann::ordered_json bench_failures() {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const evaluation::EdgeFailure& failure : evaluation::edge_failures()) {
    nlohmann::ordered_json row = {
        {"failure", failure.name}, {"figure", failure.figure_name}, {"ours", evaluation::solve_failure(failure)}};
#ifdef DUALPIXEL_XIMGPROC
    row["opencv"] = failure.figure(solve_with_opencv({failure.guide, failure.target, failure.confidence}, {}));
#endif
    rows.push_back(row);
  }
  return rows;
}

nlohmann::ordered_json bench_methods(const Problem& matched, const Problem& known, Progress& progress) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const std::vector<Method> all = methods();
  for (std::size_t i = 0; i < all.size(); ++i) {
    progress(0.3 + 0.7 * static_cast<double>(i) / static_cast<double>(all.size()));
    nlohmann::ordered_json row = {{"family", all[i].family}, {"name", all[i].name}};
    for (const Problem* problem : {&matched, &known}) {
      const Small small = reduced(*problem, all[i].divisor);
      Image result;
      const Times time = times({[&] {
                                 result = median_3x3(all[i].smooth(small));
                                 result = pipeline::joint_upsample(result, small.guide, problem->guide);
                               }},
                               2);
      nlohmann::ordered_json errors = {{"ms", time.ms[0]}, {"cpu_ms", time.cpu_ms[0]}};
      errors.update(figures(*problem, result));
      row[problem == &matched ? "matched" : "known"] = errors;
    }
    rows.push_back(row);
  }
  return rows;
}

/// A figure of a failure's row; not a number: the library said so.
std::string figure_text(const nlohmann::ordered_json& row, const char* key) {
  if (!row.contains(key)) return "";
  const double value = row[key].is_number() ? row[key].get<double>() : std::nan("");
  return fmt::format("{:.4g}", value);
}

std::string to_page(const nlohmann::ordered_json& results) {
  const std::pair<const char*, const char*> axes[] = {{"rmse_dp_px", "RMSE, DP px"},
                                                      {"edge_mae_dp_px", "MAE within 3 px of depth edges, DP px"},
                                                      {"thin_mae_dp_px", "MAE on thin structures, DP px"}};
  std::string body =
      "<h1>Edge-aware smoothing: error against time</h1><p>Capture: " +
      evaluation::escape_html(printable(results["capture"].get<std::string>())) +
      ". Disparity smoothed (at a quarter of the capture's size unless said), median, joint "
      "upsampling; times are of all that. Matched: the paper's matches, fitted to the truth. Known: the "
      "truth with noise of 0.15 DP px, 5 % outliers, and nothing within 16 px of depth edges.</p><div class=\"plots\">";
  for (const char* target : {"matched", "known"}) {
    for (const auto& [key, label] : axes) {
      evaluation::Plot plot;
      plot.title = fmt::format("{}: {}", target, label);
      plot.x_label = "CPU ms";
      plot.y_label = label;
      plot.log_x = true;
      for (const auto& row : results["methods"]) {
        const std::string family = row["family"];
        if (plot.series.empty() || plot.series.back().name != family) plot.series.push_back({family, {}, false, true});
        plot.series.back().points.emplace_back(row[target]["cpu_ms"].get<double>(), row[target][key].get<double>());
      }
      body += evaluation::svg_plot(plot);
    }
  }
  body +=
      "</div><div class=\"scroll\"><table><tr><th>family</th><th>variant</th><th>target</th><th>ms</th><th>CPU "
      "ms</th><th>RMSE</th><th>MAE</th><th>RMSE at edges</th><th>MAE at edges</th><th>10-90 % width, px</th><th>MAE, "
      "thin</th></tr>";
  for (const auto& row : results["methods"]) {
    for (const char* target : {"matched", "known"}) {
      body += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td>",
                          evaluation::escape_html(row["family"].get<std::string>()),
                          evaluation::escape_html(row["name"].get<std::string>()), target);
      for (const auto& [key, value] : row[target].items()) {
        const int digits = key == "ms" || key == "cpu_ms" || key == "edge_width_px" ? 1 : 4;
        body += fmt::format("<td>{:.{}f}</td>", value.get<double>(), digits);
      }
      body += "</tr>";
    }
  }
  body +=
      "</table></div><h2>Where solvers fail</h2><div class=\"scroll\"><table><tr><th>case</th><th>figure, 0 is "
      "perfect</th><th>ours</th><th>OpenCV's</th></tr>";
  for (const auto& row : results["failures"]) {
    body += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
                        evaluation::escape_html(row["failure"].get<std::string>()),
                        evaluation::escape_html(row["figure"].get<std::string>()), figure_text(row, "ours"),
                        figure_text(row, "opencv"));
  }
  return evaluation::html_page("Edge-aware smoothing: error against time",
                               std::string(evaluation::kReportStyle) + evaluation::kPlotStyle, body + "</table></div>");
}

void print(const nlohmann::ordered_json& results) {
  const auto& paths = results["paths"];
  std::cout << fmt::format(
      "disparity {:6.1f} ms ({:.1f} ms of CPU): solve {:.1f}, median {:.1f}, upsample {:.1f}\n"
      "mask      {:6.1f} ms ({:.1f} ms of CPU)\n",
      paths["disparity_ms"].get<double>(), paths["disparity_cpu_ms"].get<double>(), paths["solve_ms"].get<double>(),
      paths["median_ms"].get<double>(), paths["upsample_ms"].get<double>(), paths["mask_ms"].get<double>(),
      paths["mask_cpu_ms"].get<double>());
  for (const auto& [name, score] : paths["mask_boundary_f_2px"].items()) {
    std::cout << fmt::format("  boundary F at 2 px, {:<20}{:.3f}\n", name, score.get<double>());
  }
  for (const auto& row : results["opencv"]) {
    std::cout << fmt::format(
        "cells {}: {:.1f} ms (grid {:.1f}), OpenCV {:.1f}: {:.2f} times; {:.1f} MB, OpenCV {:.1f} MB; RMSE {:.4f} / "
        "{:.4f}, at edges {:.4f} / {:.4f}, width {:.1f} / {:.1f} px\n",
        row["cells"].dump(), row["ms"].get<double>(), row["grid_ms"].get<double>(), row["opencv_ms"].get<double>(),
        row["times_faster"].get<double>(), row["peak_mb"].get<double>(), row["opencv_peak_mb"].get<double>(),
        row["ours"]["rmse_dp_px"].get<double>(), row["opencv"]["rmse_dp_px"].get<double>(),
        row["ours"]["edge_rmse_dp_px"].get<double>(), row["opencv"]["edge_rmse_dp_px"].get<double>(),
        row["ours"]["edge_width_px"].get<double>(), row["opencv"]["edge_width_px"].get<double>());
  }
  for (const auto& row : results["failures"]) {
    std::cout << fmt::format("{:<36}{:<56}{:>10}{:>10}\n", row["failure"].get<std::string>(),
                             row["figure"].get<std::string>(), figure_text(row, "ours"), figure_text(row, "opencv"));
  }
  for (const char* target : {"matched", "known"}) {
    std::cout << fmt::format("{:<28}{:<18}{:>8}{:>8}{:>9}{:>9}{:>11}{:>10}{:>9}{:>10}\n", target, "", "ms", "CPU ms",
                             "RMSE", "MAE", "edge RMSE", "edge MAE", "width", "thin MAE");
    for (const auto& row : results["methods"]) {
      const auto& errors = row[target];
      std::cout << fmt::format("{:<28}{:<18}{:>8.1f}{:>8.1f}{:>9.4f}{:>9.4f}{:>11.4f}{:>10.4f}{:>9.1f}{:>10.4f}\n",
                               row["family"].get<std::string>(), row["name"].get<std::string>(),
                               errors["ms"].get<double>(), errors["cpu_ms"].get<double>(),
                               errors["rmse_dp_px"].get<double>(), errors["mae_dp_px"].get<double>(),
                               errors["edge_rmse_dp_px"].get<double>(), errors["edge_mae_dp_px"].get<double>(),
                               errors["edge_width_px"].get<double>(), errors["thin_mae_dp_px"].get<double>());
    }
  }
}

void run(const BenchEdgesOptions& options) {
  Progress progress("smoothing");
  const Problem problem = make_problem(options.capture);
  progress(0.2);
  nlohmann::ordered_json results = {{"capture", options.capture}};
  results["paths"] = bench_paths(problem);
  results["opencv"] = bench_against_opencv(problem);
  results["failures"] = bench_failures();
  results["methods"] = bench_methods(problem, with_known_errors(problem), progress);
  progress(1);
  if (!options.page.empty()) replace_file(options.page, to_page(results));
  if (options.json)
    std::cout << results.dump(2) << '\n';
  else
    print(results);
}

}  // namespace

void add_bench_edges(CLI::App& bench) {
  auto options = std::make_shared<BenchEdgesOptions>();
  CLI::App* command = bench.add_subcommand(
      "edges", "Time edge-aware smoothing, and OpenCV's where it was built in; errors on a rendered capture");
  command->add_option("capture", options->capture, "Capture folder that holds truth")->type_name("CAPTURE")->required();
  command->add_option("-o,--output", options->page, "Write a page with the charts")->type_name("PAGE.html");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  dualpixel simulate build/release/scenes/portrait.json -o out/portrait\n  dualpixel bench edges "
      "out/portrait -o "
      "bench-edges.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
