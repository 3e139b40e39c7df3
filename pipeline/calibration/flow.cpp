#include "pipeline/calibration/flow.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "capture/error.h"
#include "capture/image/resample.h"
#include "capture/image/rows.h"
#include "pipeline/disparity/paper/normalize.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kSmallestLevel = 16;  ///< blocks: no level has a shorter side, unless the views have
constexpr float kRelaxation = 1.8f;
constexpr int kGainDegree = 8;          ///< of the polynomial over the field that evens out the views' shading, at most
constexpr float kLeastTexture = 0.02f;  ///< variance of a normalized view; less is a view without texture
constexpr int kGainBlocks = 8;          ///< blocks a side whose mean is one equation of its fit

constexpr int kQuinticTaps = 6;

/// Weights of samples -2 ... 3 at a position t from sample 0 towards sample 1: the polynomial through all six. A cubic
/// through four would read shifts 1 % too large where the texture is as fine as a few blocks.
std::array<float, kQuinticTaps> quintic(float t) {
  std::array<float, kQuinticTaps> weights{};
  constexpr float kDenominators[kQuinticTaps] = {-120, 24, -12, 12, -24, 120};
  for (int k = 0; k < kQuinticTaps; ++k) {
    float product = 1;
    for (int j = 0; j < kQuinticTaps; ++j) product *= j == k ? 1 : t - static_cast<float>(j - 2);
    weights[k] = product / kDenominators[k];
  }
  return weights;
}

struct Matched {
  float difference, gradient;
};

/// right(x + d) - left(x) and how fast it changes with d; none where x + d lies outside of the third block from
/// either border. Half a block is left for d: where views match it is about 0, and its sign must not decide.
bool match_at(const float* left, const float* right, int width, int x, float d, Matched& matched) {
  const float at = static_cast<float>(x) + d;
  if (width < kQuinticTaps || x < 1 || x + 1 >= width) return false;
  if (!(at >= 1.5f && at < static_cast<float>(width) - 2.5f)) return false;
  const int i = std::clamp(static_cast<int>(at), 2, width - 4);
  const std::array<float, kQuinticTaps> weights = quintic(at - static_cast<float>(i));
  float moved = 0;
  for (int k = 0; k < kQuinticTaps; ++k) moved += weights[k] * right[i - 2 + k];
  // the mean of both views' slopes: neither is the reference, so neither's blur counts twice
  matched = {moved - left[x], 0.5f * (right[i + 1] - right[i] + 0.5f * (left[x + 1] - left[x - 1]))};
  return true;
}

/// Successive over-relaxation of (curvature - lambda Laplace) d = wanted, in checkerboard order, so
/// that rows can be computed in parallel.
void relax(const Image& curvature, const Image& wanted, float lambda, int sweeps, Image& d) {
  const int width = d.width, height = d.height;
  for (int sweep = 0; sweep < 2 * sweeps; ++sweep) {
    for_rows(height, [&](int y) {
      float* row = d.row(y);
      const float* above = y > 0 ? d.row(y - 1) : nullptr;
      const float* below = y + 1 < height ? d.row(y + 1) : nullptr;
      const float *own = curvature.row(y), *target = wanted.row(y);
      for (int x = (y + sweep) & 1; x < width; x += 2) {
        float neighbors = 0, count = 0;
        if (x > 0) neighbors += row[x - 1], ++count;
        if (x + 1 < width) neighbors += row[x + 1], ++count;
        if (above) neighbors += above[x], ++count;
        if (below) neighbors += below[x], ++count;
        row[x] += kRelaxation * ((target[x] + lambda * neighbors) / (own[x] + lambda * count) - row[x]);
      }
    });
  }
}

