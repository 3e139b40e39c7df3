#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "capture/error.h"
#include "pipeline/segmentation/network.h"
#include "tests/capture/temporary_folder.h"
#include "tests/training/toy_people.h"
#include "tools/train_segmentation/augment.h"
#include "tools/train_segmentation/batches.h"
#include "tools/train_segmentation/evaluate.h"
#include "tools/train_segmentation/export.h"
#include "tools/train_segmentation/train.h"

namespace dualpixel::tools {
namespace {

/// A network as training would leave it: normalisations that are not the identity.
Network trained(const NetworkShape& shape) {
  torch::manual_seed(7);
  Network network(shape);
  const torch::NoGradGuard no_gradients;
  for (const auto& item : network->named_buffers()) {
    if (item.key().find("running_mean") != std::string::npos) item.value().normal_(0, 0.3);
    if (item.key().find("running_var") != std::string::npos) item.value().uniform_(0.5, 2);
  }
  for (const auto& item : network->named_parameters()) {
    if (item.key().find("norm.weight") != std::string::npos) item.value().uniform_(0.7, 1.3);
    if (item.key().find("norm.bias") != std::string::npos) item.value().normal_(0, 0.2);
  }
  network->eval();
  return network;
}

torch::Tensor masks_of(Network& network, const torch::Tensor& input) {
  const torch::NoGradGuard no_gradients;
  network->eval();
  return network->forward(input, true).back().mask.sigmoid();
}

TEST(SlowExport, InferenceEqualsTraining) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  Network network = trained({});
  // The file holds 16-bit floats: compare with the same network rounded, its normalisation folded, and made the
  // identity.
  const std::vector<FoldedConv> layers = folded_layers(network);
  const std::string file = safetensors(layers);
  const torch::NoGradGuard no_gradients;
  const auto modules = network->named_modules();
  for (const FoldedConv& layer : layers) {
    const torch::Tensor weight = layer.weight.to(torch::kHalf).to(torch::kFloat32);
    const torch::Tensor bias = layer.bias.to(torch::kHalf).to(torch::kFloat32);
    if (const auto conv = std::dynamic_pointer_cast<ConvImpl>(modules[layer.name])) {
      conv->conv->weight.copy_(weight);
      conv->norm->weight.fill_(1);
      conv->norm->bias.copy_(bias);
      conv->norm->running_mean.zero_();
      conv->norm->running_var.fill_(1 - conv->norm->options.eps());
    } else {
      const auto plain = std::dynamic_pointer_cast<torch::nn::Conv2dImpl>(modules[layer.name]);
      ASSERT_TRUE(plain) << layer.name;
      plain->weight.copy_(weight);
      plain->bias.copy_(bias);
    }
  }
  pipeline::PersonNetwork inference(pipeline::parse_weights(file, "weights"));
  double worst = 0, low = 1, high = 0;
  for (int picture = 0; picture < 100; ++picture) {
    const torch::Tensor input = torch::rand({1, kNetworkSize_px, kNetworkSize_px, 4}) - 0.5;
    Image image(kNetworkSize_px, kNetworkSize_px, 4);
    std::copy_n(input.data_ptr<float>(), image.data.size(), image.data.begin());
    const Image mask = inference(image);
    const torch::Tensor expected = masks_of(network, input.permute({0, 3, 1, 2})).contiguous();
    const float* const values = expected.data_ptr<float>();
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      worst = std::max(worst, static_cast<double>(std::abs(mask.data[i] - values[i])));
      low = std::min(low, static_cast<double>(values[i]));
      high = std::max(high, static_cast<double>(values[i]));
    }
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(high - low, 0.2);
  RecordProperty("worst", std::to_string(worst));
}

TEST(Network, MasksAndHeatmapsAfterEachStage) {
  Network network = trained({});
  const torch::NoGradGuard no_gradients;
  const std::vector<StageOutput> outputs = network->forward(torch::zeros({2, 4, 256, 256}));
  ASSERT_EQ(outputs.size(), 3U);
  for (const StageOutput& output : outputs) {
    EXPECT_EQ(output.mask.sizes(), (std::vector<std::int64_t>{2, 1, 256, 256}));
    EXPECT_EQ(output.heatmaps.sizes(), (std::vector<std::int64_t>{2, 17, 64, 64}));
  }
  std::int64_t parameters = 0;
  for (const torch::Tensor& parameter : network->parameters()) parameters += parameter.numel();
  EXPECT_NEAR(static_cast<double>(parameters), 1.34e6, 0.01e6);
}

class ToyPeople : public testing::Test {
 protected:
  ToyPeople() { write_toy_people(folder.path.string() + "/toy", 6, 1); }
  TemporaryFolder folder;
};

TEST_F(ToyPeople, UnchangedSamplesAreTheFiles) {
  const PeopleSet set({folder.path.string() + "/toy"});
  ASSERT_EQ(set.size(), 6U);
  const PersonSample& sample = set[3];
  std::vector<float> input(256 * 256 * 4), mask(256 * 256), heatmaps(64 * 64 * 17);
  make_example(sample, {}, input.data(), mask.data(), heatmaps.data());
  for (int i = 0; i < 256 * 256; i += 37) {
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(input[4 * i + c], sample.picture[3 * i + c] / 255.0 - 0.5, 1e-6);
    ASSERT_NEAR(mask[i], sample.mask[i] / 255.0, 1e-6);
  }
  // the Gaussian's peak: between the four pixels about the face's centre
  const auto peak = std::max_element(input.begin(), input.end(), [&](const float& a, const float& b) {
    const auto is_face = [&](const float& v) { return (&v - input.data()) % 4 == 3; };
    return (is_face(a) ? a : -1) < (is_face(b) ? b : -1);
  });
  const auto at = static_cast<int>((peak - input.begin()) / 4);
  EXPECT_NEAR(at % 256 + 0.5, sample.face[0] + sample.face[2] / 2, 0.51);
  EXPECT_NEAR(at / 256 + 0.5, sample.face[1] + sample.face[3] / 2, 0.51);
  // and the nose's heatmap: within 1 at its pixel
  float highest = 0;
  int nose = 0;
  for (int i = 0; i < 64 * 64; ++i) {
    if (heatmaps[17 * i] > highest) highest = heatmaps[17 * i], nose = i;
  }
  EXPECT_NEAR(4 * (nose % 64 + 0.5), sample.keypoints[0], 2.01);
  EXPECT_NEAR(4 * (nose / 64 + 0.5), sample.keypoints[1], 2.01);
  EXPECT_GT(highest, std::exp(-0.5 / (2 * 1.5 * 1.5)) - 1e-6);  // at most half a pixel away along both axes
}

/// Of what the mask covers, and of keypoint `k`'s heatmap, in pixels of the picture.
std::array<double, 2> center_of(const std::vector<float>& map, int size, int stride, int offset) {
  double sum = 0, x = 0, y = 0;
  for (int i = 0; i < size * size; ++i) {
    const double value = map[i * stride + offset];
    sum += value;
    x += value * (i % size + 0.5);
    y += value * (i / size + 0.5);
  }
  const double scale = 256.0 / size;
  return {scale * x / sum, scale * y / sum};
}

TEST_F(ToyPeople, PictureMaskFaceAndKeypointsMoveTogether) {
  const PeopleSet set({folder.path.string() + "/toy"});
  const PersonSample& sample = set[0];
  std::vector<float> input(256 * 256 * 4), mask(256 * 256), heatmaps(64 * 64 * 17);
  for (const bool mirror : {false, true}) {
    for (const double scale : {0.45, 0.7}) {
      Augmentation a;
      a.mirror = mirror;
      a.scale = scale;
      a.rotation_rad = 0.15;
      a.shift_x_px = 9;
      a.shift_y_px = -14;
      make_example(sample, a, input.data(), mask.data(), heatmaps.data());
      const auto moved = [&](double x, double y) -> std::array<double, 2> {
        const double u = scale * (mirror ? 128 - x : x - 128), v = scale * (y - 128);
        return {128 + std::cos(0.15) * u - std::sin(0.15) * v + 9, 128 + std::sin(0.15) * u + std::cos(0.15) * v - 14};
      };
      std::vector<float> before(256 * 256);
      for (int i = 0; i < 256 * 256; ++i) before[i] = sample.mask[i] / 255.F;
      const std::array<double, 2> was = center_of(before, 256, 1, 0), is = center_of(mask, 256, 1, 0);
      const std::array<double, 2> expected = moved(was[0], was[1]);
      EXPECT_NEAR(is[0], expected[0], 0.1);
      EXPECT_NEAR(is[1], expected[1], 0.1);
      // left shoulder (5) and right (6) change places in a mirror
      for (const int k : {0, 5, 6}) {
        const int from = mirror && k > 0 ? 11 - k : k;
        const std::array<double, 2> point = moved(sample.keypoints[3 * from], sample.keypoints[3 * from + 1]);
        const std::array<double, 2> heat = center_of(heatmaps, 64, 17, k);
        EXPECT_NEAR(heat[0], point[0], 0.1);
        EXPECT_NEAR(heat[1], point[1], 0.1);
      }
      // the person's colour lies where the mask is: its mean under the mask is what it was, but for outlines
      double colour = 0, area = 0, was_colour = 0, was_area = 0;
      for (int i = 0; i < 256 * 256; ++i) {
        colour += mask[i] * (input[4 * i] + 0.5);
        area += mask[i];
        was_colour += before[i] * sample.picture[3 * i] / 255;
        was_area += before[i];
      }
      EXPECT_NEAR(colour / area, was_colour / was_area, 0.02);
      EXPECT_NEAR(area / was_area, scale * scale, 0.01);
      EXPECT_EQ(input[0], -0.5F);  // beyond the picture
    }
  }
}

TEST_F(ToyPeople, AugmentationKeepsItsRangesAndThePaddingBlack) {
  const PeopleSet set({folder.path.string() + "/toy"});
  std::vector<float> input(256 * 256 * 4), mask(256 * 256);
  double least = 2, most = 0;
  for (std::uint64_t key = 0; key < 2000; ++key) {
    const Augmentation a = draw_augmentation(key);
    least = std::min(least, a.scale);
    most = std::max(most, a.scale);
    ASSERT_LE(std::abs(a.rotation_rad), 10 * M_PI / 180);
    ASSERT_LE(std::max(std::abs(a.shift_x_px), std::abs(a.shift_y_px)), 25.6);
  }
  EXPECT_GE(least, 0.4);
  EXPECT_LE(most, 1.2);
  EXPECT_NEAR(most - least, 0.8, 0.01);
  for (std::uint64_t key = 0; key < 20; ++key) {
    Augmentation a = draw_augmentation(key);
    a.scale = 0.5;
    a.noise = 0.05;
    make_example(set[0], a, input.data(), mask.data(), nullptr);
    EXPECT_EQ(input[0], -0.5F);
    for (std::size_t i = 0; i < input.size(); ++i) {
      ASSERT_GE(input[i], i % 4 == 3 ? 0 : -0.5F);
      ASSERT_LE(input[i], i % 4 == 3 ? 1 : 0.5F);
    }
  }
}

TEST_F(ToyPeople, BatchesAreThoseOfTheSeedWhereverTheyStart) {
  const PeopleSet set({folder.path.string() + "/toy"});
  const std::vector<std::size_t> all = {0, 1, 2, 3, 4, 5};
  AugmentedBatches from_start(set, all, 3, true, 9, 0), later(set, all, 3, true, 9, 6), other(set, all, 3, true, 8, 6);
  from_start.next();
  from_start.next();
  const Batch a = from_start.next(), b = later.next(), c = other.next();
  EXPECT_TRUE(torch::equal(a.input, b.input));
  EXPECT_TRUE(torch::equal(a.mask, b.mask));
  EXPECT_TRUE(torch::equal(a.heatmaps, b.heatmaps));
  EXPECT_FALSE(torch::equal(a.input, c.input));
}

TEST_F(ToyPeople, ScoresAreTheirFormulas) {
  const PeopleSet set({folder.path.string() + "/toy"});
  // A mask of one half throughout is cut to nothing: IoU 0, and its gradient's error is the true mask's own.
  NetworkShape shape;
  shape.stages = 1;
  Network network(shape);
  const torch::NoGradGuard no_gradients;
  network->mask_heads[0]->sub_pixels->weight.zero_();
  network->mask_heads[0]->sub_pixels->bias.zero_();
  double squares = 0;
  for (const std::size_t n : {0, 1}) {
    for (int y = 0; y < 256; ++y) {
      for (int x = 0; x < 256; ++x) {
        const std::uint8_t* m = set[n].mask + 256 * y + x;
        if (x < 255) squares += std::pow((m[1] - m[0]) / 255.0, 2);
        if (y < 255) squares += std::pow((m[256] - m[0]) / 255.0, 2);
      }
    }
  }
  const MaskScore nothing = evaluate(network, set, {0, 1});
  EXPECT_EQ(nothing.iou, 0);
  EXPECT_NEAR(nothing.gradient_error, squares / (2 * 256 * 256), 1e-6);
  // A mask of 1 throughout: IoU is the person's share of the picture; nothing is wrong inside.
  network->mask_heads[0]->sub_pixels->bias.fill_(100);
  double share = 0;
  for (int i = 0; i < 256 * 256; ++i) share += set[0].mask[i] / 255.0 / (256 * 256);
  EXPECT_NEAR(evaluate(network, set, {0}).iou, share, 1e-6);
  for (const float error : inner_errors(network, set)) EXPECT_NEAR(error, 0, 1e-6);
  network->mask_heads[0]->sub_pixels->bias.fill_(-100);
  for (const float error : inner_errors(network, set)) EXPECT_NEAR(error, 1, 1e-6);
}

TEST_F(ToyPeople, DamagedSetsAreOneClearLine) {
  const std::string toy = folder.path.string() + "/toy", shard = toy + "/shard_00000";
  const auto error = [&] {
    try {
      PeopleSet set({toy});
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(error(), "");
  const std::vector<std::tuple<std::string, std::string, std::string>> cases = {
      {"/people.json", R"({"format": "dualpixel people", "version": 2, "size_px": 256, "count": 6})", "version 1"},
      {"/people.json", R"({"format": "dualpixel people", "version": 1, "size_px": 256, "count": 7})", "/count: 7"},
      {"/people.json", "[1]", "no people set"},
      {"/shard_00000/faces.npy", "", "is empty"},
      {"/shard_00000/faces.npy", "\x93NUMPY", "no NumPy file"},
      {"/shard_00000/masks.npy", "xxxxxxxxxxxxxxxxxxxx", "no NumPy file"},
  };
  for (const auto& [file, bytes, said] : cases) {
    const std::string before = read_file(toy + file);
    replace_file(toy + file, bytes);
    EXPECT_NE(error().find(said), std::string::npos) << error();
    EXPECT_EQ(error().find('\n'), std::string::npos);
    replace_file(toy + file, before);
  }
  const std::string masks = read_file(shard + "/masks.npy"), faces = read_file(shard + "/faces.npy");
  for (const auto& [from, to] : {std::pair{"6, 256, 256", "5, 256, 256"}, {"|u1", "<f4"}, {"False", "True "}}) {
    std::string bytes = masks;
    bytes.replace(bytes.find(from), std::string(from).size(), to);
    replace_file(shard + "/masks.npy", bytes);
    EXPECT_NE(error().find("masks.npy"), std::string::npos) << error();
  }
  replace_file(shard + "/masks.npy", masks);
  std::string not_finite = faces;
  not_finite.replace(not_finite.size() - 4, 4, std::string("\0\0\xc0\x7f", 4));
  replace_file(shard + "/faces.npy", not_finite);
  EXPECT_NE(error().find("not finite"), std::string::npos) << error();
}

TrainOptions toy_options(const std::string& folder, const std::string& run) {
  TrainOptions options;
  options.data = {folder + "/train"};
  options.held_out = {folder + "/held_out"};
  options.output = folder + "/" + run;
  options.shape.stages = 1;
  options.threads = 1;
  return options;
}

TEST(SlowTraining, ResumesToTheSameWeights) {
  const TemporaryFolder folder;
  write_toy_people(folder.path.string() + "/train", 20, 1);
  write_toy_people(folder.path.string() + "/held_out", 4, 2);
  const std::atomic<bool> go_on{false};
  TrainOptions options = toy_options(folder.path.string(), "whole");
  options.samples = 64;
  train(options, go_on);

  options.output = folder.path.string() + "/halves";
  std::atomic<bool> stop{false};
  std::thread interruption([&] {  // wherever that falls
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    stop = true;
  });
  train(options, stop);
  interruption.join();
  options.resume = true;
  train(options, go_on);
  EXPECT_EQ(read_file(folder.path.string() + "/whole/person.safetensors"),
            read_file(folder.path.string() + "/halves/person.safetensors"));
  options.resume = false;
  EXPECT_THROW(train(options, go_on), InputError);  // holds a run
  options.resume = true;
  options.shape.stages = 2;
  EXPECT_THROW(train(options, go_on), InputError);  // another network's checkpoint
}

TEST(SlowTraining, LearnsWhoIsMeantFromTheFace) {
  const TemporaryFolder folder;
  write_toy_people(folder.path.string() + "/train", 128, 1);
  write_toy_people(folder.path.string() + "/held_out", 32, 2);
  const std::atomic<bool> go_on{false};
  TrainOptions options = toy_options(folder.path.string(), "run");
  options.samples = 960;
  train(options, go_on);
  Network network(options.shape);
  torch::serialize::InputArchive archive, weights;
  archive.load_from(options.output + "/checkpoint.pt");
  archive.read("network", weights);
  network->load(weights);
  const PeopleSet held_out({folder.path.string() + "/held_out"});
  std::vector<std::size_t> all(held_out.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  // Two figures alike in each picture: whoever takes both, or cannot tell them apart, gets at most a half.
  EXPECT_GT(evaluate(network, held_out, all).iou, 0.7);

  options.output = folder.path.string() + "/fine";
  options.fine_tune = folder.path.string() + "/run";
  options.samples = 64;
  train(options, go_on);
  const nlohmann::json log = nlohmann::json::parse(read_file(options.output + "/log.json"));
  EXPECT_EQ(log["training_samples"], 100);  // ceil(128 * 511 / 660)
  EXPECT_FALSE(log["points"].back().contains("pose_loss"));
  EXPECT_GT(log["points"].back()["held_out_iou"], 0.7);
}

}  // namespace
}  // namespace dualpixel::tools
