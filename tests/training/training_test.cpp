#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <utility>

#include "capture/error.h"
#include "pipeline/segmentation/face_map.h"
#include "pipeline/segmentation/face_network.h"
#include "pipeline/segmentation/network.h"
#include "tests/scenes/people/toy_people.h"
#include "tests/temporary_folder.h"
#include "tools/train_segmentation/augment.h"
#include "tools/train_segmentation/batches.h"
#include "tools/train_segmentation/checkpoint.h"
#include "tools/train_segmentation/evaluate.h"
#include "tools/train_segmentation/export.h"
#include "tools/train_segmentation/face_examples.h"
#include "tools/train_segmentation/train.h"
#include "tools/train_segmentation/train_faces.h"
#include "tools/train_segmentation/unfold.h"

namespace dualpixel::tools {
namespace {

/// A network as training would leave it: normalizations that are not the identity.
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

/// `layers` in place of the network's own, its normalizations made the identity.
void set_folded(Network& network, const std::vector<FoldedConv>& layers) {
  const torch::NoGradGuard no_gradients;
  const auto modules = network->named_modules();
  for (const FoldedConv& layer : layers) {
    if (const auto conv = std::dynamic_pointer_cast<ConvImpl>(modules[layer.name])) {
      conv->conv->weight.copy_(layer.weight);
      conv->norm->weight.fill_(1);
      conv->norm->bias.copy_(layer.bias);
      conv->norm->running_mean.zero_();
      conv->norm->running_var.fill_(1 - conv->norm->options.eps());
    } else {
      const auto plain = std::dynamic_pointer_cast<torch::nn::Conv2dImpl>(modules[layer.name]);
      ASSERT_TRUE(plain) << layer.name;
      plain->weight.copy_(layer.weight);
      plain->bias.copy_(layer.bias);
    }
  }
}

TEST(Export, FoldingChangesNoMask) {
  Network network = trained({});
  const torch::Tensor input = torch::rand({2, 4, kNetworkSize_px, kNetworkSize_px}) - 0.5;
  const torch::Tensor before = masks_of(network, input);
  std::vector<FoldedConv> layers = folded_layers(network);
  for (FoldedConv& layer : layers) layer.weight = layer.weight.clone(), layer.bias = layer.bias.clone();
  set_folded(network, layers);
  // 47 layers one after another, each of sums of up to 864 products of about 1, rounded to 24 bits on both sides; the
  // sigmoid takes a quarter.
  EXPECT_LT((masks_of(network, input) - before).abs().max().item<double>(), 2 * 47 * 864 * 0x1p-25 / 4);
  EXPECT_GT((before.max() - before.min()).item<double>(), 0.2);
}

TEST(Unfold, MasksStayInEvaluationAndAreTheSameInTraining) {
  Network network = trained({});
  const torch::Tensor input = torch::rand({4, 4, 64, 64}) - 0.5;
  const pipeline::NetworkWeights weights = pipeline::parse_weights(safetensors(folded_layers(network)), "weights");
  Network again = unfolded(weights, input, 3);
  const torch::Tensor masks = masks_of(again, input);
  // what folding and 16 bits change: of each number a part of 2^-11, which adds up like noise over 47 layers
  EXPECT_LT((masks - masks_of(network, input)).abs().max().item<double>(), 47 * 0x1p-11 / 4);
  EXPECT_GT((masks.max() - masks.min()).item<double>(), 0.2);
  const torch::NoGradGuard no_gradients;
  again->train();
  const std::vector<StageOutput> outputs = again->forward(input);
  // statistics of those very pictures: rounding alone differs, as in FoldingChangesNoMask
  EXPECT_LT((outputs.back().mask.sigmoid() - masks).abs().max().item<double>(), 2 * 47 * 864 * 0x1p-25 / 4);
  EXPECT_EQ(outputs[0].mask.abs().max().item<double>(), 0);
  for (const auto& item : again->named_parameters()) {
    const std::string& name = item.key();
    if (name.find("conv.weight") == std::string::npos || name.find("mask0") == 0 || name.find("mask1") == 0) continue;
    const torch::Tensor norms = item.value().flatten(1).norm(2, 1);
    EXPECT_NEAR(norms.min().item<double>(), std::sqrt(2), 1e-5) << name;
    EXPECT_NEAR(norms.max().item<double>(), std::sqrt(2), 1e-5) << name;
  }
}

TEST(Unfold, OtherWidthsAreRefused) {
  NetworkShape shape;
  shape.fine_channels = 8;
  Network network = trained(shape);
  const pipeline::NetworkWeights weights = pipeline::parse_weights(safetensors(folded_layers(network)), "weights");
  EXPECT_THROW(unfolded(weights, torch::zeros({1, 4, 64, 64}), 1), InputError);
}

TEST(Unfold, WeightsThatOverflowAreRefused) {
  Network network = trained({});
  pipeline::NetworkWeights weights = pipeline::parse_weights(safetensors(folded_layers(network)), "weights");
  for (const char* name : {"stem_half", "mask2.sub_pixels"}) {
    pipeline::NetworkWeights absurd = weights;
    for (float& weight : absurd.layers.at(name).weight) weight = 3e38F;
    EXPECT_THROW(unfolded(absurd, torch::rand({1, 4, 64, 64}), 1), InputError) << name;
  }
}

TEST(SlowExport, InferenceEqualsTraining) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  Network network = trained({});
  // The file holds 16-bit floats: compare with the same network rounded.
  std::vector<FoldedConv> layers = folded_layers(network);
  const std::string file = safetensors(layers);
  for (FoldedConv& layer : layers) {
    layer.weight = layer.weight.to(torch::kHalf).to(torch::kFloat32);
    layer.bias = layer.bias.to(torch::kHalf).to(torch::kFloat32);
  }
  set_folded(network, layers);
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
  ToyPeople() { scenes::write_toy_people(folder.path.string() + "/toy", 6, 1); }
  TemporaryFolder folder;
};

TEST_F(ToyPeople, UnchangedSamplesAreTheFiles) {
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
  ASSERT_EQ(set.size(), 6U);
  const scenes::PersonSample& sample = set[3];
  std::vector<float> input(256 * 256 * 4), mask(256 * 256), heatmaps(64 * 64 * 17);
  make_example(sample, {}, input.data(), mask.data(), heatmaps.data());
  for (int i = 0; i < 256 * 256; i += 37) {
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(input[4 * i + c], sample.picture[3 * i + c] / 255.0 - 0.5, 1e-6);
    ASSERT_NEAR(mask[i], sample.mask[i] / 255.0, 1e-6);
  }
  // the Gaussian's peak: between the four pixels about the face's center
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
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
  const scenes::PersonSample& sample = set[0];
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
      // and the face: its Gaussian keeps its width
      const std::array<double, 2> face =
          moved(sample.face[0] + sample.face[2] / 2, sample.face[1] + sample.face[3] / 2);
      for (int i = 0; i < 256 * 256; i += 53) {
        const double d2 = std::pow(i % 256 + 0.5 - face[0], 2) + std::pow(i / 256 + 0.5 - face[1], 2);
        ASSERT_NEAR(input[4 * i + 3], std::exp(-d2 / (2 * 21.0 * 21.0)), 1e-5);
      }
      // the person's color lies where the mask is: its mean under the mask is what it was, but for outlines
      double color = 0, area = 0, was_color = 0, was_area = 0;
      for (int i = 0; i < 256 * 256; ++i) {
        color += mask[i] * (input[4 * i] + 0.5);
        area += mask[i];
        was_color += before[i] * sample.picture[3 * i] / 255;
        was_area += before[i];
      }
      EXPECT_NEAR(color / area, was_color / was_area, 0.02);
      EXPECT_NEAR(area / was_area, scale * scale, 0.01);
      EXPECT_EQ(input[0], -0.5F);  // beyond the picture
    }
  }
}

