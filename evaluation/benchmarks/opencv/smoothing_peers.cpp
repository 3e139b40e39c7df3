#include "evaluation/benchmarks/opencv/smoothing_peers.h"

#ifdef DUALPIXEL_XIMGPROC
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#endif

namespace dualpixel::evaluation {
#ifdef DUALPIXEL_XIMGPROC
namespace {

cv::Mat wrapped(const Image& image) {
  return {image.height, image.width, CV_32FC(image.channels), const_cast<float*>(image.data.data())};
}

cv::Mat guide_of(const SmoothingInput& input) {
  cv::Mat bytes, bgr;
  wrapped(input.guide.small).convertTo(bytes, CV_8UC3);
  cv::cvtColor(bytes, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

/// Normalized convolution for a filter that takes no confidence: filter(c t) / filter(c). Clamped to the range of the
/// targets, since filters that overshoot can bring the confidence close to 0.
template <typename Filter>
Image normalized(const SmoothingInput& input, const Filter& filter) {
  Image out(input.guide.small.width, input.guide.small.height);
  const cv::Mat guide = guide_of(input), confidence = wrapped(input.map.confidence) + 1e-4f;
  const auto [least, most] = std::minmax_element(input.map.value.data.begin(), input.map.value.data.end());
  cv::Mat both, filtered;
  cv::merge(std::vector<cv::Mat>{wrapped(input.map.value).mul(confidence), confidence, confidence}, both);
  filter(guide, both, filtered);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const cv::Vec3f sums = filtered.at<cv::Vec3f>(y, x);
      out.at(x, y) = std::clamp(sums[0] / std::max(sums[1], 1e-6f), *least, *most);
    }
  }
  return out;
}
}  // namespace

std::optional<Image> solve_with_opencv(const SmoothingInput& input, const pipeline::BilateralGridOptions& cells) {
  constexpr int kIterations = 25;  // its default
  Image out(input.guide.small.width, input.guide.small.height);
  cv::Mat solved;
  std::cout.setstate(std::ios::failbit);  // the library prints its progress there
  cv::ximgproc::fastBilateralSolverFilter(guide_of(input), wrapped(input.map.value), wrapped(input.map.confidence),
                                          solved, cells.cell_px, cells.cell_luma, cells.cell_chroma, 128, kIterations);
  std::cout.clear();
  solved.copyTo(wrapped(out));
  return out;
}

std::vector<SmoothingMethod> opencv_smoothing_methods() {
  std::vector<SmoothingMethod> all;
  for (const int divisor : {2, 4, 8}) {
    all.push_back({"OpenCV's solver", fmt::format("1/{}", divisor), divisor,
                   [](const SmoothingInput& input) { return *solve_with_opencv(input, {}); }});
  }
  for (const int radius : {4, 8, 16}) {
    all.push_back({"OpenCV guided filter", fmt::format("radius {}", radius), 4, [=](const SmoothingInput& input) {
                     return normalized(input, [&](const cv::Mat& guide, const cv::Mat& from, cv::Mat& to) {
                       cv::ximgproc::guidedFilter(guide, from, to, radius, 25);
                     });
                   }});
  }
  for (const double lambda : {100.0, 1000.0, 10000.0}) {
    all.push_back(
        {"OpenCV fast global smoother", fmt::format("lambda {:g}", lambda), 4, [=](const SmoothingInput& input) {
           return normalized(input, [&](const cv::Mat& guide, const cv::Mat& from, cv::Mat& to) {
             cv::ximgproc::fastGlobalSmootherFilter(guide, from, to, lambda, 8);
           });
         }});
  }
  for (const double sigma : {16.0, 32.0, 64.0}) {
    all.push_back({"OpenCV domain transform", fmt::format("sigma {:g} px", sigma), 4, [=](const SmoothingInput& input) {
                     return normalized(input, [&](const cv::Mat& guide, const cv::Mat& from, cv::Mat& to) {
                       cv::ximgproc::dtFilter(guide, from, to, sigma, 20);
                     });
                   }});
  }
  return all;
}
#else
std::optional<Image> solve_with_opencv(const SmoothingInput&, const pipeline::BilateralGridOptions&) { return {}; }
std::vector<SmoothingMethod> opencv_smoothing_methods() { return {}; }
#endif

}  // namespace dualpixel::evaluation
