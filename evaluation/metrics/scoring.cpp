#include "evaluation/metrics/scoring.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "evaluation/metrics/image_metrics.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

/// Bilinear at pixel + motion; outside of the picture its border, or `outside` where that is given.
Image moved_by(const Image& image, const Image& motion, std::optional<float> outside) {
  Image moved(image.width, image.height, image.channels);
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      const float u = static_cast<float>(x) + motion.at(x, y, 0), v = static_cast<float>(y) + motion.at(x, y, 1);
      const float right = static_cast<float>(image.width - 1), bottom = static_cast<float>(image.height - 1);
      const bool inside = u >= -0.5f && v >= -0.5f && u <= right + 0.5f && v <= bottom + 0.5f;
      const float near_u = std::clamp(u, 0.0f, right), near_v = std::clamp(v, 0.0f, bottom);
      const int i = static_cast<int>(near_u), j = static_cast<int>(near_v);
      const int next_i = std::min(i + 1, image.width - 1), next_j = std::min(j + 1, image.height - 1);
      const float a = near_u - static_cast<float>(i), b = near_v - static_cast<float>(j);
      for (int c = 0; c < image.channels; ++c) {
        const float sum = (1 - b) * ((1 - a) * image.at(i, j, c) + a * image.at(next_i, j, c)) +
                          b * ((1 - a) * image.at(i, next_j, c) + a * image.at(next_i, next_j, c));
        moved.at(x, y, c) = inside ? sum : outside.value_or(sum);
      }
    }
  });
  return moved;
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// The pixels of one region, one after the other.
struct Samples {
  std::vector<float> estimate, truth;
  std::vector<float> confidence, sigma;  ///< empty where not given
};

/// `inside(i)` tells whether pixel i belongs to the region.
template <typename Inside>
Samples gather(const Truth& truth, const Estimate& given, const Inside& inside) {
  Samples samples;
  for (std::size_t i = 0; i < truth.valid.data.size(); ++i) {
    const float estimate = given.disparity_dp_px.data[i];
    if (truth.valid.data[i] != 1 || !std::isfinite(estimate) || !inside(i)) continue;
    samples.estimate.push_back(estimate);
    samples.truth.push_back(truth.disparity_dp_px.data[i]);
    const float sigma = given.sigma_dp_px.empty() ? 0 : given.sigma_dp_px.data[i];
    if (!given.sigma_dp_px.empty()) samples.sigma.push_back(sigma);
    if (!given.confidence.empty()) {
      const float confidence = given.confidence.data[i];
      samples.confidence.push_back(std::isfinite(confidence) ? confidence : 0);
    } else if (!given.sigma_dp_px.empty()) {
      samples.confidence.push_back(std::isnan(sigma) ? -std::numeric_limits<float>::infinity() : -sigma);
    }
  }
  return samples;
}

constexpr const char* kBadPixelKeys[] = {"bad_0p1", "bad_0p25", "bad_0p5"};

/// Sigma against the errors as they are.
void score_sigma(const Samples& samples, RegionScore& score) {
  double one = 0, two = 0, count = 0;
  for (std::size_t i = 0; i < samples.sigma.size(); ++i) {
    if (std::isnan(samples.sigma[i])) continue;
    const float error = std::abs(samples.estimate[i] - samples.truth[i]);
    ++count;
    one += error <= samples.sigma[i];
    two += error <= 2 * samples.sigma[i];
  }
  if (count == 0) return;
  score.within_one_sigma = one / count;
  score.within_two_sigma = two / count;
}

RegionScore score_region(const std::string& region, const Samples& samples, std::size_t valid_pixels) {
  const std::vector<float>&estimate = samples.estimate, &truth = samples.truth;
  RegionScore score;
  score.region = region;
  score.pixels = estimate.size();
  if (valid_pixels) score.coverage = static_cast<double>(estimate.size()) / valid_pixels;
  if (estimate.empty()) return score;

  score.bias_px = bias(estimate, truth);
  score.rmse_px = rmse(estimate, truth);
  const AffineFit fit = fit_affine(estimate, truth);
  score.fit = fit;
  score.rmse_affine_px = rmse(estimate, truth, fit);
  for (std::size_t i = 0; i < std::size(kBadPixelDpPx); ++i) {
    score.bad[i] = bad_pixel_rate(estimate, truth, kBadPixelDpPx[i]);
    score.bad_affine[i] = bad_pixel_rate(estimate, truth, kBadPixelDpPx[i], fit);
  }
  score.aiwe1 = aiwe1(estimate, truth);
  const std::optional<double> rho = spearman(estimate, truth);
  if (rho) score.one_minus_rho = 1 - std::abs(*rho);
  score_sigma(samples, score);
  if (samples.confidence.empty()) return score;

  std::vector<float> error(estimate.size());
  for (std::size_t i = 0; i < error.size(); ++i) {
    error[i] = static_cast<float>(std::abs(fit.scale * estimate[i] + fit.offset - truth[i]));
  }
  score.sparsification = sparsification(error, samples.confidence);
  return score;
}