TEST_F(ToyPeople, AugmentationKeepsItsRangesAndThePaddingBlack) {
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
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
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
  const std::vector<std::size_t> all = {0, 1, 2, 3, 4, 5};
  const auto make = [&](const std::vector<Draw>& draws) { return augmented_batch(set, draws, true); };
  AugmentedBatches from_start(all, 3, 9, 0, make), later(all, 3, 9, 6, make), other(all, 3, 8, 6, make);
  from_start.next();
  from_start.next();
  const Batch a = from_start.next(), b = later.next(), c = other.next();
  EXPECT_TRUE(torch::equal(a.input, b.input));
  EXPECT_TRUE(torch::equal(a.mask, b.mask));
  EXPECT_TRUE(torch::equal(a.heatmaps, b.heatmaps));
  EXPECT_FALSE(torch::equal(a.input, c.input));
}

/// A detector's map that says what the targets ask for.
std::vector<float> perfect_map(const std::vector<float>& targets) {
  std::vector<float> map(targets.begin(), targets.begin() + 4 * 64 * 64);
  for (int i = 0; i < 64 * 64; ++i) map[i] = map[i] == 1 ? 20.F : -20.F;
  return map;
}

TEST_F(ToyPeople, FaceTargetsAreReadBackAsTheMovedFaces) {
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
  const std::vector<TrueFace> faces = {{60, 70, 40, 0, true}, {150, 90, 30, 0, true}, {20, 200, 30, 0, false}};
  FaceAugmentation a;
  a.picture.mirror = true;
  a.picture.scale = 0.8;
  a.picture.rotation_rad = 0.2;
  a.picture.shift_x_px = 9;
  a.picture.shift_y_px = -14;
  std::vector<float> input(3 * 256 * 256), targets(kFaceTargets * 64 * 64);
  const std::vector<TrueFace> moved = make_face_example(set[0], faces, nullptr, a, input.data(), targets.data());
  ASSERT_EQ(moved.size(), 3U);
  const std::vector<pipeline::ScoredFace> read = pipeline::faces_of_map(perfect_map(targets).data(), 64, 0.5);
  ASSERT_EQ(read.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const double u = 0.8 * (128 - (faces[i].x + faces[i].side / 2)), v = 0.8 * (faces[i].y + faces[i].side / 2 - 128);
    const double x = 128 + std::cos(0.2) * u - std::sin(0.2) * v + 9;
    const double y = 128 + std::sin(0.2) * u + std::cos(0.2) * v - 14;
    const auto near = std::count_if(read.begin(), read.end(), [&](const pipeline::ScoredFace& found) {
      const pipeline::Face& box = found.face;  // 24-bit numbers of up to 256
      return std::hypot(box.x + box.width / 2 - x, box.y + box.height / 2 - y) < 1e-3 &&
             std::abs(box.width - 0.8 * faces[i].side) < 1e-3;
    });
    EXPECT_EQ(near, 1) << i;
  }
  // where a face is uncertain, no score counts
  const double u = moved[2].x + moved[2].side / 2, v = moved[2].y + moved[2].side / 2;
  EXPECT_EQ(targets[5 * 64 * 64 + static_cast<int>(v / 4) * 64 + static_cast<int>(u / 4)], 0);
  EXPECT_EQ(targets[5 * 64 * 64], 1);
}

