#include <gtest/gtest.h>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>

#include "pipeline/segmentation/network.h"
#include "simulator/sampling/hash.h"
#include "tools/export_onnx/onnx_model.h"

#ifdef DUALPIXEL_OPENCV_DNN
#include <opencv2/dnn.hpp>
#endif

namespace dualpixel::tools {
namespace {

TEST(Onnx, IsAModelByTheFormatsOwnChecker) {
  onnx::ModelProto model;
  ASSERT_TRUE(model.ParseFromString(onnx_model(pipeline::built_in_weights())));
  EXPECT_NO_THROW(onnx::checker::check_model(model));
  model.mutable_graph()->mutable_node(3)->set_op_type("Nothing");
  EXPECT_ANY_THROW(onnx::checker::check_model(model));
}

TEST(Onnx, OpenCvDrawsTheSameMask) {
#ifdef DUALPIXEL_OPENCV_DNN
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  const std::string model = onnx_model(pipeline::built_in_weights());
  cv::dnn::Net other = cv::dnn::readNetFromONNX(model.data(), model.size());
  pipeline::PersonNetwork network;
  constexpr int kSize = pipeline::kNetworkSize_px;
  Image input(kSize, kSize, 4);
  const int shape[] = {1, 4, kSize, kSize};
  cv::Mat blob(4, shape, CV_32F);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      for (int c = 0; c < 4; ++c) {
        const auto noise = static_cast<float>(simulator::hash(x / 16, y / 16, c) % 1000) / 1000 - 0.5F;
        const auto face = static_cast<float>(std::exp(-(std::pow(x - 128, 2) + std::pow(y - 90, 2)) / 882));
        input.at(x, y, c) = c < 3 ? noise : face;
        blob.ptr<float>(0, c)[y * kSize + x] = input.at(x, y, c);
      }
    }
  }
  other.setInput(blob);
  const cv::Mat drawn = other.forward();
  const Image mask = network(input);
  ASSERT_EQ(drawn.total(), mask.data.size());
  const auto [low, high] = std::minmax_element(mask.data.begin(), mask.data.end());
  EXPECT_GT(*high - *low, 0.5F);
  for (std::size_t i = 0; i < mask.data.size(); ++i) ASSERT_NEAR(drawn.ptr<float>()[i], mask.data[i], 1e-3);
#else
  GTEST_SKIP() << "built without OpenCV (libopencv-dev), which would run the model";
#endif
}

}  // namespace
}  // namespace dualpixel::tools
