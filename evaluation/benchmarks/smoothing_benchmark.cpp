#include "evaluation/benchmarks/smoothing_benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/image/median.h"
#include "capture/image/resample.h"
#include "capture/timing.h"
#include "capture/views.h"
#include "evaluation/benchmarks/opencv/smoothing_peers.h"
#include "evaluation/experiments/edge_failures.h"
#include "evaluation/metrics/edge_metrics.h"
#include "pipeline/edge_aware/bilateral_grid.h"
#include "pipeline/edge_aware/bilateral_solver.h"
#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/edge_aware/joint_upsample.h"
#include "pipeline/portrait/run_portrait.h"

namespace dualpixel::evaluation {
namespace {

using pipeline::BilateralGridOptions;
using pipeline::BilateralSolverOptions;

constexpr float kJump = 0.2f;  // DP px: a depth edge
constexpr int kEdgeReachPx = 3;

/// Matches at DP resolution; the picture and the truth at the capture's size.
struct Problem {
  Image input;  ///< linear RGB
  pipeline::ConfidentMap matches;
  Image truth;
  Mask valid, edges, thin, person;
};

pipeline::SmoothOptions options_of(int divisor, const BilateralGridOptions& cells = {},
                                   const BilateralSolverOptions& solver = {}) {
  pipeline::SmoothOptions options;
  options.divisor = divisor;
  options.grid = cells;
  options.solver = solver;
  return options;
}

/// What the solver works on at 1 / divisor of the capture's size.
SmoothingInput reduced(const Problem& problem, int divisor) {
  SmoothingInput input;
  input.guide = pipeline::make_smoothing_guide(problem.input, options_of(divisor));
  input.map = pipeline::reduce_by_confidence(problem.matches, input.guide.small.width, input.guide.small.height);
  return input;
}

Image solve(const SmoothingInput& input, const BilateralGridOptions& cells) {
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(input.guide.small, cells);
  return pipeline::solve_bilateral(grid, input.guide.small, input.map.value, input.map.confidence).value;
}

SmoothingMethod solver(const std::string& family, const std::string& name, int divisor,
                       const BilateralGridOptions& cells = {}, const BilateralSolverOptions& options = {}) {
  return {family, name, divisor, [=](const SmoothingInput& input) {
            return pipeline::solve_and_median(input.map, input.guide.small, options_of(divisor, cells, options));
          }};
}

std::vector<SmoothingMethod> smoothing_methods() {
  std::vector<SmoothingMethod> all = {
      {"none", "enlarged", 4, [](const SmoothingInput& input) { return median_3x3(input.map.value); }}};
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
  for (const SmoothingMethod& peer : opencv_smoothing_methods()) {
    all.push_back({peer.family, peer.name, peer.divisor,
                   [peer](const SmoothingInput& input) { return median_3x3(peer.smooth(input)); }});
  }
  return all;
}

/// Fits the matches to the truth, as calibration would, so that errors are those which smoothing can reduce.
void calibrate(Problem& problem) {
  const Image large = resize_bilinear(problem.matches.value, problem.truth.width, problem.truth.height);
  const Image confidence = resize_bilinear(problem.matches.confidence, problem.truth.width, problem.truth.height);
  std::vector<float> estimate, truth;
  for (std::size_t i = 0; i < large.data.size(); ++i) {
    if (!problem.valid.data[i] || confidence.data[i] < 0.5f) continue;
    estimate.push_back(large.data[i]);
    truth.push_back(problem.truth.data[i]);
  }
  const AffineFit fit = fit_affine(estimate, truth);
  for (float& value : problem.matches.value.data) value = static_cast<float>(fit.scale * value + fit.offset);
}

/// The same with the truth in place of matches: noise of 0.15 DP px, 5 % outliers of up to 1 DP px, and no confidence
/// within 16 px of a depth edge, where a matcher's windows straddle it.
Problem with_known_errors(Problem problem) {
  const int width = problem.input.width / 4, height = problem.input.height / 4;
  problem.matches.value = resize_area(problem.truth, width, height);
  problem.matches.confidence = Image(width, height, 1, 1.0f);
  const Mask unknown = depth_edges(problem.truth, kJump, 16);
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 0.15f);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int u = 4 * x + 2, v = 4 * y + 2;
      const bool outlier = std::abs(uniform(random)) < 0.05f;
      problem.matches.value.at(x, y) += outlier ? uniform(random) : noise(random);
      if (unknown.at(u, v) || !problem.valid.at(u, v)) problem.matches.confidence.at(x, y) = 0;
    }
  }
  return problem;
}

