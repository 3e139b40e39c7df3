#include "evaluation/benchmarks/opencv/stereo_peers.h"

#ifdef DUALPIXEL_OPENCV
#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "pipeline/disparity/upsample.h"
#endif

namespace dualpixel::evaluation {
#ifdef DUALPIXEL_OPENCV
namespace {

constexpr int kBlock = 9, kRange = 16;

cv::Mat eight_bits(const Image& view, double gain) {
  cv::Mat out(view.height, view.width, CV_8U);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) out.at<uchar>(y, x) = cv::saturate_cast<uchar>(gain * view.at(x, y));
  }
  return out;
}

/// Both matchers take 8-bit pictures, here exposed to their brightest 0.1 %, and give left(x) = right(x - disparity).
pipeline::PixelDisparity match_opencv(const StereoPair& pair, cv::StereoMatcher& matcher) {
  std::vector<float> sorted = pair.left.data;
  const auto rank = sorted.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), rank, sorted.end());
  const double gain = 255 / std::max(*rank, 1e-6f);
  cv::Mat sixteenths;
  matcher.compute(eight_bits(pair.left, gain), eight_bits(pair.right, gain), sixteenths);
  pipeline::PixelDisparity found{Image(pair.left.width, pair.left.height), {}};
  for (int y = 0; y < found.disparity_dp_px.height; ++y) {
    for (int x = 0; x < found.disparity_dp_px.width; ++x) {
      const short value = sixteenths.at<short>(y, x);
      found.disparity_dp_px.at(x, y) =
          value < -16 * kRange ? std::numeric_limits<float>::quiet_NaN() : -static_cast<float>(value) / 16;
    }
  }
  return found;
}

}  // namespace

std::vector<StereoMethod> opencv_stereo_methods() {
  return {{"OpenCV StereoBM",
           [](const StereoPair& pair) {
             const auto matcher = cv::StereoBM::create(2 * kRange, kBlock);
             matcher->setMinDisparity(-kRange);
             return match_opencv(pair, *matcher);
           }},
          {"OpenCV StereoSGBM", [](const StereoPair& pair) {
             // smoothness as OpenCV's manual suggests for one channel: 8 and 32 times the block's area
             const auto matcher =
                 cv::StereoSGBM::create(-kRange, 2 * kRange, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock);
             return match_opencv(pair, *matcher);
           }}};
}
#else
std::vector<StereoMethod> opencv_stereo_methods() { return {}; }
#endif

}  // namespace dualpixel::evaluation