std::vector<RegionScore> score_disparity(const Truth& truth, const Estimate& given) {
  const Mask edges = depth_edges(truth.disparity_dp_px, kEdgeJumpDpPx, kEdgeReachPx);
  std::size_t valid_pixels = 0;
  for (const float valid : truth.valid.data) valid_pixels += valid == 1;

  const auto confident = [&](std::size_t i) {
    return given.confidence.empty() ? given.sigma_dp_px.data[i] < kConfidentDpPx
                                    : given.confidence.data[i] >= kConfidentThreshold;
  };
  std::vector<RegionScore> scores(4);
  const auto score = [&](const char* region, const auto& inside) {
    return score_region(region, gather(truth, given, inside), valid_pixels);
  };
  const bool sorted = !given.confidence.empty() || !given.sigma_dp_px.empty();
  tbb::parallel_invoke([&] { scores[0] = score("everything", [](std::size_t) { return true; }); },
                       [&] {
                         if (sorted) scores[1] = score("confident", confident);
                       },
                       [&] { scores[2] = score("depth_edges", [&](std::size_t i) { return edges.data[i] == 1; }); },
                       [&] {
                         scores[3] = score("person",
                                           [&](std::size_t i) { return truth.person_mask.data[i] > kPersonThreshold; });
                       });
  if (!sorted) scores.erase(scores.begin() + 1);
  return scores;
}

std::optional<PictureScore> score_picture(const Image& linear, const Image& photograph) {
  if (linear.empty()) return {};
  const auto compare = [&](const auto& encode, std::optional<double>& psnr, std::optional<double>& similarity) {
    const Image a = encode(linear), b = encode(photograph);
    psnr = psnr_db(a, b);
    similarity = ssim(a, b);
  };
  PictureScore score;
  compare([](const Image& image) { return displayed(image); }, score.psnr_srgb_db, score.ssim_srgb);
  compare(clipped, score.psnr_linear_db, score.ssim_linear);
  return score;
}

/// A picture's mean square error against truth is its own and the truth's noise together.
std::optional<double> truth_noise_db(const Truth& truth, const Score& score) {
  if (!truth.noise) return {};
  std::optional<double> worst;
  for (const std::optional<PictureScore>* picture : {&score.portrait, &score.input}) {
    if (!*picture || !(*picture)->psnr_linear_db) continue;
    const double square_error = std::pow(10, -*(*picture)->psnr_linear_db / 10);
    const double share = truth.noise->photograph * truth.noise->photograph / square_error;
    // the noise is an estimate, and may come out above what it is part of
    const double db = share < 1 ? std::min(-10 * std::log10(1 - share), kTruthNoiseLimitDb) : kTruthNoiseLimitDb;
    worst = std::max(worst.value_or(0), db);
  }
  return worst;
}

/// The figures of the pictures that there are with their keys, in the order of score.json.
std::vector<std::pair<std::string, std::optional<double>>> picture_figures(const Score& score) {
  const PictureScore p = score.portrait.value_or(PictureScore()), i = score.input.value_or(PictureScore());
  std::vector<std::pair<std::string, std::optional<double>>> figures = {{"psnr_srgb_db", p.psnr_srgb_db},
                                                                        {"ssim_srgb", p.ssim_srgb},
                                                                        {"psnr_srgb_input_db", i.psnr_srgb_db},
                                                                        {"ssim_srgb_input", i.ssim_srgb},
                                                                        {"psnr_linear_db", p.psnr_linear_db},
                                                                        {"ssim_linear", p.ssim_linear},
                                                                        {"psnr_linear_input_db", i.psnr_linear_db},
                                                                        {"ssim_linear_input", i.ssim_linear},
                                                                        {"psnr_db", p.psnr_srgb_db},
                                                                        {"psnr_input_db", i.psnr_srgb_db},
                                                                        {"ssim", p.ssim_srgb},
                                                                        {"ssim_input", i.ssim_srgb}};
  std::erase_if(figures, [&](const auto& figure) {
    return figure.first.find("input") != std::string::npos ? !score.input : !score.portrait;
  });
  return figures;
}