/// One linearization and its solution.
void step(const Image& left, const Image& right, const FlowOptions& options, Image& d) {
  Image curvature(d.width, d.height), wanted(d.width, d.height);
  for_rows(d.height, [&](int y) {
    Matched m{};
    for (int x = 0; x < d.width; ++x) {
      if (!match_at(left.row(y), right.row(y), d.width, x, d.at(x, y), m)) continue;
      const float weight =
          m.gradient / std::sqrt(m.difference * m.difference + options.charbonnier * options.charbonnier);
      curvature.at(x, y) = weight * m.gradient;
      wanted.at(x, y) = weight * (m.gradient * d.at(x, y) - m.difference);
    }
  });
  double sum = 0;
  for (const float value : curvature.data) sum += value;
  const auto mean = static_cast<float>(sum / static_cast<double>(curvature.data.size()));
  if (!(mean > 0)) return;
  relax(curvature, wanted, options.smooth_blocks * options.smooth_blocks * mean, options.sweeps, d);
}

/// In blocks; both views normalized.
Image flow_of(const Image& left, const Image& right, const FlowOptions& options) {
  std::vector<Image> lefts = {left}, rights = {right};
  while (std::min(lefts.back().width, lefts.back().height) >= 2 * kSmallestLevel) {
    const int width = lefts.back().width / 2, height = lefts.back().height / 2;
    lefts.push_back(resize_area(lefts.back(), width, height));
    rights.push_back(resize_area(rights.back(), width, height));
  }
  Image d(lefts.back().width, lefts.back().height);
  for (std::size_t level = lefts.size(); level-- > 0;) {
    const int width = lefts[level].width, height = lefts[level].height;
    if (d.width != width) {
      const float scale = static_cast<float>(width) / static_cast<float>(d.width);
      d = resize_bilinear(d, width, height);
      for (float& value : d.data) value *= scale;
    }
    for (int warp = 0; warp < options.warps; ++warp) step(lefts[level], rights[level], options, d);
  }
  return d;
}

/// view(x + d(x)); beyond the border the outermost pixels are repeated.
Image moved(const Image& view, const Image& d) {
  Image out(view.width, view.height);
  for_rows(view.height, [&](int y) {
    const float* in = view.row(y);
    for (int x = 0; x < view.width; ++x) {
      const float at = std::clamp(static_cast<float>(x) + d.at(x, y), 0.0f, static_cast<float>(view.width - 1));
      const int i = static_cast<int>(at);
      const std::array<float, kQuinticTaps> weights = quintic(at - static_cast<float>(i));
      float sum = 0;
      for (int k = 0; k < kQuinticTaps; ++k) sum += weights[k] * in[std::clamp(i - 2 + k, 0, view.width - 1)];
      out.at(x, y) = sum;
    }
  });
  return out;
}

/// Powers x^i y^j, i + j <= degree, of a position in half widths and half heights from the middle.
Eigen::RowVectorXd gain_terms(double x, double y, int degree) {
  Eigen::RowVectorXd terms((degree + 1) * (degree + 2) / 2);
  int k = 0;
  double power_x = 1;
  for (int i = 0; i <= degree; ++i, power_x *= x) {
    double power = power_x;
    for (int j = 0; i + j <= degree; ++j, power *= y) terms[k++] = power;
  }
  return terms;
}

