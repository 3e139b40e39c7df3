#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <random>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "pipeline/segmentation/face_map.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/pipeline/segmentation/toy_network.h"

namespace dualpixel::pipeline {
namespace {

#define NEEDS_NETWORK() \
  if (!has_person_network()) GTEST_SKIP() << "built without oneDNN"

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PersonWeights, AreWhatTheFileHolds) {
  const NetworkWeights written = random_network(2, 1);
  const NetworkWeights read = parse_weights(as_safetensors(written), "x");
  EXPECT_EQ(read.stages, 2);
  EXPECT_EQ(read.fine_channels, 8);
  EXPECT_EQ(read.unet_channels, written.unet_channels);
  ASSERT_EQ(read.layers.size(), written.layers.size());
  for (const auto& [name, conv] : written.layers) {
    EXPECT_EQ(read.layers.at(name).weight, conv.weight) << name;
    EXPECT_EQ(read.layers.at(name).bias, conv.bias) << name;
  }
}

TEST(PersonWeights, HalfPrecisionIsExact) {
  // IEEE 754-2019, table 3.5: one, the largest, the smallest normal and subnormal, a third, minus zero.
  const std::vector<std::pair<std::uint16_t, float>> known = {
      {0x3c00, 1},  {0x7bff, 65504}, {0x0400, 0x1p-14F}, {0x0001, 0x1p-24F}, {0x3555, 0.333251953125F},
      {0xc000, -2}, {0x8000, -0.F},  {0x0000, 0}};
  const NetworkWeights weights = empty_network(1);
  std::string header = "{", data;  // the eight values stand in stem_fine's bias
  for (const auto& layer : weights.layers) {
    const std::string& name = layer.first;
    const ConvWeights& conv = layer.second;
    const auto add = [&](const std::string& part, const std::string& shape, std::size_t count, bool known_values) {
      const std::size_t begin = data.size();
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint16_t half = known_values ? known[i].first : 0;
        data.append(reinterpret_cast<const char*>(&half), 2);
      }
      header += fmt::format("{}\"{}{}\":{{\"dtype\":\"F16\",\"shape\":[{}],\"data_offsets\":[{},{}]}}",
                            header.size() > 1 ? "," : "", name, part, shape, begin, data.size());
    };
    add(".weight", fmt::format("{},{},{},{}", conv.out, conv.in, conv.kernel, conv.kernel), conv.weight.size(), false);
    add(".bias", fmt::format("{}", conv.out), conv.bias.size(), name == "stem_fine");
  }
  const NetworkWeights read = parse_weights(safetensors_file(header + "}", data), "x");
  for (std::size_t i = 0; i < known.size(); ++i) {
    EXPECT_EQ(read.layers.at("stem_fine").bias[i], known[i].second);
    EXPECT_EQ(std::signbit(read.layers.at("stem_fine").bias[i]), std::signbit(known[i].second));
  }
}