/// The capture's input picture, with the paper's matches.
Problem make_problem(const std::string& path) {
  Capture capture = read_capture(path, true);
  require_views(capture, path);
  if (!capture.truth) throw InputError(printable(path) + ": holds no truth to measure errors against");
  Problem problem;
  problem.truth = std::move(capture.truth->disparity_dp_px);
  const auto mask_of = [](const Image& map) {
    Mask mask(map.width, map.height);
    for (std::size_t i = 0; i < map.data.size(); ++i) mask.data[i] = map.data[i] > 0.5f;
    return mask;
  };
  problem.valid = mask_of(capture.truth->valid);
  problem.person = mask_of(capture.truth->person_mask);
  const bool moved = !capture.truth->motion.empty();
  capture.truth.reset();
  pipeline::PortraitResult portrait = pipeline::run_portrait(capture, pipeline::PortraitOptions());
  if (moved && portrait.base_frame > 0) {
    throw InputError(
        fmt::format("{}: truth/motion: the base is frame {}, and truth is frame 0's: give a static "
                    "burst",
                    printable(path), portrait.base_frame));
  }
  problem.input = std::move(portrait.input);
  problem.matches.value = std::move(portrait.matched_disparity_dp_px);
  problem.matches.confidence = std::move(portrait.matched_confidence);
  calibrate(problem);
  problem.edges = depth_edges(problem.truth, kJump, kEdgeReachPx);
  problem.thin = thin_structures(problem.truth, kJump);
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

SmoothingErrors errors_of(const Problem& problem, const Image& estimate) {
  Errors all, edges, thin;
  for (std::size_t i = 0; i < estimate.data.size(); ++i) {
    if (!problem.valid.data[i]) continue;
    const double error = estimate.data[i] - problem.truth.data[i];
    all.add(error);
    if (problem.edges.data[i]) edges.add(error);
    if (problem.thin.data[i]) thin.add(error);
  }
  return {all.rmse(), all.mae(), edges.rmse(), edges.mae(), edge_width_px(estimate, problem.truth, kJump), thin.mae()};
}

/// F-scores of two coarse masks, enlarged and filtered.
std::vector<SmoothingStages::MaskScore> score_masks(const Problem& problem, const Image& guide, const Image& mask,
                                                    const Image& coarse, const Image& filtered) {
  const auto f_score = [&](const Image& map) {
    Mask estimate(map.width, map.height);
    for (std::size_t i = 0; i < map.data.size(); ++i) estimate.data[i] = map.data[i] > 0.5f;
    return boundary_f_score(estimate, problem.person, 2);
  };
  const Image rough = resize_area(mask, 64, 48);
  const int width = mask.width, height = mask.height;
  return {{"256x256_enlarged", f_score(resize_bilinear(coarse, width, height))},
          {"256x256_filtered", f_score(filtered)},
          {"64x48_enlarged", f_score(resize_bilinear(rough, width, height))},
          {"64x48_filtered", f_score(pipeline::filter_mask(rough, guide))}};
}

SmoothingStages measure_stages(const Problem& problem) {
  const SmoothingInput small = reduced(problem, 4);
  const Image guide = pipeline::encode_guide(problem.input, pipeline::guide_gain(problem.input));
  const Image large_guide = pipeline::encode_guide(problem.input, small.guide.gain);
  Image mask(problem.person.width, problem.person.height);
  std::copy(problem.person.data.begin(), problem.person.data.end(), mask.data.begin());
  const Image coarse = resize_area(mask, 256, 256);
  Image solved, smooth, large, filtered;
  const auto [ms, cpu_ms] = times({[&] { solved = solve(small, {}); }, [&] { smooth = median_3x3(solved); },
                                   [&] { large = pipeline::joint_upsample(smooth, small.guide.small, large_guide); },
                                   [&] { filtered = pipeline::filter_mask(coarse, guide); }},
                                  7);
  return {ms[0],
          ms[1],
          ms[2],
          ms[3],
          cpu_ms[0] + cpu_ms[1] + cpu_ms[2],
          cpu_ms[3],
          peak_mb([&] { solve(small, {}); }),
          score_masks(problem, guide, mask, coarse, filtered)};
}

std::vector<SolverComparison> compare_with_opencv(const Problem& problem) {
  const SmoothingInput half = reduced(problem, 2);
  std::vector<SolverComparison> rows;
  for (const BilateralGridOptions& cells :
       {BilateralGridOptions{8, 8, 8}, BilateralGridOptions{8, 4, 4}, BilateralGridOptions{16, 16, 16}}) {
    Image ours;
    std::optional<Image> theirs;
    pipeline::BilateralGrid grid;
    if (!solve_with_opencv(half, cells)) return {};  // no OpenCV in this build
    const auto [ms, cpu_ms] =
        times({[&] { ours = solve(half, cells); }, [&] { theirs = solve_with_opencv(half, cells); },
               [&] { grid = pipeline::make_bilateral_grid(half.guide.small, cells); }},
              3);
    SolverComparison row;
    row.cells = cells;
    row.vertices = grid.vertices;
    grid = {};
    row.ms = ms[0], row.opencv_ms = ms[1], row.grid_ms = ms[2];
    row.cpu_ms = cpu_ms[0], row.opencv_cpu_ms = cpu_ms[1];
    row.peak_mb = peak_mb([&] { solve(half, cells); });
    row.opencv_peak_mb = peak_mb([&] { solve_with_opencv(half, cells); });
    const int width = problem.input.width, height = problem.input.height;
    row.ours = errors_of(problem, resize_bilinear(ours, width, height));
    row.opencv = errors_of(problem, resize_bilinear(*theirs, width, height));
    rows.push_back(row);
  }
  return rows;
}

std::vector<SolverFailure> measure_solver_failures() {
  std::vector<SolverFailure> rows;
  for (const EdgeFailure& failure : edge_failures()) {
    const std::optional<Image> theirs = solve_with_opencv({{failure.guide}, {failure.target, failure.confidence}}, {});
    rows.push_back({failure.name, failure.figure_name, solve_failure(failure),
                    theirs ? std::optional(failure.figure(*theirs)) : std::nullopt});
  }
  return rows;
}

SmoothingRun run_method(const SmoothingMethod& method, const Problem& problem) {
  const SmoothingInput small = reduced(problem, method.divisor);
  Image result;
  const auto smooth = [&] {
    result = pipeline::upsample_along_edges(method.smooth(small), small.guide, problem.input);
  };
  const Times time = times({smooth}, 2);
  return {time.ms[0], time.cpu_ms[0], peak_mb(smooth), errors_of(problem, result)};
}

}  // namespace