TEST_F(ToyPeople, FaceLossIsLeastWhereTheMapIsRight) {
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
  std::vector<float> input(3 * 256 * 256), targets(kFaceTargets * 64 * 64);
  make_face_example(set[0], {{60, 70, 40, 0, true}}, nullptr, {}, input.data(), targets.data());
  std::vector<float> right = perfect_map(targets), beside = right, missed = right;
  std::rotate(beside.begin(), beside.begin() + 1, beside.begin() + 64 * 64);
  std::fill_n(missed.begin(), 64 * 64, -20.F);
  const auto loss = [&](std::vector<float>& map) {
    return face_loss(torch::from_blob(map.data(), {1, 4, 64, 64}),
                     torch::from_blob(targets.data(), {1, kFaceTargets, 64, 64}))
        .item<double>();
  };
  EXPECT_LT(loss(right), 1e-6);
  EXPECT_NEAR(loss(missed), 20, 1e-3);  // -log sigmoid(-20), of one face
  EXPECT_GT(loss(beside), 20);
  for (float& value : targets) value = &value < targets.data() + 5 * 64 * 64 ? value : 0;  // no score counts
  EXPECT_LT(loss(missed), 1e-6);
}

TEST(Faces, RecallIsWhatIsFoundAboveTheBorneAlarms) {
  const std::vector<FaceFound> found = {{0, true, 0, 20, 0.9},  {1, true, 0, 20, 0.5},  {2, true, 0, 20, 0},
                                        {0, false, 0, 20, 0.8}, {1, false, 0, 20, 0.4}, {3, true, 0, 20, 0.6}};
  EXPECT_EQ(recall_at(found, 10, 0), 0.25);    // above .8
  EXPECT_EQ(recall_at(found, 10, 0.1), 0.75);  // above .4, one alarm in ten pictures
  EXPECT_EQ(recall_at(found, 10, 1), 0.75);
}