TEST(PersonWeights, DamageIsOneClearLine) {
  const NetworkWeights good = random_network(1, 1);
  const std::string file = as_safetensors(good);
  const auto edited = [&](const std::string& tensor, const std::string& from, const std::string& to) {
    return as_safetensors(good, [&](const std::string& name, std::string json) {
      const std::size_t at = json.find(from);
      if (name == tensor && at != std::string::npos) json.replace(at, from.size(), to);
      return json;
    });
  };
  NetworkWeights holed = good, infinite = good, extra = good, wide = good;
  holed.layers.erase("stage0.up1");
  infinite.layers["mask0.mix"].weight[5] = kNan;
  extra.layers["rogue\\nlayer"] = good.layers.at("stem_fine");
  wide.layers["stage0.lateral2"].kernel = 3;
  wide.layers["stage0.lateral2"].weight.resize(8 * 8 * 9);
  std::string long_header = file;
  long_header[7] = '\x7f';
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "shorter than 8 bytes"},
      {file.substr(0, 7), "shorter than 8 bytes"},
      {long_header, "a header of"},
      {file.substr(0, 100), "a header of"},
      {file.substr(0, file.size() - 1), "data_offsets"},
      {file + "x", "1 bytes follow"},
      {safetensors_file("[]", ""), "JSON object"},
      {safetensors_file("{}", ""), "no stage"},
      {safetensors_file("{\"a\":", ""), "x: "},
      {safetensors_file(std::string(1000, '['), ""), "nested"},
      {edited("mask0.mix.bias", "F32", "I64"), "dtype"},
      {edited("mask0.mix.bias", "[8]", "[-8]"), "shape"},
      {edited("mask0.mix.bias", "[8]", "[8.5]"), "whole numbers"},
      {edited("mask0.mix.bias", "[8]", "[1024,1024,1024,1024]"), "data_offsets"},
      {edited("mask0.mix.bias", "[8]", "[4,2]"), "mask0.mix.bias: shape 4 x 2: must be 8"},
      {edited("mask0.coarse.bias", "[256,288]", "[0,32]"), "overlap"},
      {edited("mask0.coarse.bias", "data_offsets\":[", "data_offsets\":[1e99,"), "data_offsets"},
      {as_safetensors(holed), "stage0.up1.weight: is missing"},
      {as_safetensors(infinite), "mask0.mix.weight: value 5 is not finite"},
      {as_safetensors(extra), "rogue"},
      {as_safetensors(wide), "stage0.lateral2.weight: shape 8 x 8 x 3 x 3: must be 8 x 8 x 1 x 1"},
  };
  for (const auto& damaged : cases) {
    const std::string& said = damaged.second;
    const std::string error = error_of([&] { parse_weights(damaged.first, "x"); });
    EXPECT_EQ(error.rfind("x: ", 0), 0U) << said << ": " << error;
    EXPECT_NE(error.find(said), std::string::npos) << said << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
  // every prefix is refused, whatever it was cut in
  for (std::size_t length = 0; length < file.size(); length += 997) {
    EXPECT_NE(error_of([&] { parse_weights(file.substr(0, length), "x"); }), "") << length;
  }
}

/// Planes of one side, channel after channel.
struct Planes {
  int side = 0;
  std::vector<double> data;
  int channels() const { return static_cast<int>(data.size()) / (side * side); }
};

Planes naive(const Planes& in, const ConvWeights& conv, int stride) {
  Planes out{in.side / stride, std::vector<double>(conv.out * (in.side / stride) * (in.side / stride))};
  for (int o = 0; o < conv.out; ++o) {
    for (int y = 0; y < out.side; ++y) {
      for (int x = 0; x < out.side; ++x) {
        double sum = conv.bias[o];
        for (int i = 0; i < conv.in; ++i) {
          for (int ky = 0; ky < conv.kernel; ++ky) {
            const int sy = y * stride + ky - conv.kernel / 2;
            if (sy < 0 || sy >= in.side) continue;
            for (int kx = 0; kx < conv.kernel; ++kx) {
              const int sx = x * stride + kx - conv.kernel / 2;
              if (sx < 0 || sx >= in.side) continue;
              sum += conv.weight[((o * conv.in + i) * conv.kernel + ky) * conv.kernel + kx] *
                     in.data[(i * in.side + sy) * in.side + sx];
            }
          }
        }
        out.data[(o * out.side + y) * out.side + x] = sum;
      }
    }
  }
  return out;
}

Planes relu(Planes planes) {
  for (double& value : planes.data) value = std::max(value, 0.0);
  return planes;
}

Planes sum(Planes a, const Planes& b) {
  for (std::size_t i = 0; i < a.data.size(); ++i) a.data[i] += b.data[i];
  return a;
}

Planes twice(const Planes& in) {
  Planes out{2 * in.side, std::vector<double>(4 * in.data.size())};
  for (int c = 0; c < in.channels(); ++c) {
    for (int y = 0; y < out.side; ++y) {
      for (int x = 0; x < out.side; ++x) {
        out.data[(c * out.side + y) * out.side + x] = in.data[(c * in.side + y / 2) * in.side + x / 2];
      }
    }
  }
  return out;
}