/// Why figures are none: a line each.
std::vector<std::string> explain_missing(const Score& score) {
  std::vector<std::string> notes;
  for (const RegionScore& region : score.disparity) {
    const std::string where = "disparity." + region.region;
    if (region.pixels == 0) {
      notes.push_back(where + ": no pixel is in this region with a valid truth and a finite estimate");
      continue;
    }
    if (!region.one_minus_rho) {
      notes.push_back(where + ".one_minus_rho_average_ranks: undefined, the estimate or the truth is constant");
    }
    const bool sorted = !region.sparsification.error.empty();
    if (sorted && !region.sparsification.ause) notes.push_back(where + ".ause: undefined, every error is 0");
  }
  for (const auto& [metric, value] : picture_figures(score)) {
    if (value) continue;
    notes.push_back("image." + metric +
                    (metric.starts_with("psnr") ? ": infinite, the pictures are the same"
                                                : ": undefined, the picture is smaller than a window of 11 x 11"));
  }
  return notes;
}

Json to_json(const RegionScore& score) {
  Json json = {{"pixels", score.pixels}, {"coverage", or_null(score.coverage)}};
  json["bias_px"] = or_null(score.bias_px);
  json["rmse_px"] = or_null(score.rmse_px);
  for (int i = 0; i < 3; ++i) json[kBadPixelKeys[i]] = or_null(score.bad[i]);
  json["affine_scale"] = score.fit ? Json(score.fit->scale) : Json(nullptr);
  json["affine_offset_px"] = score.fit ? Json(score.fit->offset) : Json(nullptr);
  json["rmse_affine_px"] = or_null(score.rmse_affine_px);
  for (int i = 0; i < 3; ++i) json[std::string(kBadPixelKeys[i]) + "_affine"] = or_null(score.bad_affine[i]);
  json["aiwe1"] = or_null(score.aiwe1);
  json["aiwe2"] = json["rmse_affine_px"];
  json["one_minus_rho_average_ranks"] = or_null(score.one_minus_rho);
  const Sparsification& curves = score.sparsification;
  if (score.pixels == 0 || !curves.error.empty()) {
    json["ause"] = or_null(curves.ause);
    json["sparsification"] = {{"removed", curves.removed}, {"error_px", curves.error}, {"oracle_px", curves.oracle}};
  }
  if (score.within_one_sigma) {
    json["within_one_sigma"] = *score.within_one_sigma;
    json["within_two_sigma"] = *score.within_two_sigma;
  }
  return json;
}