TEST(Faces, InferenceEqualsTraining) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  Network network = trained(face_network_shape());
  std::vector<FoldedConv> layers = folded_layers(network);
  const std::string file = safetensors(layers);
  EXPECT_LT(file.size(), 560'000U);
  for (FoldedConv& layer : layers) {
    layer.weight = layer.weight.to(torch::kHalf).to(torch::kFloat32);
    layer.bias = layer.bias.to(torch::kHalf).to(torch::kFloat32);
  }
  set_folded(network, layers);
  pipeline::FaceNetwork inference(pipeline::parse_weights(file, "weights", pipeline::NetworkKind::faces));
  const torch::Tensor input = torch::rand({1, 320, 320, 3}) - 0.5;
  Image picture(320, 320, 3);
  std::copy_n(input.data_ptr<float>(), picture.data.size(), picture.data.begin());
  const std::vector<float> map = inference(picture);
  const torch::NoGradGuard no_gradients;
  network->eval();
  const torch::Tensor expected = network->face_map(input.permute({0, 3, 1, 2})).contiguous();
  ASSERT_EQ(static_cast<std::size_t>(expected.numel()), map.size());
  const float* const values = expected.data_ptr<float>();
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    worst = std::max(worst, static_cast<double>(std::abs(map[i] - values[i])));
    largest = std::max(largest, static_cast<double>(std::abs(values[i])));
  }
  EXPECT_LT(worst, 1e-4 * std::max(1.0, largest));  // 17 layers of sums of up to 576 products, each of 24 bits
  EXPECT_GT(largest, 0.1);
}

TEST_F(ToyPeople, ScoresAreTheirFormulas) {
  const scenes::PeopleSet set({folder.path.string() + "/toy"}, false);
  // Whatever an untrained network draws, against both formulas written out here.
  torch::manual_seed(3);
  NetworkShape shape;
  shape.stages = 1;
  Network network(shape);
  for (const bool half_size : {false, true}) {
    Batch batch = plain_batch(set, {0, 1}, false);
    if (half_size) batch = halved(batch);
    const int size = half_size ? 128 : 256;
    const torch::Tensor masks = masks_of(network, batch.input);
    {
      const torch::NoGradGuard no_gradients;
      network->mask_heads[0]->sub_pixels->bias.sub_(masks.logit().mean());  // about half is on
    }
    const torch::Tensor drawn = masks_of(network, batch.input).contiguous();
    const torch::Tensor truth = batch.mask.contiguous();
    const float* const m = drawn.data_ptr<float>();
    const float* const t = truth.data_ptr<float>();
    const std::vector<MaskScore> scores = evaluate(network, set, {0, 1}, {}, half_size);
    ASSERT_EQ(scores.size(), 2U);
    for (int n = 0; n < 2; ++n) {
      double gradient = 0;
      int both = 0, either = 0;
      const auto error = [&](int x, int y) { return m[(n * size + y) * size + x] - t[(n * size + y) * size + x]; };
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
          const bool on = m[(n * size + y) * size + x] > 0.5, is = t[(n * size + y) * size + x] > 0.5;
          both += on && is ? 1 : 0;
          either += on || is ? 1 : 0;
          if (x + 1 < size) gradient += std::pow(error(x + 1, y) - error(x, y), 2);
          if (y + 1 < size) gradient += std::pow(error(x, y + 1) - error(x, y), 2);
        }
      }
      EXPECT_GT(both, 0);
      EXPECT_NEAR(scores[n].iou, static_cast<double>(both) / either, 1e-9);
      EXPECT_NEAR(scores[n].gradient_error, gradient / (static_cast<double>(size) * size), 1e-6);
    }
    EXPECT_NEAR(mean_of(scores).iou, (scores[0].iou + scores[1].iou) / 2, 1e-12);
    EXPECT_NEAR(mean_of(scores).gradient_error, (scores[0].gradient_error + scores[1].gradient_error) / 2, 1e-12);
  }
}