/// network.h's formulas, word for word.
std::vector<double> reference_mask(const NetworkWeights& weights, const Image& input) {
  const auto conv = [&](const std::string& layer, const Planes& in, int stride = 1) {
    return naive(in, weights.layers.at(layer), stride);
  };
  Planes planes{kNetworkSize_px, std::vector<double>(input.data.size())};
  for (std::size_t i = 0; i < input.data.size(); ++i) planes.data[i % 4 * input.pixel_count() + i / 4] = input.data[i];
  const Planes fine = relu(conv("stem_fine", relu(conv("stem_half", planes, 2))));
  Planes x = relu(conv("stem_quarter", fine, 2)), y;
  for (int s = 0; s < weights.stages; ++s) {
    const auto name = [&](const char* part, int level) { return fmt::format("stage{}.{}{}", s, part, level); };
    std::vector<Planes> skips = {relu(conv(name("across", 0), x))};
    for (int level = 1; level < 4; ++level) {
      skips.push_back(relu(conv(name("across", level), relu(conv(name("down", level), skips.back(), 2)))));
    }
    y = skips[3];
    for (int level = 2; level >= 0; --level) {
      y = relu(conv(name("up", level), relu(sum(skips[level], twice(conv(name("lateral", level), y))))));
    }
    if (s + 1 < weights.stages) x = relu(sum(x, conv(fmt::format("between{}", s), y)));
  }
  const std::string mask = fmt::format("mask{}.", weights.stages - 1);
  const Planes logits =
      conv(mask + "sub_pixels", relu(conv(mask + "mix", relu(sum(fine, twice(conv(mask + "coarse", y)))))));
  std::vector<double> result(kNetworkSize_px * kNetworkSize_px);
  for (int py = 0; py < kNetworkSize_px; ++py) {
    for (int px = 0; px < kNetworkSize_px; ++px) {
      const int sub_pixel = 2 * (py % 2) + px % 2;
      const double logit = logits.data[(sub_pixel * logits.side + py / 2) * logits.side + px / 2];
      result[py * kNetworkSize_px + px] = 1 / (1 + std::exp(-logit));
    }
  }
  return result;
}

Image random_input(unsigned seed) {
  std::mt19937 random(seed);
  Image input(kNetworkSize_px, kNetworkSize_px, 4);
  for (float& value : input.data) value = static_cast<float>(random() % 1000) / 1000 - 0.5F;
  return input;
}

TEST(PersonNetwork, IsItsFormulas) {
  NEEDS_NETWORK();
  const NetworkWeights weights = random_network(2, 3);
  PersonNetwork network(weights);
  const Image input = random_input(1), mask = network(input);
  const std::vector<double> expected = reference_mask(weights, input);
  double worst = 0, low = 1, high = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    worst = std::max(worst, std::abs(mask.data[i] - expected[i]));
    low = std::min(low, expected[i]);
    high = std::max(high, expected[i]);
  }
  // 33 layers one after another, which hand on what they are given at about its size; each rounds 72 sums of about 1 to
  // 24 bits, by 2^-25 of them at most, were all to round one way; the sigmoid takes a quarter.
  EXPECT_LT(worst, 33 * 72 * 0x1p-25 / 4);
  EXPECT_GT(high - low, 0.1);  // a mask that says nothing would agree with anything
}

TEST(PersonNetwork, SameBytesForAnyNumberOfThreadsAndEveryRun) {
  NEEDS_NETWORK();
  const NetworkWeights weights = random_network(1, 4);
  PersonNetwork one(weights, 1), two(weights, 2);
  const Image input = random_input(2), first = one(input);
  one(random_input(3));
  EXPECT_EQ(one(input).data, first.data);
  EXPECT_EQ(two(input).data, first.data);
}

TEST(PersonNetwork, RefusesOtherSizes) {
  NEEDS_NETWORK();
  PersonNetwork network(face_follower());
  EXPECT_THROW(network(Image(256, 256, 3)), InputError);
  EXPECT_THROW(network(Image(255, 256, 4)), InputError);
  EXPECT_THROW(network(Image()), InputError);
}

