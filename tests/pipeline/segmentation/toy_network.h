#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/segmentation/weights.h"

namespace dualpixel::pipeline {

/// A person network of eight channels throughout, all its weights 0.
inline NetworkWeights empty_network(int stages) {
  NetworkWeights weights;
  weights.stages = stages;
  weights.fine_channels = 8;
  weights.unet_channels = {8, 8, 8, 8};
  const auto add = [&](const std::string& name, int out, int in, int kernel) {
    weights.layers[name] = {out, in, kernel, std::vector<float>(out * in * kernel * kernel), std::vector<float>(out)};
  };
  add("stem_half", 8, 4, 3);
  add("stem_fine", 8, 8, 3);
  add("stem_quarter", 8, 8, 3);
  for (int s = 0; s < stages; ++s) {
    for (int level = 0; level < 4; ++level) {
      const auto name = [&](const char* part) { return fmt::format("stage{}.{}{}", s, part, level); };
      if (level > 0) add(name("down"), 8, 8, 3);
      add(name("across"), 8, 8, 3);
      if (level == 3) break;
      add(name("lateral"), 8, 8, 1);
      add(name("up"), 8, 8, 3);
    }
    if (s + 1 < stages) add(fmt::format("between{}", s), 8, 8, 1);
  }
  const std::string mask = fmt::format("mask{}.", stages - 1);
  add(mask + "coarse", 8, 8, 1);
  add(mask + "mix", 8, 8, 3);
  add(mask + "sub_pixels", 4, 8, 3);
  return weights;
}

/// Weights that keep signals of about 1, all exact in half precision.
inline NetworkWeights random_network(int stages, unsigned seed) {
  NetworkWeights weights = empty_network(stages);
  std::mt19937 random(seed);
  for (auto& [name, conv] : weights.layers) {
    const double deviation = 1.4 / std::sqrt(conv.in * conv.kernel * conv.kernel);
    const auto draw = [&] { return static_cast<float>(std::lround(random() % 2001 * 0.512 - 512) * deviation / 256); };
    const auto to_half = [](float value) { return std::round(value * 1024) / 1024; };  // |value| < 2: 11 bits
    for (float& value : conv.weight) value = to_half(draw());
    for (float& value : conv.bias) value = to_half(0.2F * draw());
  }
  return weights;
}

/// A network whose mask is where the face is, and nothing else: sigmoid(16 gaussian - 8), of every other pixel twice.
inline NetworkWeights face_follower() {
  NetworkWeights weights = empty_network(1);
  const auto pass = [&](const std::string& layer, int out, int in, float gain) {
    weights.layers[layer].weight[(out * weights.layers[layer].in + in) * 9 + 4] = gain;  // the kernel's center
  };
  pass("stem_half", 0, 3, 1);
  pass("stem_fine", 0, 0, 1);
  pass("mask0.mix", 0, 0, 1);
  for (int sub_pixel = 0; sub_pixel < 4; ++sub_pixel) pass("mask0.sub_pixels", sub_pixel, 0, 16);
  weights.layers["mask0.sub_pixels"].bias.assign(4, -8);
  return weights;
}

/// A safetensors file: eight bytes of length, the header, the data.
inline std::string safetensors_file(const std::string& header, const std::string& data) {
  const std::uint64_t length = header.size();
  return std::string(reinterpret_cast<const char*>(&length), 8) + header + data;
}

/// `weights` as 32-bit floats. Each tensor's JSON goes through `edit(name, json)`.
template <typename Edit>
std::string as_safetensors(const NetworkWeights& weights, const Edit& edit) {
  std::string header, data;
  const auto add = [&](const std::string& name, const std::string& shape, const std::vector<float>& values) {
    const std::size_t begin = data.size();
    data.append(reinterpret_cast<const char*>(values.data()), 4 * values.size());
    header +=
        (header.empty() ? "{\"" : ",\"") + name + "\":" +
        edit(name, fmt::format(R"({{"dtype":"F32","shape":[{}],"data_offsets":[{},{}]}})", shape, begin, data.size()));
  };
  for (const auto& [name, conv] : weights.layers) {
    add(name + ".weight", fmt::format("{},{},{},{}", conv.out, conv.in, conv.kernel, conv.kernel), conv.weight);
    add(name + ".bias", fmt::format("{}", conv.out), conv.bias);
  }
  return safetensors_file(header + "}", data);
}

inline std::string as_safetensors(const NetworkWeights& weights) {
  return as_safetensors(weights, [](const std::string&, const std::string& json) { return json; });
}

}  // namespace dualpixel::pipeline
