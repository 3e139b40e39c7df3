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

/// What `image`, which shows a later frame, shows of the points that the first frame sees: bilinear at pixel + motion,
/// outside of the picture its border, or `outside` where that is given.
Image seen_from_first(const Image& image, const Image& motion, std::optional<float> outside = {}) {
  if (image.empty()) return {};
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

bool has_moved(const pipeline::PortraitResult& result, const Truth& truth) {
  return result.base_frame > 0 && !truth.motion.empty();
}

/// What of a result is scored.
pipeline::PortraitResult seen_from_first(const pipeline::PortraitResult& result, const Truth& truth) {
  const Image& motion = truth.motion[result.base_frame - 1];
  pipeline::PortraitResult seen;
  seen.input = seen_from_first(result.input, motion);
  seen.portrait = seen_from_first(result.portrait, motion);
  seen.disparity_dp_px = disparity_seen_from_first(result, truth);
  seen.confidence = seen_from_first(result.confidence, motion, 0);
  seen.stages = result.stages;
  return seen;
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// The pixels of one region, one after the other.
struct Samples {
  std::vector<float> estimate, truth, confidence;
};

/// `inside(i)` tells whether pixel i belongs to the region.
template <typename Inside>
Samples gather(const Truth& truth, const pipeline::PortraitResult& result, const Inside& inside) {
  Samples samples;
  for (std::size_t i = 0; i < truth.valid.data.size(); ++i) {
    const float estimate = result.disparity_dp_px.data[i];
    if (truth.valid.data[i] != 1 || !std::isfinite(estimate) || !inside(i)) continue;
    samples.estimate.push_back(estimate);
    samples.truth.push_back(truth.disparity_dp_px.data[i]);
    const float confidence = result.confidence.data[i];
    samples.confidence.push_back(std::isfinite(confidence) ? confidence : 0);
  }
  return samples;
}

constexpr const char* kBadPixelKeys[] = {"bad_0p1", "bad_0p25", "bad_0p5"};

RegionScore score_region(const std::string& region, const Samples& samples, std::size_t valid_pixels) {
  const std::vector<float>&estimate = samples.estimate, &truth = samples.truth, &confidence = samples.confidence;
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

  std::vector<float> error(estimate.size());
  for (std::size_t i = 0; i < error.size(); ++i) {
    error[i] = static_cast<float>(std::abs(fit.scale * estimate[i] + fit.offset - truth[i]));
  }
  score.sparsification = sparsification(error, confidence);
  return score;
}

std::vector<RegionScore> score_disparity(const Truth& truth, const pipeline::PortraitResult& result) {
  const Mask edges = depth_edges(truth.disparity_dp_px, kEdgeJumpDpPx, kEdgeReachPx);
  std::size_t valid_pixels = 0;
  for (const float valid : truth.valid.data) valid_pixels += valid == 1;

  std::vector<RegionScore> scores(4);
  const auto score = [&](const char* region, const auto& inside) {
    return score_region(region, gather(truth, result, inside), valid_pixels);
  };
  tbb::parallel_invoke(
      [&] { scores[0] = score("everything", [](std::size_t) { return true; }); },
      [&] {
        scores[1] = score("confident", [&](std::size_t i) { return result.confidence.data[i] >= kConfidentThreshold; });
      },
      [&] { scores[2] = score("depth_edges", [&](std::size_t i) { return edges.data[i] == 1; }); },
      [&] {
        scores[3] = score("person", [&](std::size_t i) { return truth.person_mask.data[i] > kPersonThreshold; });
      });
  return scores;
}

PictureScore score_picture(const Image& linear, const Image& photograph) {
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
  constexpr double kMostShare = 0.99;  // the noise is an estimate, and may come out above what it is part of
  if (!truth.noise) return {};
  std::optional<double> worst;
  for (const PictureScore* picture : {&score.portrait, &score.input}) {
    if (!picture->psnr_linear_db) continue;
    const double square_error = std::pow(10, -*picture->psnr_linear_db / 10);
    const double share = std::min(truth.noise->photograph * truth.noise->photograph / square_error, kMostShare);
    worst = std::max(worst.value_or(0), -10 * std::log10(1 - share));
  }
  return worst;
}

/// The figures of both pictures with their keys, in the order of score.json.
std::vector<std::pair<std::string, std::optional<double>>> picture_figures(const Score& score) {
  const PictureScore &p = score.portrait, &i = score.input;
  return {{"psnr_srgb_db", p.psnr_srgb_db},
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
    if (!region.sparsification.ause) notes.push_back(where + ".ause: undefined, every error is 0");
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
  json["ause"] = or_null(curves.ause);
  json["sparsification"] = {{"removed", curves.removed}, {"error_px", curves.error}, {"oracle_px", curves.oracle}};
  return json;
}

std::string figure_text(const std::optional<double>& value, int decimals) {
  return value ? fmt::format("{:.{}f}", *value, decimals) : "-";
}

}  // namespace

Image disparity_seen_from_first(const pipeline::PortraitResult& result, const Truth& truth) {
  if (!has_moved(result, truth)) return result.disparity_dp_px;
  return seen_from_first(result.disparity_dp_px, truth.motion[result.base_frame - 1],
                         std::numeric_limits<float>::quiet_NaN());
}

Score score_result(const Capture& capture, const std::string& capture_path, const pipeline::StoredResult& stored,
                   const std::string& result_path) {
  if (!capture.truth) throw InputError(printable(capture_path) + ": holds no truth to score against");
  const Truth& truth = *capture.truth;
  if (!stored.result.input.same_size(truth.photograph)) {
    throw InputError(fmt::format("{}: {} x {} pixels; the capture {} has {} x {}", printable(result_path),
                                 stored.result.input.width, stored.result.input.height, printable(capture_path),
                                 truth.photograph.width, truth.photograph.height));
  }

  const int base = stored.result.base_frame;
  if (base >= static_cast<int>(capture.frames.size())) {
    throw InputError(fmt::format("{}: /base_frame: {}; the capture {} has {} frames", printable(result_path), base,
                                 printable(capture_path), capture.frames.size()));
  }
  const pipeline::PortraitResult moved =
      has_moved(stored.result, truth) ? seen_from_first(stored.result, truth) : pipeline::PortraitResult();
  const pipeline::PortraitResult& result = has_moved(stored.result, truth) ? moved : stored.result;

  Score score;
  score.capture = capture_path;
  score.result = result_path;
  score.mode = stored.mode.empty() ? "unknown" : stored.mode;
  if (!result.disparity_dp_px.empty()) score.disparity = score_disparity(truth, result);
  score.portrait = score_picture(result.portrait, truth.photograph);
  score.input = score_picture(result.input, truth.photograph);
  score.truth_noise_db = truth_noise_db(truth, score);
  score.stages = result.stages;
  score.notes = explain_missing(score);
  return score;
}

Json to_json(const Score& score) {
  Json json = {{"format", "dualpixel-score"}, {"version", 1}, {"capture", score.capture}, {"result", score.result}};
  json["mode"] = score.mode;
  if (!score.disparity.empty()) {
    json["definitions"] = {{"confident_threshold", kConfidentThreshold},
                           {"depth_edges_jump_dp_px", kEdgeJumpDpPx},
                           {"depth_edges_reach_px", kEdgeReachPx},
                           {"person_threshold", kPersonThreshold}};
    for (const RegionScore& region : score.disparity) json["disparity"][region.region] = to_json(region);
  }
  for (const auto& [metric, value] : picture_figures(score)) json["image"][metric] = or_null(value);
  json["image"]["truth_noise_db"] = or_null(score.truth_noise_db);
  json["stages"] = Json::object();
  for (const pipeline::StageTime& stage : score.stages) {
    json["stages"][stage.name] = {{"ms", stage.ms}, {"peak_rss_mb", stage.peak_rss_mb}};
  }
  json["notes"] = score.notes;
  return json;
}

std::string to_text(const Score& score) {
  std::string text;
  const auto line = [&](const std::string& content) { text += content + "\n"; };

  if (!score.disparity.empty()) {
    line("Disparity, DP px; the last six after an affine fit or invariant to one");
    line(fmt::format("{:<12}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9} |{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}", "region", "coverage",
                     "bias", "RMSE", ">0.1", ">0.25", ">0.5", "RMSE", ">0.1", ">0.25", "AIWE(1)", "1-|rho|*", "AUSE"));
    for (const RegionScore& r : score.disparity) {
      std::string row = fmt::format("{:<12}", r.region);
      for (const auto& figure : {r.coverage, r.bias_px, r.rmse_px, r.bad[0], r.bad[1], r.bad[2]}) {
        row += fmt::format("{:>9}", figure_text(figure, 3));
      }
      row += " |";
      for (const auto& figure :
           {r.rmse_affine_px, r.bad_affine[0], r.bad_affine[1], r.aiwe1, r.one_minus_rho, r.sparsification.ause}) {
        row += fmt::format("{:>9}", figure_text(figure, 3));
      }
      line(row);
    }
    line("* Spearman's rho, ties get average ranks. RMSE after the fit is AIWE(2).\n");
  } else {
    line("Disparity: none, the result was made from the person mask alone\n");
  }

  line("Against the true photograph     PSNR sRGB  PSNR linear  SSIM sRGB  SSIM linear");
  for (const auto& [label, f] : {std::pair{"portrait", score.portrait}, {"input, not blurred", score.input}}) {
    line(fmt::format("{:<30}{:>8} dB{:>10} dB{:>11}{:>13}", label, figure_text(f.psnr_srgb_db, 2),
                     figure_text(f.psnr_linear_db, 2), figure_text(f.ssim_srgb, 4), figure_text(f.ssim_linear, 4)));
  }

  line(fmt::format("\n{:<20}{:>9}{:>18}", "Stage", "ms", "peak memory, MB"));
  double total_ms = 0;
  for (const pipeline::StageTime& stage : score.stages) {
    total_ms += stage.ms;
    line(fmt::format("{:<20}{:>9.1f}{:>18.0f}", printable(stage.name), stage.ms, stage.peak_rss_mb));
  }
  line(fmt::format("{:<20}{:>9.1f}", "total", total_ms));
  for (const std::string& note : score.notes) line("note: " + printable(note));
  return text;
}

}  // namespace dualpixel::evaluation