// A sum beyond the largest float meets its opposite: without a check the mask would be silently empty.
TEST(PersonNetwork, AbsurdWeightsAreSaidToBe) {
  NEEDS_NETWORK();
  NetworkWeights weights = random_network(1, 3);
  for (float& weight : weights.layers.at("mask0.sub_pixels").weight) weight *= 1e38F;
  for (float& weight : weights.layers.at("mask0.mix").weight) weight *= 1e30F;
  weights.file = "a file";
  PersonNetwork network(weights);
  const std::string error = error_of([&] { network(random_input(1)); });
  EXPECT_EQ(error.rfind("a file: ", 0), 0U) << error;
}

TEST(SlowPersonNetworkDeathTest, EitherPrecisionExcludesTheOther) {
  NEEDS_NETWORK();
  if (!__builtin_cpu_supports("avx512bw")) GTEST_SKIP() << "a processor without AVX-512";
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // in processes of their own, in which no network was built before
  const auto build = [](Precision precision) {
    const std::string error = error_of([&] { const PersonNetwork network(random_network(1, 1), 1, precision); });
    std::fputs((error + "|").c_str(), stderr);
  };
  EXPECT_EXIT((build(Precision::bf16), build(Precision::f32), std::exit(0)), testing::ExitedWithCode(0),
              "^\\|person network: f32 cannot follow bf16 in one process\\|$");
  EXPECT_EXIT(
      (build(Precision::f32), build(Precision::bf16), std::exit(0)), testing::ExitedWithCode(0),
      "^\\|person network: bf16 needs a processor with AVX-512, and a process that has built no network in f32");
}

std::ptrdiff_t threads_of_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
}

// In a process of its own, in which no thread has been started. On a busy machine a second one costs ten times the
// time.
TEST(SlowPersonNetworkDeathTest, RunsOnOneThread) {
  NEEDS_NETWORK();
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto print_started = [] {
    const std::ptrdiff_t before = threads_of_process();
    PersonNetwork network(random_network(2, 1), 1);
    network(random_input(1));
    std::fprintf(stderr, "started %td\n", threads_of_process() - before);
    std::exit(0);
  };
  EXPECT_EXIT(print_started(), testing::ExitedWithCode(0), "started 0");
}

// In a process of its own, in which no network was built before. All widths are 8: oneDNN 3.7 needs multiples of 16.
TEST(SlowPersonNetworkDeathTest, SixteenBitFloatsAreItsFormulasRounded) {
  NEEDS_NETWORK();
  if (!__builtin_cpu_supports("avx512bw")) GTEST_SKIP() << "a processor without AVX-512";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto print_rms = [] {
    const NetworkWeights weights = random_network(2, 3);
    const Image input = random_input(1);
    const Image mask = PersonNetwork(weights, 1, Precision::bf16)(input);
    const std::vector<double> expected = reference_mask(weights, input);
    const auto logit = [](double value) { return std::log(value / (1 - value)); };
    double errors = 0, values = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      errors += std::pow(logit(mask.data[i]) - logit(expected[i]), 2);
      values += std::pow(logit(expected[i]), 2);
    }
    // 33 layers, as in IsItsFormulas; each rounds weights and results to 8 bits, by 2^-8 of them at most, were all to
    // round one way. The same network in f32 has less than a thousandth of that; layers that err by a third have more.
    const double error = std::sqrt(errors / values), most = 33 * 2 * 0x1p-8;
    std::fputs(
        fmt::format("{} of {}: {}", error, most, error > most / 1000 && error < most ? "as rounded" : "wrong").c_str(),
        stderr);
  };
  EXPECT_EXIT((print_rms(), std::exit(0)), testing::ExitedWithCode(0), "as rounded$");
}

