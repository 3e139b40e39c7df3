#include <gtest/gtest.h>
#include <onnx/checker.h>
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "capture/files.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/temporary_folder.h"
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
  Image picture(kSize, kSize, 3, 0.3F);
  pipeline::draw_face(picture, 128, 90, 70);
  const Image input = pipeline::network_input(picture, {93, 55, 70, 70});
  const int shape[] = {1, 4, kSize, kSize};
  cv::Mat blob(4, shape, CV_32F);
  for (int c = 0; c < 4; ++c) {
    for (int i = 0; i < kSize * kSize; ++i) blob.ptr<float>(0, c)[i] = input.data[4 * static_cast<std::size_t>(i) + c];
  }
  other.setInput(blob);
  const cv::Mat drawn = other.forward();
  const Image mask = network(input);
  ASSERT_EQ(drawn.total(), mask.data.size());
  const auto [low, high] = std::minmax_element(mask.data.begin(), mask.data.end());
  EXPECT_GT(*high - *low, 0.5F);  // a mask that says nothing would agree with anything
  // 47 layers of sums of up to 864 products of about 1, rounded to 24 bits on both sides; the sigmoid takes a quarter.
  constexpr double kRounding = 2 * 47 * 864 * 0x1p-25 / 4;
  for (std::size_t i = 0; i < mask.data.size(); ++i) ASSERT_NEAR(drawn.ptr<float>()[i], mask.data[i], kRounding);
#else
  GTEST_SKIP() << "built without OpenCV (libopencv-dev), which would run the model";
#endif
}

TEST(Onnx, UnusableWeightsAreOneClearLine) {
  const TemporaryFolder folder;
  const std::string output = folder.path.string() + "/person.onnx";
  const auto run = [&](const std::string& weights) {
    const std::string command = std::string(DUALPIXEL_EXPORT_ONNX) + " --weights '" + weights + "' -o '" + output +
                                "' 2> '" + folder.path.string() + "/err'";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  write_file(folder.path.string() + "/bad", "nothing");
  EXPECT_EQ(run(folder.path.string() + "/bad"), 2);
  EXPECT_NE(read_file(folder.path.string() + "/err").find("/bad: "), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(output));
  EXPECT_EQ(run(DUALPIXEL_SOURCE_DIR "/pipeline/segmentation/weights/person.safetensors"), 0);
  EXPECT_EQ(read_file(output), onnx_model(pipeline::built_in_weights()));
}

}  // namespace
}  // namespace dualpixel::tools