TEST(InnerErrors, LookWellInsideOnly) {
  // A person of 100 x 100 pixels; 0.05 of 256 px is 13.
  torch::Tensor truth = torch::zeros({1, 1, 256, 256});
  const auto span = [](int from, int to) { return torch::indexing::Slice(from, to); };
  truth.index_put_({0, 0, span(80, 180), span(60, 160)}, 1);
  const auto error = [&](int border, float value) {  // all of the person right but for a border of so many pixels
    torch::Tensor predicted = torch::full({1, 1, 256, 256}, value);
    predicted.index_put_({0, 0, span(80 + border, 180 - border), span(60 + border, 160 - border)}, 1);
    return inner_errors_of(predicted, truth)[0].item<double>();
  };
  EXPECT_EQ(error(0, 1), 0);
  EXPECT_EQ(error(13, 0), 0);
  EXPECT_NEAR(error(14, 0), 1 - 72.0 * 72 / (74 * 74), 1e-6);
  EXPECT_NEAR(error(50, 0.25F), 0.75, 1e-6);
  EXPECT_EQ(inner_errors_of(truth, torch::zeros_like(truth))[0].item<double>(), 0);  // no person
}

TEST(Batches, HalvesAreMeansOfFour) {
  const torch::Tensor ramp = torch::arange(16, torch::kFloat32).reshape({1, 1, 4, 4});
  const torch::Tensor means = torch::tensor({2.5F, 4.5F, 10.5F, 12.5F}).reshape({1, 1, 2, 2});
  const Batch half = halved({ramp, 2 * ramp, 3 * ramp});
  EXPECT_TRUE(torch::equal(half.input, means));
  EXPECT_TRUE(torch::equal(half.mask, 2 * means));
  EXPECT_TRUE(torch::equal(half.heatmaps, 3 * means));
  EXPECT_FALSE(halved({ramp, ramp, {}}).heatmaps.defined());
}

TEST(SoftIouLoss, WeighsSmallPeopleLikeLargeOnes) {
  // logits of 0 are masks of 1/2: of n pixels, k of them the person's, (k/2 + 8) / (k + n/2 - k/2 + 8)
  torch::Tensor mask = torch::zeros({2, 1, 8, 8});
  mask[0].slice(1, 0, 4).fill_(1);  // 32 of 64
  mask[1].slice(1, 0, 1).fill_(1);  // 8 of 64
  const torch::Tensor logits = torch::zeros({2, 1, 8, 8});
  EXPECT_NEAR(soft_iou_loss(logits, mask).item<double>(), 1 - 0.5 * (24.0 / 56 + 12.0 / 44), 1e-6);
  EXPECT_NEAR(soft_iou_loss(100 * (mask - 0.5), mask).item<double>(), 0, 1e-6);
}

TEST(WorkDone, CountsHalfSizeForAQuarter) {
  // half of the work at half size: 4 samples for each one at full size
  EXPECT_EQ(work_done(0, 100, 0.5), 0);
  EXPECT_NEAR(work_done(40, 100, 0.5), 0.25, 1e-12);
  EXPECT_NEAR(work_done(80, 100, 0.5), 0.5, 1e-12);
  EXPECT_NEAR(work_done(90, 100, 0.5), 0.75, 1e-12);
  EXPECT_EQ(work_done(100, 100, 0.5), 1);
  EXPECT_NEAR(work_done(30, 100, 0), 0.3, 1e-12);
  EXPECT_NEAR(work_done(30, 100, 1), 0.3, 1e-12);
}