TEST(SeedFaces, AThirdOfTheLargestAnd9PerMilleOfThePicture) {
  // a picture of 1000 x 1000: 0.93 % is 9300; of boxes 1.18 times as wide, as the paper's 1.3 %
  const Face largest{0, 0, 300, 300};                        // 90000
  const Face third{0, 0, 300, 100}, under{0, 0, 300, 99.9};  // a third, and less
  EXPECT_EQ(seed_faces({largest, third, under}, 1000, 1000).size(), 2U);
  EXPECT_EQ(seed_faces({{0, 0, 92.9, 100}}, 1000, 1000).size(), 0U);  // not more than 0.93 %
  EXPECT_EQ(seed_faces({{0, 0, 93, 100.1}}, 1000, 1000).size(), 1U);
  EXPECT_NEAR(SeedOptions().least_of_picture * 1.18 * 1.18, 0.013, 0.00005 * 1.18 * 1.18);  // it has two digits
  EXPECT_TRUE(seed_faces({}, 1000, 1000).empty());
  EXPECT_EQ(seed_faces(std::vector<Face>(20, largest), 1000, 1000).size(), 20U);
}

TEST(NetworkInput, IsThePictureInTheMiddleOfBlackAndAGaussianOnTheFace) {
  // 1024 x 512 becomes 256 x 128 between 64 black rows; blocks of 4 x 4 of 0 and 0.5 average 0.25
  Image picture(1024, 512, 3);
  for (int y = 0; y < 512; ++y) {
    for (int x = 0; x < 1024; ++x) {
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = (x + y) % 2 == 0 ? 0.5F : 0;
    }
  }
  const Face face{610, 182, 60, 60};  // center (640, 212), in the square (160, 64 + 53)
  const Image input = network_input(picture, face);
  EXPECT_EQ(input.at(100, 63, 0), -0.5F);
  EXPECT_EQ(input.at(100, 192, 2), -0.5F);
  // encode_for_display is within 3e-5 of the curve
  EXPECT_NEAR(input.at(0, 64, 0), srgb_from_linear(0.25F) - 0.5F, 4e-5);
  EXPECT_NEAR(input.at(255, 191, 1), srgb_from_linear(0.25F) - 0.5F, 4e-5);
  for (const auto& [x, y] : {std::pair{160, 117}, {181, 117}, {139, 150}, {0, 0}}) {
    const double r2 = (x + 0.5 - 160) * (x + 0.5 - 160) + (y + 0.5 - 117) * (y + 0.5 - 117);
    EXPECT_NEAR(input.at(x, y, 3), std::exp(-r2 / (2 * 21 * 21)), 1e-6);
  }
}

TEST(PersonMask, IsTheNetworksWithoutThePadding) {
  NEEDS_NETWORK();
  PersonNetwork network(random_network(1, 8));
  struct Case {
    int width, height;  // of the picture
    int mask_width, mask_height, padding_x, padding_y;
  };
  for (const Case& c :
       {Case{1200, 900, 256, 192, 0, 32}, Case{900, 1200, 192, 256, 32, 0}, Case{500, 500, 256, 256, 0, 0},
        Case{256, 100, 256, 100, 0, 78}, Case{90, 60, 256, 171, 0, 42}}) {
    Image picture(c.width, c.height, 3);
    for (int y = 0; y < c.height; ++y) {
      for (int x = 0; x < c.width; ++x) picture.at(x, y, x * 3 / c.width) = static_cast<float>(y) / c.height;
    }
    const Face face{0.6 * c.width, 0.3 * c.height, 0.1 * c.width, 0.1 * c.height};
    const Image mask = person_mask(picture, {face}, network), whole = network(network_input(picture, face));
    ASSERT_EQ(mask.width, c.mask_width);
    ASSERT_EQ(mask.height, c.mask_height);
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        ASSERT_EQ(mask.at(x, y), whole.at(x + c.padding_x, y + c.padding_y));
      }
    }
  }
}

TEST(PersonMask, JoinsByMaximum) {
  NEEDS_NETWORK();
  PersonNetwork network(random_network(1, 5));
  Image picture(320, 240, 3);
  std::mt19937 random(1);
  for (float& value : picture.data) value = static_cast<float>(random() % 1000) / 1000;
  const Face a{50, 60, 40, 40}, b{200, 100, 60, 60};
  const Image mask_a = person_mask(picture, {a}, network), mask_b = person_mask(picture, {b}, network);
  const Image both = person_mask(picture, {a, b}, network);
  EXPECT_NE(mask_a.data, mask_b.data);
  for (std::size_t i = 0; i < both.data.size(); ++i) {
    ASSERT_EQ(both.data[i], std::max(mask_a.data[i], mask_b.data[i]));
  }
}