SmoothingBenchmark measure_smoothing(const std::string& capture_path, const std::function<void(double)>& progress) {
  const auto report = [&](double fraction) {
    if (progress) progress(fraction);
  };
  const Problem matched = make_problem(capture_path), known = with_known_errors(matched);
  report(0.2);
  SmoothingBenchmark benchmark;
  benchmark.capture = capture_path;
  benchmark.stages = measure_stages(matched);
  benchmark.opencv = compare_with_opencv(matched);
  benchmark.failures = measure_solver_failures();
  const std::vector<SmoothingMethod> all = smoothing_methods();
  for (std::size_t i = 0; i < all.size(); ++i) {
    report(0.3 + 0.7 * static_cast<double>(i) / static_cast<double>(all.size()));
    benchmark.methods.push_back({all[i].family, all[i].name, run_method(all[i], matched), run_method(all[i], known)});
  }
  report(1);
  return benchmark;
}

namespace {

nlohmann::ordered_json to_json(const SmoothingErrors& e) {
  return {{"rmse_dp_px", e.rmse_dp_px},           {"mae_dp_px", e.mae_dp_px},
          {"edge_rmse_dp_px", e.edge_rmse_dp_px}, {"edge_mae_dp_px", e.edge_mae_dp_px},
          {"edge_width_px", e.edge_width_px},     {"thin_mae_dp_px", e.thin_mae_dp_px}};
}

nlohmann::ordered_json to_json(const SmoothingRun& run) {
  nlohmann::ordered_json json = {{"ms", run.ms}, {"cpu_ms", run.cpu_ms}, {"memory_mb", run.memory_mb}};
  json.update(to_json(run.errors));
  return json;
}

nlohmann::ordered_json to_json(const SmoothingStages& s) {
  nlohmann::ordered_json masks;
  for (const SmoothingStages::MaskScore& mask : s.masks) masks[mask.name] = mask.boundary_f;
  return {{"solve_ms", s.solve_ms},       {"median_ms", s.median_ms},
          {"upsample_ms", s.upsample_ms}, {"disparity_ms", s.solve_ms + s.median_ms + s.upsample_ms},
          {"mask_ms", s.mask_ms},         {"disparity_cpu_ms", s.disparity_cpu_ms},
          {"mask_cpu_ms", s.mask_cpu_ms}, {"solve_peak_mb", s.solve_peak_mb},
          {"mask_boundary_f_2px", masks}};
}

nlohmann::ordered_json to_json(const SolverComparison& c) {
  return {{"cells", {c.cells.cell_px, c.cells.cell_luma, c.cells.cell_chroma}},
          {"vertices", c.vertices},
          {"ms", c.ms},
          {"grid_ms", c.grid_ms},
          {"opencv_ms", c.opencv_ms},
          {"cpu_ms", c.cpu_ms},
          {"opencv_cpu_ms", c.opencv_cpu_ms},
          {"times_faster", c.opencv_ms / c.ms},
          {"times_less_cpu", c.opencv_cpu_ms / c.cpu_ms},
          {"peak_mb", c.peak_mb},
          {"opencv_peak_mb", c.opencv_peak_mb},
          {"ours", to_json(c.ours)},
          {"opencv", to_json(c.opencv)}};
}

}  // namespace

nlohmann::ordered_json to_json(const SmoothingBenchmark& benchmark) {
  nlohmann::ordered_json opencv = nlohmann::ordered_json::array(), failures = opencv, methods = opencv;
  for (const SolverComparison& comparison : benchmark.opencv) opencv.push_back(to_json(comparison));
  for (const SolverFailure& f : benchmark.failures) {
    failures.push_back({{"failure", f.failure}, {"figure", f.figure}, {"ours", f.ours}});
    if (f.opencv) failures.back()["opencv"] = *f.opencv;
  }
  for (const SmoothingComparison& m : benchmark.methods) {
    methods.push_back(
        {{"family", m.family}, {"name", m.name}, {"matched", to_json(m.matched)}, {"known", to_json(m.known)}});
  }
  return {{"capture", benchmark.capture},
          {"paths", to_json(benchmark.stages)},
          {"opencv", opencv},
          {"failures", failures},
          {"methods", methods}};
}

}  // namespace dualpixel::evaluation