TEST(LearningRate, OneCycleAndThePapersSteps) {
  EXPECT_EQ(learning_rate(0, 3e-3, false), 0);
  EXPECT_NEAR(learning_rate(0.05, 3e-3, false), 3e-3, 1e-12);
  EXPECT_NEAR(learning_rate(1, 3e-3, false), 1e-6, 1e-12);
  EXPECT_EQ(learning_rate(0, 0.1, true), 0.1);
  EXPECT_EQ(learning_rate(0.899, 0.1, true), 0.1);
  EXPECT_EQ(learning_rate(0.901, 0.1, true), 1e-4);
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

bool never(std::uint64_t) { return false; }

TEST(SlowTraining, ResumesToTheSameWeights) {
  const TemporaryFolder folder;
  scenes::write_toy_people(folder.path.string() + "/train", 20, 1);
  scenes::write_toy_people(folder.path.string() + "/held_out", 4, 2, true);
  TrainOptions options = toy_options(folder.path.string(), "whole");
  options.samples = 160;
  train(options, never);

  options.output = folder.path.string() + "/parts";
  for (const std::uint64_t part : {32, 144}) {  // of which the first ends at half size
    train(options, [part](std::uint64_t samples) { return samples >= part; });
    options.resume = true;
  }
  train(options, never);
  EXPECT_EQ(read_file(folder.path.string() + "/whole/person.safetensors"),
            read_file(folder.path.string() + "/parts/person.safetensors"));
  using Points = std::vector<std::pair<int, int>>;  // samples seen, side in pixels
  const auto points_of = [&](const std::string& run) {
    Points points;
    const nlohmann::json log = nlohmann::json::parse(read_file(folder.path.string() + run + "/log.json"));
    for (const auto& point : log["points"]) {
      points.emplace_back(point["samples"], point["size_px"]);
    }
    return points;
  };
  EXPECT_EQ(points_of("/whole"), (Points{{144, 128}, {160, 256}}));  // no entry is of both sizes
  EXPECT_EQ(points_of("/parts"), (Points{{32, 128}, {144, 128}, {160, 256}}));
}

TEST(SlowTraining, SgdResumesToTheSameWeightsAndScoresAreListed) {
  const TemporaryFolder folder;
  scenes::write_toy_people(folder.path.string() + "/train", 20, 1);
  scenes::write_toy_people(folder.path.string() + "/held_out", 4, 2, true);
  TrainOptions options = toy_options(folder.path.string(), "whole");
  options.sgd = true;
  options.half_size = 0;
  options.samples = 48;
  train(options, never);
  options.output = folder.path.string() + "/parts";
  train(options, [](std::uint64_t samples) { return samples >= 16; });
  options.resume = true;
  train(options, never);
  EXPECT_EQ(read_file(folder.path.string() + "/whole/person.safetensors"),
            read_file(folder.path.string() + "/parts/person.safetensors"));
  const nlohmann::json log = nlohmann::json::parse(read_file(folder.path.string() + "/whole/log.json"));
  EXPECT_EQ(log["recipe"]["rate"], 0.1);
  std::istringstream table(read_file(folder.path.string() + "/whole/scores.csv"));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "sample,seed,people,composite,iou,gradient_error");
  double sum = 0;
  int lines = 0;
  for (; std::getline(table, line); ++lines) {
    std::istringstream fields(line);
    for (int field = 0; field < 5; ++field) std::getline(fields, line, ',');
    sum += std::stod(line);
  }
  ASSERT_EQ(lines, 4);
  EXPECT_NEAR(sum / lines, log["points"].back()["held_out_iou"].get<double>(), 1e-6);  // six digits
}