TEST(PersonMask, OddPictures) {
  NEEDS_NETWORK();
  PersonNetwork network(random_network(1, 6));
  Image broken(64, 48, 3, 0.3F);
  for (int i = 0; i < 64 * 48 * 3; i += 7) broken.data[i] = i % 2 == 0 ? kNan : -INFINITY;
  for (int i = 3; i < 64 * 48 * 3; i += 7) broken.data[i] = INFINITY;
  const std::vector<Image> pictures = {Image(1, 1, 3, 0.5F),
                                       Image(50, 20, 3, 0.5F),
                                       Image(2000, 3, 3, 0.5F),
                                       Image(64, 48, 1, 0.5F),
                                       Image(64, 48, 3, 0),
                                       Image(64, 48, 3, kNan),
                                       broken};
  for (const Image& picture : pictures) {
    const Face face{picture.width * 0.4, picture.height * 0.4, picture.width * 0.2, picture.height * 0.2};
    const Image mask = person_mask(picture, {face}, network);
    EXPECT_EQ(std::max(mask.width, mask.height), 256);
    EXPECT_GE(std::min(mask.width, mask.height), 1);
    for (const float value : mask.data) ASSERT_TRUE(value >= 0 && value <= 1);
  }
  // one channel is gray in three
  const Face face{30, 20, 8, 8};
  EXPECT_EQ(person_mask(Image(64, 48, 1, 0.5F), {face}, network).data,
            person_mask(Image(64, 48, 3, 0.5F), {face}, network).data);
  for (const Face outside : {Face{-20, 10, 10, 10}, Face{10, 60, 10, 10}, Face{kNan, 0, 1, 1}}) {
    EXPECT_NE(error_of([&] { person_mask(Image(64, 48, 3), {outside}, network); }), "");
  }
}

/// Whether a box holds the brows, eyes and mouth of draw_face, and nothing beyond its head. Each side lies within 0.15
/// of the box's own size: three standard deviations of what sides of held-out drawn people's faces are off, 0.04 to
/// 0.06 (docs/segmentation.md).
void expect_on_drawn_face(const Face& face, double center_x, double center_y, double size_px) {
  const double left = (face.x - center_x) / size_px, right = (face.x + face.width - center_x) / size_px;
  const double top = (face.y - center_y) / size_px, bottom = (face.y + face.height - center_y) / size_px;
  const double step_x = 0.15 * (right - left), step_y = 0.15 * (bottom - top);
  EXPECT_TRUE(left > -0.62 - step_x && left < -0.21 + step_x) << left;
  EXPECT_TRUE(right < 0.62 + step_x && right > 0.21 - step_x) << right;
  EXPECT_TRUE(top > -0.90 - step_y && top < -0.25 + step_y) << top;
  EXPECT_TRUE(bottom < 0.66 + step_y && bottom > 0.33 - step_y) << bottom;
}

TEST(SlowFaces, AreFoundWhereTheyAreLargestFirst) {
  NEEDS_NETWORK();
  Image picture(1280, 960, 3, 0.2F);
  draw_face(picture, 900, 480, 200);
  draw_face(picture, 400, 440, 320);
  const std::vector<Face> faces = find_faces(picture);
  ASSERT_EQ(faces.size(), 2U);
  EXPECT_GT(faces[0].area(), faces[1].area());
  expect_on_drawn_face(faces[0], 400, 440, 320);
  expect_on_drawn_face(faces[1], 900, 480, 200);
  // widths of held-out drawn people's frontal faces deviate by 0.06: two standard deviations of a ratio
  EXPECT_NEAR(std::log(faces[0].width / faces[1].width), std::log(1.6), 2 * std::sqrt(2) * 0.06);
}

TEST(Faces, SmallOnesAreFound) {
  NEEDS_NETWORK();
  Image picture(640, 480, 3, 0.2F);
  draw_face(picture, 320, 240, 60);
  const std::vector<Face> faces = find_faces(picture);
  ASSERT_EQ(faces.size(), 1U);
  expect_on_drawn_face(faces[0], 320, 240, 60);
}