std::string figure_text(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

const Truth& required_truth(const Capture& capture, const std::string& capture_path) {
  if (!capture.truth) throw InputError(printable(capture_path) + ": holds no truth to score against");
  return *capture.truth;
}

/// Everything that is wrong with an estimate of anybody's making, in one line.
void require_fitting(const Capture& capture, const std::string& capture_path, const Estimate& estimate) {
  const Camera& camera = capture.camera;
  std::vector<std::string> problems;
  const auto size_text = [](const Image& image) {
    return fmt::format("{} x {} pixels of {} channel{}", image.width, image.height, image.channels,
                       image.channels == 1 ? "" : "s");
  };
  const auto require_map = [&](const Image& map, const char* name) {
    if (map.empty()) return;
    const bool full = map.width == camera.width_px && map.height == camera.height_px;
    const bool views = map.width == camera.dp_width() && map.height == camera.dp_height();
    if (map.channels == 1 && (full || views)) return;
    problems.push_back(fmt::format("{}: {}: must be one channel of {} x {} (the sensor) or {} x {} (the views)", name,
                                   size_text(map), camera.width_px, camera.height_px, camera.dp_width(),
                                   camera.dp_height()));
  };
  if (estimate.disparity_dp_px.empty() && estimate.portrait.empty()) {
    problems.emplace_back("nothing to score: give a disparity or a portrait");
  }
  if (estimate.disparity_dp_px.empty() && !(estimate.confidence.empty() && estimate.sigma_dp_px.empty())) {
    problems.emplace_back("confidence and sigma: are those of a disparity, which is not given");
  }
  const auto require_values = [&](const Image& map, const char* name, float most, const char* range) {
    const auto outside = std::find_if(map.data.begin(), map.data.end(), [&](float v) { return v < 0 || v > most; });
    if (outside != map.data.end()) problems.push_back(fmt::format("{}: {:g}: must lie in {}", name, *outside, range));
  };
  require_map(estimate.disparity_dp_px, "disparity");
  require_map(estimate.confidence, "confidence");
  require_map(estimate.sigma_dp_px, "sigma");
  require_values(estimate.confidence, "confidence", 1, "[0, 1]");
  require_values(estimate.sigma_dp_px, "sigma", std::numeric_limits<float>::infinity(), "[0, inf]");
  const Image &portrait = estimate.portrait, &photograph = capture.truth->photograph;
  if (!portrait.empty() && photograph.empty()) {
    problems.emplace_back("portrait: the truth has no photograph");
  } else if (!portrait.empty() && !(portrait.same_size(photograph) && portrait.channels == 3)) {
    problems.push_back(
        fmt::format("portrait: {}: must be {} x {} of 3", size_text(portrait), photograph.width, photograph.height));
  }
  if (!problems.empty()) {
    throw InputError(fmt::format("{}: {}", printable(capture_path), fmt::join(problems, "; ")));
  }
}

/// A map of the sensor's size: each photosite has the value of the DP pixel that covers it, lest surfaces blend.
Image on_sensor(const Image& map, const Camera& camera) {
  if (map.empty() || (map.width == camera.width_px && map.height == camera.height_px)) return map;
  Image full(camera.width_px, camera.height_px);
  for (int y = 0; y < full.height; ++y) {
    for (int x = 0; x < full.width; ++x) {
      full.at(x, y) = map.at(x / camera.dp_downsample_x, y / camera.dp_downsample_y);
    }
  }
  return full;
}

Score score_against(const Truth& truth, const Estimate& estimate, const Image& input) {
  Score score;
  if (!estimate.disparity_dp_px.empty()) score.disparity = score_disparity(truth, estimate);
  score.portrait = score_picture(estimate.portrait, truth.photograph);
  score.input = score_picture(input, truth.photograph);
  score.truth_noise_db = truth_noise_db(truth, score);
  score.notes = explain_missing(score);
  return score;
}

}  // namespace

Image seen_from_first(const Image& image, const pipeline::PortraitResult& result, const Truth& truth,
                      std::optional<float> outside) {
  const bool has_moved = result.base_frame > 0 && !truth.motion.empty() && !image.empty();
  return has_moved ? moved_by(image, truth.motion[result.base_frame - 1], outside) : image;
}

Score score_result(const Capture& capture, const std::string& capture_path, const pipeline::StoredResult& stored,
                   const std::string& result_path) {
  const Truth& truth = required_truth(capture, capture_path);
  if (!stored.result.input.same_size(truth.photograph)) {
    throw InputError(fmt::format("{}: {} x {} pixels; the capture {} has {} x {}", printable(result_path),
                                 stored.result.input.width, stored.result.input.height, printable(capture_path),
                                 truth.photograph.width, truth.photograph.height));
  }

  const pipeline::PortraitResult& result = stored.result;
  const int base = result.base_frame;
  if (base >= static_cast<int>(capture.frames.size())) {
    throw InputError(fmt::format("{}: /base_frame: {}; the capture {} has {} frames", printable(result_path), base,
                                 printable(capture_path), capture.frames.size()));
  }
  const Estimate seen = {.disparity_dp_px = seen_from_first(result.disparity_dp_px, result, truth, NAN),
                         .confidence = seen_from_first(result.confidence, result, truth, 0.0f),
                         .portrait = seen_from_first(result.portrait, result, truth)};
  Score score = score_against(truth, seen, seen_from_first(result.input, result, truth));
  score.capture = capture_path;
  score.result = result_path;
  score.mode = stored.mode.empty() ? "unknown" : stored.mode;
  score.stages = result.stages;
  return score;
}

Score score_estimate(const Capture& capture, const std::string& capture_path, const Estimate& estimate) {
  const Truth& truth = required_truth(capture, capture_path);
  require_fitting(capture, capture_path, estimate);
  const Camera& camera = capture.camera;
  Score score = score_against(truth,
                              {on_sensor(estimate.disparity_dp_px, camera), on_sensor(estimate.confidence, camera),
                               on_sensor(estimate.sigma_dp_px, camera), estimate.portrait},
                              {});
  score.capture = capture_path;
  return score;
}