/// Scales `view`, which shows what `reference` shows, to the reference's light by a smooth fit of the ratio of their
/// pixels. Where both show the same, that ratio holds shading but no texture. The ratio of local means does hold
/// texture, because bright texture weighs its part of the window more.
void match_light(const Image& reference, Image& view) {
  Image ratio(view.width, view.height);
  for (std::size_t i = 0; i < ratio.data.size(); ++i) {
    const float value = reference.data[i] / view.data[i];
    ratio.data[i] = value > 0.1f && value < 10 ? value : 1.0f;
  }
  ratio =
      resize_area(ratio, (view.width + kGainBlocks - 1) / kGainBlocks, (view.height + kGainBlocks - 1) / kGainBlocks);
  const auto position = [](int i, int count) { return 2 * (i + 0.5) / count - 1; };
  // With as many terms along an axis as there are means, the polynomial would follow all of their noise and swing
  // between them: of 8 means, degree 8 made .02 px of one DN in one of 1600 pixels.
  const int degree = std::min(kGainDegree, std::min(ratio.width, ratio.height) / 2);
  const auto rows = static_cast<Eigen::Index>(ratio.data.size());
  Eigen::MatrixXd terms(rows, gain_terms(0, 0, degree).size());
  Eigen::VectorXd values(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const int x = static_cast<int>(i) % ratio.width, y = static_cast<int>(i) / ratio.width;
    terms.row(i) = gain_terms(position(x, ratio.width), position(y, ratio.height), degree);
    values[i] = ratio.at(x, y);
  }
  const Eigen::VectorXd gain = terms.colPivHouseholderQr().solve(values);
  for_rows(view.height, [&](int y) {
    // this row's polynomial in x
    std::array<double, kGainDegree + 1> row{};
    const double at_y = position(y, view.height);
    for (int i = 0, k = 0; i <= degree; ++i) {
      double power = 1;
      for (int j = 0; i + j <= degree; ++j, power *= at_y) row[i] += gain[k++] * power;
    }
    for (int x = 0; x < view.width; ++x) {
      const double at_x = position(x, view.width);
      double value = 0;
      for (int i = degree; i >= 0; --i) value = value * at_x + row[i];
      view.at(x, y) *= static_cast<float>(value);
    }
  });
}

Image mismatch_of(const Image& left, const Image& right, const Image& d) {
  // where there is texture, normalized views have a variance of 1
  Image squares(d.width, d.height);
  for (std::size_t i = 0; i < left.data.size(); ++i) squares.data[i] = left.data[i] * left.data[i];
  const Image texture =
      resize_area(squares, (d.width + kGainBlocks - 1) / kGainBlocks, (d.height + kGainBlocks - 1) / kGainBlocks);
  for_rows(d.height, [&](int y) {
    Matched m{};
    for (int x = 0; x < d.width; ++x) {
      const bool seen = texture.at(x * texture.width / d.width, y * texture.height / d.height) > kLeastTexture &&
                        match_at(left.row(y), right.row(y), d.width, x, d.at(x, y), m);
      squares.at(x, y) = seen ? std::min(m.difference * m.difference, 2.0f) : 2.0f;
    }
  });
  return squares;
}

void require_for_flow(bool holds, const char* what) {
  if (!holds) throw InputError(std::string("calibration: ") + what);
}

}  // namespace

Flow match_target(const Image& left, const Image& right, const FlowOptions& options) {
  require_for_flow(!left.empty() && left.same_size(right), "left and right view must be of one size");
  require_for_flow(left.channels == 1 && right.channels == 1, "views must have one channel");
  require_for_flow(options.block_width_px > 0 && options.block_height_px > 0 && options.warps > 0 &&
                       options.refinements > 0 && options.sweeps > 0 && options.charbonnier > 0 &&
                       options.smooth_blocks > 0 && options.window_blocks > 0,
                   "flow options must be positive");
  const int width = (left.width + options.block_width_px - 1) / options.block_width_px;
  const int height = (left.height + options.block_height_px - 1) / options.block_height_px;
  const Image blocks = resize_area(left, width, height);
  const NormalizeOptions window{options.window_blocks};
  const Image right_blocks = resize_area(right, width, height);
  const Image normal_left = normalize_locally(blocks, window);
  Image d = flow_of(normal_left, normalize_locally(right_blocks, window), options), rest, moved_right;
  for (int pass = 0; pass < options.refinements; ++pass) {
    moved_right = moved(right_blocks, d);
    match_light(blocks, moved_right);
    moved_right = normalize_locally(moved_right, window);
    rest = flow_of(normal_left, moved_right, options);
    for (std::size_t i = 0; i < d.data.size(); ++i) d.data[i] += rest.data[i];
  }
  Image mismatch = mismatch_of(normal_left, moved_right, rest);
  for (float& value : d.data) value *= static_cast<float>(left.width) / static_cast<float>(width);
  return {std::move(d), std::move(mismatch)};
}

}  // namespace dualpixel::pipeline