TEST(FaceMap, IsReadAsItIsWritten) {
  constexpr int kCells = 8, kPlane = kCells * kCells;
  std::vector<float> map(std::size_t{4} * kPlane, 0);
  std::fill_n(map.begin(), kPlane, -9.F);
  const auto set = [&](int x, int y, float score, float dx, float dy, float size) {
    for (const auto& [plane, value] : {std::pair{0, score}, {1, dx}, {2, dy}, {3, size}}) {
      map[plane * kPlane + y * kCells + x] = value;
    }
  };
  set(2, 5, 2, 0.25F, -0.5F, -2);  // cell (2, 5): its center is at (10, 22); 8 px
  set(3, 5, 1, 0.25F, -0.5F, -2);  // beside a better one
  set(6, 1, 0, 0, 0, -1);          // a score of 1/2; center (26, 6), 16 px
  const std::vector<ScoredFace> faces = faces_of_map(map.data(), kCells, 0.4);
  ASSERT_EQ(faces.size(), 2U);
  EXPECT_NEAR(faces[0].score, 1 / (1 + std::exp(-2.0)), 1e-9);
  EXPECT_NEAR(faces[0].face.x, 10 + 0.25 * 8 - 4, 1e-6);
  EXPECT_NEAR(faces[0].face.y, 22 - 0.5 * 8 - 4, 1e-6);
  EXPECT_NEAR(faces[0].face.width, 8, 1e-6);
  EXPECT_NEAR(faces[1].face.x, 26 - 8, 1e-6);
  EXPECT_NEAR(faces[1].face.height, 16, 1e-6);
  EXPECT_EQ(faces_of_map(map.data(), kCells, 0.6).size(), 1U);
  // of two that overlap by more than .3, the better is kept
  set(7, 1, -0.1F, 0, 0, -1);
  set(6, 1, -9, 0, 0, -1);
  set(5, 1, 0, 0.125F, 0, -1);                                  // center (24, 6); the other's at (30, 6): 10/22
  EXPECT_EQ(faces_of_map(map.data(), kCells, 0.4).size(), 2U);  // and that at (2, 5)
  EXPECT_NEAR(overlap({0, 0, 16, 16}, {6, 0, 16, 16}), 10.0 / 22, 1e-12);
  EXPECT_EQ(overlap({0, 0, 16, 16}, {16, 0, 16, 16}), 0);
}

TEST(FaceWeights, AreNotThePersonNetworks) {
  EXPECT_NE(error_of([] { parse_weights(as_safetensors(random_network(1, 1)), "x", NetworkKind::faces); }), "");
}

TEST(SlowFaces, NoneWhereThereIsNone) {
  NEEDS_NETWORK();
  std::mt19937 random(1);
  Image noise(320, 240, 3);
  for (float& value : noise.data) value = static_cast<float>(random() % 1000) / 1000;
  for (const Image& picture : {Image(1, 1, 3, 0.5F), Image(50, 20, 3, 0.5F), Image(64, 48, 3, kNan), noise}) {
    EXPECT_TRUE(find_faces(picture).empty());
  }
}

TEST(SlowFaces, TwentyAndHalfOnes) {
  NEEDS_NETWORK();
  Image crowd(640, 640, 1, 0.2F);  // drawn heads of 131 px, apart from each other: the network misses those that touch
  for (int i = 0; i < 20; ++i) {
    const int column = i % 5, row = i / 5;
    draw_face(crowd, 64 + 128 * column, 80 + 160 * row, 84);
  }
  EXPECT_EQ(find_faces(crowd).size(), 20U);
  PersonNetwork network(face_follower());
  const FoundPeople found = find_people(crowd, {}, network);
  EXPECT_EQ(found.faces.size(), 20U);
  for (const Face& face : found.faces) {  // each face's run is in the mask
    const int x = static_cast<int>((face.x + face.width / 2) * found.mask.width / crowd.width);
    const int y = static_cast<int>((face.y + face.height / 2) * found.mask.height / crowd.height);
    EXPECT_GT(found.mask.at(x, y), 0.5F);
  }
  for (const double x : {0.0, 600.0}) {  // cut by the border: found or not, but never beyond use
    Image picture(640, 480, 1, 0.2F);
    draw_face(picture, x, 240, 160);
    for (const Face& face : find_faces(picture)) {
      EXPECT_TRUE(face.width > 0 && face.height > 0);
      EXPECT_NEAR(face.x + face.width / 2, x, 40);
    }
  }
}