Json to_json(const Score& score) {
  Json json = {{"format", "dualpixel-score"}, {"version", 1}, {"capture", score.capture}};
  if (!score.result.empty()) json["result"] = score.result;
  if (!score.mode.empty()) json["mode"] = score.mode;
  if (!score.disparity.empty()) {
    json["definitions"] = {{"confident_threshold", kConfidentThreshold},
                           {"depth_edges_jump_dp_px", kEdgeJumpDpPx},
                           {"depth_edges_reach_px", kEdgeReachPx},
                           {"person_threshold", kPersonThreshold}};
    for (const RegionScore& region : score.disparity) json["disparity"][region.region] = to_json(region);
  }
  if (score.portrait || score.input) {
    for (const auto& [metric, value] : picture_figures(score)) json["image"][metric] = or_null(value);
    json["image"]["truth_noise_db"] = or_null(score.truth_noise_db);
  }
  if (!score.result.empty()) json["stages"] = Json::object();
  for (const pipeline::StageTime& stage : score.stages) {
    json["stages"][stage.name] = {{"ms", stage.ms}, {"peak_rss_mb", stage.peak_rss_mb}};
  }
  json["notes"] = score.notes;
  return json;
}

namespace {

std::string disparity_text(const std::vector<RegionScore>& regions) {
  std::string text = "Disparity, DP px; the last six after an affine fit or invariant to one\n";
  text += fmt::format("{:<12}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9} |{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "region", "coverage",
                      "bias", "RMSE", ">0.1", ">0.25", ">0.5", "RMSE", ">0.1", ">0.25", "AIWE(1)", "1-|rho|*", "AUSE");
  for (const RegionScore& r : regions) {
    text += fmt::format("{:<12}", r.region);
    for (const auto& figure : {r.coverage, r.bias_px, r.rmse_px, r.bad[0], r.bad[1], r.bad[2]}) {
      text += fmt::format("{:>9}", figure_text(figure, 3));
    }
    text += " |";
    for (const auto& figure :
         {r.rmse_affine_px, r.bad_affine[0], r.bad_affine[1], r.aiwe1, r.one_minus_rho, r.sparsification.ause}) {
      text += fmt::format("{:>9}", figure_text(figure, 3));
    }
    text += "\n";
  }
  text += "* Spearman's rho, ties get average ranks. RMSE after the fit is AIWE(2).\n";
  const RegionScore& all = regions.front();
  if (all.within_one_sigma) {
    text += fmt::format("Errors within one sigma: {:.3f}, within two: {:.3f}; 0.683 and 0.954 where sigma is right\n",
                        *all.within_one_sigma, *all.within_two_sigma);
  }
  return text;
}

std::string pictures_text(const Score& score) {
  std::string text = "Against the true photograph     PSNR sRGB  PSNR linear  SSIM sRGB  SSIM linear\n";
  for (const auto& [label, f] : {std::pair{"portrait", score.portrait}, {"input, not blurred", score.input}}) {
    if (!f) continue;
    text +=
        fmt::format("{:<30}{:>8} dB{:>10} dB{:>11}{:>13}\n", label, figure_text(f->psnr_srgb_db, 2),
                    figure_text(f->psnr_linear_db, 2), figure_text(f->ssim_srgb, 4), figure_text(f->ssim_linear, 4));
  }
  return text;
}

std::string stages_text(const std::vector<pipeline::StageTime>& stages) {
  std::string text = fmt::format("{:<20}{:>9}{:>18}\n", "Stage", "ms", "peak memory, MB");
  double total_ms = 0;
  for (const pipeline::StageTime& stage : stages) {
    total_ms += stage.ms;
    text += fmt::format("{:<20}{:>9.1f}{:>18.0f}\n", printable(stage.name), stage.ms, stage.peak_rss_mb);
  }
  return text + fmt::format("{:<20}{:>9.1f}\n", "total", total_ms);
}

}  // namespace

std::string to_text(const Score& score) {
  std::vector<std::string> parts;
  if (!score.disparity.empty()) {
    parts.push_back(disparity_text(score.disparity));
  } else if (!score.result.empty()) {
    parts.emplace_back("Disparity: none, the result was made from the person mask alone\n");
  }
  if (score.portrait || score.input) parts.push_back(pictures_text(score));
  if (!score.result.empty()) parts.push_back(stages_text(score.stages));
  std::string text = fmt::format("{}", fmt::join(parts, "\n"));
  for (const std::string& note : score.notes) text += "note: " + printable(note) + "\n";
  return text;
}

}  // namespace dualpixel::evaluation
