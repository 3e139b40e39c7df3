#include "evaluation/failures/failure_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <utility>

#include "capture/image/display.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "evaluation/metrics/statistics.h"
#include "evaluation/report/report_images.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kBorder = 16;  // 2 tiles
constexpr int kBlock = 16;   // windows reach over two tiles: errors further apart are independent
constexpr double kBrokenShare = 0.1;
constexpr float kTrusted = 0.5f;
constexpr double kOneSigma = 0.6827;

struct Block {
  int pixels = 0, wrong = 0;
};

/// Of all pixels that count, of any number of pictures.
struct Tally {
  /// Error: infinite where nothing was found. Sigma: NaN where none was given. Empty where the method has none.
  std::vector<float> error, sigma, confidence;
  std::vector<Block> blocks;
};

void add(const ViewSample& views, const pipeline::PixelDisparity& found, Tally& tally) {
  const Image& truth = views.truth_dp_px;
  for (int top = kBorder; top + kBlock <= truth.height - kBorder; top += kBlock) {
    for (int left = kBorder; left + kBlock <= truth.width - kBorder; left += kBlock) {
      Block& block = tally.blocks.emplace_back();
      for (int i = 0; i < kBlock * kBlock; ++i) {
        const int x = left + i % kBlock, y = top + i / kBlock;
        if (!std::isfinite(truth.at(x, y))) continue;
        const float error = std::abs(found.disparity_dp_px.at(x, y) - truth.at(x, y));
        tally.error.push_back(std::isfinite(error) ? error : INFINITY);
        if (!found.sigma_dp_px.empty()) tally.sigma.push_back(found.sigma_dp_px.at(x, y));
        if (!found.confidence.empty()) {
          const float confidence = found.confidence.at(x, y);
          tally.confidence.push_back(std::isfinite(confidence) ? confidence : 0);
        }
        ++block.pixels;
        block.wrong += tally.error.back() > kWrongDpPx;
      }
    }
  }
}

float quantile(std::vector<float> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

FailureFigures figures_of(const Tally& tally) {
  const std::size_t count = tally.error.size();
  const auto share = [&](const auto& holds) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i) n += holds(i);
    return static_cast<double>(n) / static_cast<double>(count);
  };
  const auto is_wrong = [&](std::size_t i) { return tally.error[i] > kWrongDpPx; };
  const bool has_sigma = !tally.sigma.empty(), has_confidence = !tally.confidence.empty();
  const auto is_trusted = [&](std::size_t i) {
    return has_sigma ? tally.sigma[i] < kConfidentDpPx : tally.confidence[i] >= kTrusted;
  };
  FailureFigures figures;
  if (count == 0) return figures;
  figures.wrong = share(is_wrong);
  double finite = 0, squares = 0;
  for (const float error : tally.error) {
    if (!std::isfinite(error)) continue;
    finite += 1, squares += static_cast<double>(error) * error;
  }
  if (finite > 0) figures.rmse_dp_px = std::sqrt(squares / finite);
  if (has_confidence) {
    double sum = 0;
    for (const float confidence : tally.confidence) sum += confidence;
    figures.confidence = sum / static_cast<double>(count);
  }
  if (has_sigma || has_confidence) {
    figures.trusted = share(is_trusted);
    figures.overconfident = share([&](std::size_t i) { return is_wrong(i) && is_trusted(i); });
  }
  std::vector<float> sigma;  // NaN: of no disparity, as a method of the user's own may write it
  std::copy_if(tally.sigma.begin(), tally.sigma.end(), std::back_inserter(sigma),
               [](float s) { return !std::isnan(s); });
  if (sigma.empty()) return figures;
  const auto within = [&](float sigmas) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i) n += tally.error[i] < sigmas * tally.sigma[i];
    return static_cast<double>(n) / static_cast<double>(sigma.size());
  };
  figures.within_one_sigma = within(1);
  figures.within_two_sigma = within(2);
  figures.sigma_dp_px = median(std::move(sigma));
  figures.error_68_dp_px = quantile(tally.error, kOneSigma);
  return figures;
}

/// The first of the steps that is broken, each block counted as often as `weights` say.
std::size_t first_broken(const std::vector<Tally>& steps, const std::vector<int>& weights) {
  for (std::size_t step = 0; step < steps.size(); ++step) {
    double pixels = 0, wrong = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      pixels += weights[i] * steps[step].blocks[i].pixels;
      wrong += weights[i] * steps[step].blocks[i].wrong;
    }
    if (wrong > kBrokenShare * pixels) return step;
  }
  return steps.size();
}