TEST(FindPeople, GivenFacesWin) {
  NEEDS_NETWORK();
  PersonNetwork network(face_follower());
  const Image picture(320, 240, 3, 0.2F);
  const Face small{100, 100, 4, 4};  // far under 0.93 % of the picture
  const FoundPeople found = find_people(picture, {small}, network);
  ASSERT_EQ(found.faces.size(), 1U);
  EXPECT_EQ(found.faces[0].x, 100);
  EXPECT_EQ(found.mask.data, person_mask(picture, {small}, network).data);
}

TEST(FindPeople, SaysWhetherAnybodyIsSeen) {
  NEEDS_NETWORK();
  const auto seen = [](float bias) {
    NetworkWeights weights = face_follower();
    weights.layers["mask0.sub_pixels"].bias.assign(4, bias);
    PersonNetwork network(weights);
    return anybody_seen(find_people(Image(320, 240, 3, 0.2F), {{100, 100, 40, 40}}, network));
  };
  // the toy's logits reach 16 and the bias
  EXPECT_TRUE(seen(-15));
  EXPECT_FALSE(seen(-17));
  EXPECT_FALSE(anybody_seen({}));
}

// The network sees a person wherever it is told that a face is: what is tapped must be shown by a face that was found.
TEST(FindPeople, ATapFindsThoseWhoseFaceOrMaskCoversIt) {
  NEEDS_NETWORK();
  PersonNetwork network(face_follower());
  Image picture(640, 480, 3, 0.2F);
  draw_face(picture, 150, 150, 120);
  draw_face(picture, 500, 150, 120);
  const auto at = [&](double x, double y) { return find_people_at(picture, {x - 20, y - 20, 40, 40}, network); };
  ASSERT_EQ(at(150, 150).faces.size(), 1U);
  EXPECT_NEAR(at(150, 150).faces[0].x + at(150, 150).faces[0].width / 2, 150, 20);
  ASSERT_EQ(at(500, 150).faces.size(), 1U);
  EXPECT_NEAR(at(500, 150).faces[0].x + at(500, 150).faces[0].width / 2, 500, 20);
  EXPECT_TRUE(anybody_seen(at(500, 150)));
  const FoundPeople wall = at(325, 420);
  EXPECT_TRUE(wall.faces.empty());
  EXPECT_TRUE(wall.detected.empty());
  EXPECT_FALSE(anybody_seen(wall));
  EXPECT_TRUE(anybody_seen(find_people(picture, {{305, 400, 40, 40}}, network)));  // as a face given there still is
}

TEST(FindPeople, FindsWhoIsThereAndLeavesBystandersOut) {
  NEEDS_NETWORK();
  PersonNetwork network(face_follower());
  Image picture(640, 480, 3, 0.2F);
  EXPECT_TRUE(find_people(picture, {}, network).faces.empty());
  EXPECT_TRUE(find_people(picture, {}, network).mask.empty());
  draw_face(picture, 200, 220, 200);
  draw_face(picture, 480, 240, 90);  // a fifth of its area
  ASSERT_EQ(find_faces(picture).size(), 2U);
  const FoundPeople found = find_people(picture, {}, network);
  ASSERT_EQ(found.faces.size(), 1U);
  EXPECT_NEAR(found.faces[0].x + found.faces[0].width / 2, 200, 16);
  EXPECT_GT(found.mask.at(80, 85), 0.9F);
  EXPECT_LT(found.mask.at(192, 96), 0.1F);
}

}  // namespace
}  // namespace dualpixel::pipeline
