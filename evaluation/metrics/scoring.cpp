#include "evaluation/metrics/scoring.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "capture/error.h"
#include "evaluation/metrics/image_metrics.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

/// What `image`, which shows a later frame, shows of the points that the first frame sees: bilinear at pixel + motion,
/// outside of the picture its border, or `outside` where that is given.
Image seen_from_first(const Image& image, const Image& motion, std::optional<float> outside = {}) {
  if (image.empty()) return image;
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

struct Threshold {
  const char* key;
  double px;
};
constexpr Threshold kBadPixel[] = {{"bad_0p1", 0.1}, {"bad_0p25", 0.25}, {"bad_0p5", 0.5}};

/// Figures of one region; all null where it holds no pixel.
Json score_region(const Samples& samples, std::size_t valid_pixels) {
  const std::vector<float>&estimate = samples.estimate, &truth = samples.truth, &confidence = samples.confidence;
  const bool any = !estimate.empty();
  Json figures = {{"pixels", estimate.size()},
                  {"coverage", valid_pixels ? Json(static_cast<double>(estimate.size()) / valid_pixels) : Json()}};
  const auto add = [&](const std::string& key, const auto& figure) {
    if (any) {
      figures[key] = figure();
    } else {
      figures[key] = nullptr;
    }
  };

  add("bias_px", [&] { return bias(estimate, truth); });
  add("rmse_px", [&] { return rmse(estimate, truth); });
  for (const Threshold& bad : kBadPixel) add(bad.key, [&] { return bad_pixel_rate(estimate, truth, bad.px); });

  const AffineFit fit = any ? fit_affine(estimate, truth) : AffineFit{};
  add("affine_scale", [&] { return fit.scale; });
  add("affine_offset_px", [&] { return fit.offset; });
  add("rmse_affine_px", [&] { return rmse(estimate, truth, fit); });
  for (const Threshold& bad : kBadPixel) {
    add(std::string(bad.key) + "_affine", [&] { return bad_pixel_rate(estimate, truth, bad.px, fit); });
  }
  add("aiwe1", [&] { return aiwe1(estimate, truth); });
  figures["aiwe2"] = figures["rmse_affine_px"];
  add("one_minus_rho_average_ranks", [&] {
    const std::optional<double> rho = spearman(estimate, truth);
    return rho ? Json(1 - std::abs(*rho)) : Json(nullptr);
  });

  std::vector<float> error(estimate.size());
  for (std::size_t i = 0; i < error.size(); ++i) {
    error[i] = static_cast<float>(std::abs(fit.scale * estimate[i] + fit.offset - truth[i]));
  }
  const Sparsification curves = sparsification(error, confidence);
  figures["ause"] = or_null(curves.ause);
  figures["sparsification"] = {{"removed", curves.removed}, {"error_px", curves.error}, {"oracle_px", curves.oracle}};
  return figures;
}

Json score_disparity(const Truth& truth, const pipeline::PortraitResult& result) {
  const Mask edges = depth_edges(truth.disparity_dp_px, kEdgeJumpDpPx, kEdgeReachPx);
  std::size_t valid_pixels = 0;
  for (const float valid : truth.valid.data) valid_pixels += valid == 1;

  Json everything, confident, at_edges, person;
  const auto score = [&](const auto& inside) { return score_region(gather(truth, result, inside), valid_pixels); };
  tbb::parallel_invoke(
      [&] { everything = score([](std::size_t) { return true; }); },
      [&] { confident = score([&](std::size_t i) { return result.confidence.data[i] >= kConfidentThreshold; }); },
      [&] { at_edges = score([&](std::size_t i) { return edges.data[i] == 1; }); },
      [&] { person = score([&](std::size_t i) { return truth.person_mask.data[i] > kPersonThreshold; }); });
  return {{"everything", everything}, {"confident", confident}, {"depth_edges", at_edges}, {"person", person}};
}

Json score_images(const Truth& truth, const pipeline::PortraitResult& result) {
  Json figures;
  const auto compare = [&](const char* space, const auto& encode) {
    const Image photograph = encode(truth.photograph);
    const auto add = [&](const Image& linear, const char* suffix) {
      const Image image = encode(linear);
      figures[fmt::format("psnr_{}{}_db", space, suffix)] = or_null(psnr_db(image, photograph));
      figures[fmt::format("ssim_{}{}", space, suffix)] = or_null(ssim(image, photograph));
    };
    add(result.portrait, "");
    add(result.input, "_input");
  };
  compare("srgb", [](const Image& linear) { return displayed(linear); });
  compare("linear", clipped);
  figures["psnr_db"] = figures["psnr_srgb_db"];
  figures["psnr_input_db"] = figures["psnr_srgb_input_db"];
  figures["ssim"] = figures["ssim_srgb"];
  figures["ssim_input"] = figures["ssim_srgb_input"];
  return figures;
}

/// Why figures are null: a line each.
Json explain_nulls(const Json& score) {
  Json notes = Json::array();
  const Json disparity = score.value("disparity", Json::object());
  for (const auto& [region, figures] : disparity.items()) {
    const std::string where = "disparity." + region;
    if (figures["pixels"] == 0) {
      notes.push_back(where + ": no pixel is in this region with a valid truth and a finite estimate");
      continue;
    }
    if (figures["one_minus_rho_average_ranks"].is_null()) {
      notes.push_back(where + ".one_minus_rho_average_ranks: undefined, the estimate or the truth is constant");
    }
    if (figures["ause"].is_null()) notes.push_back(where + ".ause: undefined, no pixel errs");
  }
  for (const auto& [metric, value] : score["image"].items()) {
    if (!value.is_null()) continue;
    notes.push_back("image." + metric +
                    (metric.starts_with("psnr") ? ": infinite, the pictures are the same"
                                                : ": undefined, the picture is smaller than a window of 11 x 11"));
  }
  return notes;
}

std::string figure_text(const Json& value, int decimals) {
  return value.is_null() ? "-" : fmt::format("{:.{}f}", value.get<double>(), decimals);
}

}  // namespace