/// Bootstrap: blocks are drawn anew, the same at all steps, since these show one texture.
BreakingPoint breaking_point(const std::vector<Tally>& steps) {
  constexpr int kRedraws = 1000;
  const std::size_t blocks = steps.front().blocks.size();
  BreakingPoint point;
  point.step = first_broken(steps, std::vector<int>(blocks, 1));
  std::mt19937 random(1);
  std::vector<std::size_t> redrawn;
  for (int i = 0; i < kRedraws; ++i) {
    std::vector<int> weights(blocks);
    for (std::size_t b = 0; b < blocks; ++b) ++weights[random() % blocks];
    redrawn.push_back(first_broken(steps, weights));
  }
  std::sort(redrawn.begin(), redrawn.end());
  point.low = redrawn[kRedraws / 40], point.high = redrawn[kRedraws - 1 - kRedraws / 40];
  return point;
}

/// Signed disparity in color.
std::string map_uri(const Image& map, float limit) { return jpeg_data_uri(diverging_colors(map, limit)); }

std::string view_uri(const Image& view, float white) {
  Image rgb(view.width, view.height, 3);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = view.data[i / 3] / white;
  return jpeg_data_uri(encode_for_display(rgb));
}

/// The largest disparity of any step, at least 1.
float limit_of(const std::vector<Image>& truths) {
  float limit = 1;
  for (const Image& truth : truths) {
    for (const float value : truth.data) {
      if (std::isfinite(value)) limit = std::max(limit, std::abs(value));
    }
  }
  return limit;
}

}  // namespace

FailureFigures measure_failure(const ViewSample& views, const DisparityMethod& method) {
  Tally tally;
  add(views, method.run(views.left, views.right, views.sensor).found, tally);
  return figures_of(tally);
}

FailureSweep measure_row(const FailureRow& row, const std::vector<DisparityMethod>& methods, unsigned draws,
                         const std::function<void(double)>& progress) {
  FailureSweep sweep{row.name, row.title, row.sweep, row.key, row.note, row.log};
  for (const DisparityMethod& method : methods) sweep.methods.push_back(method.name);
  std::vector<std::vector<Tally>> tallies(methods.size(), std::vector<Tally>(row.values.size()));
  std::vector<Image> truths;
  std::vector<std::vector<Image>> found(row.values.size());
  for (std::size_t step = 0; step < row.values.size(); ++step) {
    FailureStep& of_step = sweep.steps.emplace_back();
    of_step.value = row.values[step];
    for (unsigned draw = 0; draw < draws; ++draw) {
      ViewSample views = row.make(of_step.value, draw);
      if (draw == 0) of_step.view_uri = view_uri(views.left, views.sensor.white);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        pipeline::PixelDisparity disparity = methods[m].run(views.left, views.right, views.sensor).found;
        add(views, disparity, tallies[m][step]);
        if (draw == 0) found[step].push_back(std::move(disparity.disparity_dp_px));
      }
      if (draw == 0) truths.push_back(std::move(views.truth_dp_px));
      if (progress) {
        progress((static_cast<double>(step) + (draw + 1.0) / draws) / static_cast<double>(row.values.size()));
      }
    }
  }
  const float limit = limit_of(truths);
  sweep.limit_dp_px = limit;
  for (std::size_t step = 0; step < sweep.steps.size(); ++step) {
    FailureStep& of_step = sweep.steps[step];
    of_step.truth_uri = map_uri(truths[step], limit);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      of_step.methods.push_back(figures_of(tallies[m][step]));
      of_step.found_uris.push_back(map_uri(found[step][m], limit));
    }
  }
  for (const std::vector<Tally>& steps : tallies) sweep.breaks.push_back(breaking_point(steps));
  return sweep;
}

std::string FailureSweep::value_at(std::size_t step) const {
  return step < steps.size() ? fmt::format("{:g}", steps[step].value) : "never";
}

std::optional<double> FailureSweep::overconfident(std::size_t method) const {
  std::optional<double> most;
  for (const FailureStep& step : steps) {
    if (const auto& share = step.methods[method].overconfident) most = std::max(most.value_or(0), *share);
  }
  return most;
}

}  // namespace dualpixel::evaluation