TEST(SlowTraining, OtherRunsCheckpointsAreRefused) {
  const TemporaryFolder folder;
  scenes::write_toy_people(folder.path.string() + "/train", 20, 1);
  scenes::write_toy_people(folder.path.string() + "/held_out", 4, 2, true);
  TrainOptions options = toy_options(folder.path.string(), "run");
  options.samples = 16;
  train(options, never);
  const auto refusal = [](const TrainOptions& other) {
    try {
      train(other, never);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal(options).find("holds a run"), std::string::npos);
  options.resume = true;
  EXPECT_EQ(refusal(options), "");
  const auto with = [&](const auto& change) {
    TrainOptions changed = options;
    change(changed);
    return refusal(changed);
  };
  EXPECT_NE(with([](TrainOptions& o) { o.shape.stages = 2; }).find("its stages is 1, not 2"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.seed = 2; }).find("its seed is 1, not 2"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.samples = 32; }).find("its samples is 16, not 32"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.half_size = 0; }).find("its half_size"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.threads = 2; }).find("its threads is 1, not 2"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.composites = false; }).find("its composites"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.rate = 1e-3; }).find("its rate is 0.003, not 0.001"), std::string::npos);
  EXPECT_NE(with([](TrainOptions& o) { o.sgd = true; }).find("its sgd is false, not true"), std::string::npos);
  if (!torch::cuda::is_available()) {
    EXPECT_NE(with([](TrainOptions& o) { o.device = torch::kCUDA; }).find("no such device"), std::string::npos);
  }
  EXPECT_NE(with([](TrainOptions& o) { o.fine_tune = o.output; }).find("of another run"), std::string::npos);
  TrainOptions other = options;
  scenes::write_toy_people(folder.path.string() + "/other", 20, 3);
  other = options;
  other.data = {folder.path.string() + "/other"};
  EXPECT_NE(refusal(other).find("its data_hash"), std::string::npos);
  other = options;
  scenes::write_toy_people(folder.path.string() + "/other_held_out", 4, 4, true);
  other.held_out = {folder.path.string() + "/other_held_out"};
  EXPECT_NE(refusal(other).find("its held_out_hash"), std::string::npos);
  other.held_out = options.data;
  EXPECT_NE(refusal(other).find("/held_out: false"), std::string::npos);
  Checkpoint older = read_checkpoint(options.output + "/checkpoint.pt");
  older.recipe.erase("rate");
  std::filesystem::create_directories(folder.path / "older");
  write_checkpoint(older, folder.path.string() + "/older/checkpoint.pt");
  EXPECT_NE(with([&](TrainOptions& o) { o.output = folder.path.string() + "/older"; }).find("without its rate"),
            std::string::npos);
  const std::string checkpoint = read_file(options.output + "/checkpoint.pt");
  for (const std::size_t length : {std::size_t{0}, std::size_t{1000}, checkpoint.size() / 2}) {
    replace_file(options.output + "/checkpoint.pt", checkpoint.substr(0, length));
    EXPECT_NE(refusal(options).find("is not a checkpoint"), std::string::npos) << refusal(options);
  }
  options.output = "/dev/null/run";
  options.resume = false;
  EXPECT_NE(refusal(options).find("cannot be made a folder"), std::string::npos);
}