Image disparity_seen_from_first(const pipeline::PortraitResult& result, const Truth& truth) {
  if (!has_moved(result, truth)) return result.disparity_dp_px;
  return seen_from_first(result.disparity_dp_px, truth.motion[result.base_frame - 1], NAN);
}

Json score_result(const Capture& capture, const std::string& capture_path, const pipeline::StoredResult& stored,
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

  Json score = {{"format", "dualpixel-score"}, {"version", 1}, {"capture", capture_path}, {"result", result_path}};
  score["mode"] = stored.mode.empty() ? "unknown" : stored.mode;
  if (!result.disparity_dp_px.empty()) {
    score["definitions"] = {{"confident_threshold", kConfidentThreshold},
                            {"depth_edges_jump_dp_px", kEdgeJumpDpPx},
                            {"depth_edges_reach_px", kEdgeReachPx},
                            {"person_threshold", kPersonThreshold}};
    score["disparity"] = score_disparity(truth, result);
  }
  score["image"] = score_images(truth, result);
  score["stages"] = Json::object();
  for (const pipeline::StageTime& stage : result.stages) {
    score["stages"][stage.name] = {{"ms", stage.ms}, {"peak_rss_mb", stage.peak_rss_mb}};
  }
  score["notes"] = explain_nulls(score);
  return score;
}

std::string score_table(const Json& score) {
  std::string text;
  const auto line = [&](const std::string& content) { text += content + "\n"; };

  if (score.contains("disparity")) {
    line("Disparity, DP px; the last six after an affine fit or invariant to one");
    line(fmt::format("{:<12}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9} |{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}", "region", "coverage",
                     "bias", "RMSE", ">0.1", ">0.25", ">0.5", "RMSE", ">0.1", ">0.25", "AIWE(1)", "1-|rho|*", "AUSE"));
    for (const auto& [region, f] : score["disparity"].items()) {
      std::string row = fmt::format("{:<12}", region);
      for (const char* key : {"coverage", "bias_px", "rmse_px", "bad_0p1", "bad_0p25", "bad_0p5"}) {
        row += fmt::format("{:>9}", figure_text(f[key], 3));
      }
      row += " |";
      for (const char* key :
           {"rmse_affine_px", "bad_0p1_affine", "bad_0p25_affine", "aiwe1", "one_minus_rho_average_ranks", "ause"}) {
        row += fmt::format("{:>9}", figure_text(f[key], 3));
      }
      line(row);
    }
    line("* Spearman's rho, ties get average ranks. RMSE after the fit is AIWE(2).\n");
  } else {
    line("Disparity: none, the result was made by the person mask alone\n");
  }

  line("Against the true photograph     PSNR sRGB  PSNR linear  SSIM sRGB  SSIM linear");
  const auto image_line = [&](const char* label, const std::string& suffix) {
    const Json& f = score["image"];
    line(fmt::format("{:<30}{:>8} dB{:>10} dB{:>11}{:>13}", label, figure_text(f["psnr_srgb" + suffix + "_db"], 2),
                     figure_text(f["psnr_linear" + suffix + "_db"], 2), figure_text(f["ssim_srgb" + suffix], 4),
                     figure_text(f["ssim_linear" + suffix], 4)));
  };
  image_line("portrait", "");
  image_line("input, not blurred", "_input");

  line(fmt::format("\n{:<20}{:>9}{:>18}", "Stage", "ms", "peak memory, MB"));
  double total_ms = 0;
  for (const auto& [name, stage] : score["stages"].items()) {
    total_ms += stage["ms"].get<double>();
    line(fmt::format("{:<20}{:>9.1f}{:>18.0f}", printable(name), stage["ms"].get<double>(),
                     stage["peak_rss_mb"].get<double>()));
  }
  line(fmt::format("{:<20}{:>9.1f}", "total", total_ms));
  for (const Json& note : score["notes"]) line("note: " + printable(note.get<std::string>()));
  return text;
}

}  // namespace dualpixel::evaluation