TEST(SlowTraining, LearnsWhoIsMeantFromTheFace) {
  const TemporaryFolder folder;
  scenes::write_toy_people(folder.path.string() + "/train", 128, 1);
  scenes::write_toy_people(folder.path.string() + "/held_out", 32, 2, true);
  const scenes::PeopleSet held_out({folder.path.string() + "/held_out"}, true);
  std::vector<std::size_t> all(held_out.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  TrainOptions options = toy_options(folder.path.string(), "run");
  options.samples = 960;
  options.half_size = 0;
  for (const bool bf16 : {true, false}) {
    options.bf16 = bf16;
    options.output = folder.path.string() + (bf16 ? "/bf16" : "/run");
    train(options, never);
    Network network = read_checkpoint(options.output + "/checkpoint.pt").network;
    // Two figures alike in each picture: whoever takes both, or cannot tell them apart, gets at most a half.
    EXPECT_GT(mean_of(evaluate(network, held_out, all)).iou, 0.7) << bf16;
  }

  options.output = folder.path.string() + "/fine";
  options.fine_tune = folder.path.string() + "/run";
  options.samples = 64;
  train(options, never);
  const nlohmann::json log = nlohmann::json::parse(read_file(options.output + "/log.json"));
  EXPECT_EQ(log["training_samples"], 100);  // ceil(128 * 511 / 660)
  EXPECT_FALSE(log["points"].back().contains("pose_loss"));
  EXPECT_GT(log["points"].back()["held_out_iou"], 0.7);
}

TEST(SlowTraining, FineTuningResumesAndBaselinesTrain) {
  const TemporaryFolder folder;
  scenes::write_toy_people(folder.path.string() + "/train", 20, 1);
  scenes::write_toy_people(folder.path.string() + "/held_out", 4, 2, true);
  TrainOptions options = toy_options(folder.path.string(), "first");
  options.samples = 16;
  train(options, never);
  TrainOptions fine = options;
  fine.fine_tune = options.output;
  fine.samples = 48;
  fine.output = folder.path.string() + "/whole";
  train(fine, never);
  fine.output = folder.path.string() + "/parts";
  train(fine, [](std::uint64_t samples) { return samples >= 16; });
  fine.resume = true;
  options.resume = true;
  train(options, never);  // scores the first phase again, and writes it anew
  train(fine, never);
  EXPECT_EQ(read_file(folder.path.string() + "/whole/person.safetensors"),
            read_file(folder.path.string() + "/parts/person.safetensors"));

  fine.resume = false;
  fine.fine_tune = fine.output + "/person.safetensors";  // the weights after 48 samples
  fine.output = folder.path.string() + "/not_at_all";
  train(fine, [](std::uint64_t) { return true; });
  const pipeline::NetworkWeights given = pipeline::read_weights(fine.fine_tune);
  const pipeline::NetworkWeights same = pipeline::read_weights(fine.output + "/person.safetensors");
  for (const auto& [name, layer] : given.layers) {
    const std::vector<float>& now = same.layers.at(name).weight;
    const float largest = std::abs(*std::max_element(layer.weight.begin(), layer.weight.end(),
                                                     [](float a, float b) { return std::abs(a) < std::abs(b); }));
    // rounded to 11 bits once more, after unfolding and folding in 24
    for (std::size_t i = 0; i < now.size(); ++i) ASSERT_NEAR(now[i], layer.weight[i], 0x1p-11F * largest) << name;
  }
  fine.output = folder.path.string() + "/further";
  train(fine, never);
  fine.output = folder.path.string() + "/further_in_parts";
  train(fine, [](std::uint64_t samples) { return samples >= 16; });
  fine.resume = true;
  train(fine, never);
  EXPECT_EQ(read_file(folder.path.string() + "/further/person.safetensors"),
            read_file(folder.path.string() + "/further_in_parts/person.safetensors"));

  const auto refusal = [&] {
    try {
      train(fine, never);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  fine.resume = false;
  fine.output = folder.path.string() + "/own";
  std::filesystem::create_directory(fine.output);
  std::filesystem::copy_file(fine.fine_tune, fine.output + "/person.safetensors");
  fine.fine_tune = fine.output + "/person.safetensors";
  EXPECT_NE(refusal().find("would write over it"), std::string::npos) << refusal();
  for (const std::string& name : {folder.path.string() + "/train/people.json", folder.path.string() + "/none",
                                  folder.path.string() + "/" + std::string(300, 'n')}) {
    fine.fine_tune = name;
    EXPECT_EQ(refusal().rfind(name.substr(0, 50), 0), 0U) << refusal();
  }

  options = toy_options(folder.path.string(), "fcn");
  options.samples = 16;
  options.shape.fcn = true;
  options.shape.pose = false;
  train(options, never);
  EXPECT_FALSE(std::filesystem::exists(options.output + "/person.safetensors"));
  EXPECT_TRUE(read_checkpoint(options.output + "/checkpoint.pt").network->shape.fcn);
  EXPECT_TRUE(std::filesystem::exists(options.output + "/chart.html"));

  const std::string samples = folder.path.string() + "/train/shard_00000/samples.json";
  std::string json = read_file(samples);
  for (std::size_t at = 0; (at = json.find("false", at)) != std::string::npos;) json.replace(at, 5, "true");
  replace_file(samples, json);
  options = toy_options(folder.path.string(), "rendered");
  options.samples = 16;
  options.composites = false;
  EXPECT_THROW(train(options, never), InputError);  // all are composites
}

}  // namespace
}  // namespace dualpixel::tools
