#include "pipeline/segmentation/weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"

namespace dualpixel::pipeline {
namespace {

using nlohmann::json;

constexpr std::size_t kLongestHeader = 1 << 20, kLargestFile = std::size_t{256} << 20;
constexpr int kMostChannels = 1024, kMostStages = 3, kUnetLevels = 4;

struct Tensor {
  std::vector<int> shape;
  std::vector<float> values;
};

[[noreturn]] void fail(const std::string& file, const std::string& why) {
  throw InputError(printable(file) + ": " + why);
}

/// IEEE 754 half precision; infinities become NaN.
float float_from_half(std::uint16_t half) {
  if ((half & 0x7c00) == 0x7c00) return NAN;
  const std::uint32_t shifted = static_cast<std::uint32_t>(half & 0x7fff) << 13;
  float magnitude = 0;  // its exponent is biased by 15 in place of 127
  std::memcpy(&magnitude, &shifted, 4);
  return (half & 0x8000) != 0 ? -magnitude * 0x1p112F : magnitude * 0x1p112F;
}

std::string text_of(const std::vector<int>& shape) {
  std::string text;
  for (const int size : shape) text += (text.empty() ? "" : " x ") + std::to_string(size);
  return text;
}

std::vector<float> decode(std::string_view bytes, bool half) {
  std::vector<float> values(bytes.size() / (half ? 2 : 4));
  if (half) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::uint16_t bits = 0;
      std::memcpy(&bits, bytes.data() + 2 * i, 2);
      values[i] = float_from_half(bits);
    }
  } else {
    std::memcpy(values.data(), bytes.data(), 4 * values.size());
  }
  return values;
}

std::map<std::string, Tensor> parse_tensors(std::string_view bytes, const std::string& file) {
  std::uint64_t header_bytes = 0;
  if (bytes.size() < sizeof header_bytes) fail(file, "is not a safetensors file: shorter than 8 bytes");
  std::memcpy(&header_bytes, bytes.data(), sizeof header_bytes);
  bytes.remove_prefix(sizeof header_bytes);
  if (header_bytes > std::min(bytes.size(), kLongestHeader)) {
    fail(file, fmt::format("a header of {} bytes: must fit in the file and in {} bytes", header_bytes, kLongestHeader));
  }
  const json header = parse_json(std::string(bytes.substr(0, header_bytes)), file);
  const std::string_view data = bytes.substr(header_bytes);
  if (!header.is_object()) fail(file, "its header must be a JSON object");

  std::map<std::string, Tensor> tensors;
  std::map<std::size_t, std::size_t> ranges;  // end of the bytes that begin there
  for (const auto& [name, entry] : header.items()) {
    if (name == "__metadata__") continue;
    Fields fields(entry, file, "/" + name);
    std::string type;
    double ends[2] = {};
    std::vector<double> shape;
    fields.required("dtype").choice("dtype", type, {"F16", "F32"});
    fields.required("shape").list("shape", shape, 1, kMostChannels, 4);
    fields.required("data_offsets").numbers("data_offsets", ends, 2);
    fields.done();
    std::size_t count = 1;  // at most 2^40: no overflow
    Tensor tensor;
    for (const double size : shape) {
      if (size != std::floor(size)) fields.fail("shape", "must be whole numbers");
      tensor.shape.push_back(static_cast<int>(size));
      count *= tensor.shape.back();
    }
    const std::size_t wanted = count * (type == "F16" ? 2 : 4);
    if (!(ends[0] >= 0 && ends[0] == std::floor(ends[0]) && ends[1] <= static_cast<double>(data.size()) &&
          ends[1] - ends[0] == static_cast<double>(wanted))) {
      fields.fail("data_offsets", fmt::format("[{}, {}]: must span {} bytes of the {} that follow the header", ends[0],
                                              ends[1], wanted, data.size()));
    }
    const auto begin = static_cast<std::size_t>(ends[0]);
    if (!ranges.emplace(begin, begin + wanted).second) fields.fail("data_offsets", "overlap another tensor's");
    tensor.values = decode(data.substr(begin, wanted), type == "F16");
    const auto bad =
        std::find_if_not(tensor.values.begin(), tensor.values.end(), [](float v) { return std::isfinite(v); });
    if (bad != tensor.values.end()) {
      fail(file, fmt::format("tensor {}: value {} is not finite", printable(name), bad - tensor.values.begin()));
    }
    tensors.emplace(name, std::move(tensor));
  }
  std::size_t covered = 0;
  for (const auto& [begin, end] : ranges) {
    if (begin != covered) fail(file, fmt::format("its tensors overlap or leave a gap at byte {} of the data", covered));
    covered = end;
  }
  if (covered != data.size()) fail(file, fmt::format("{} bytes follow the last tensor", data.size() - covered));
  return tensors;
}

struct ConvolutionLayer {
  std::string name;
  int out, in, kernel;
};

std::vector<ConvolutionLayer> layers_of(const NetworkWeights& weights, NetworkKind kind) {
  const int fine = weights.fine_channels;
  const std::vector<int>& c = weights.unet_channels;
  std::vector<ConvolutionLayer> layers = {{"stem_half", fine, kind == NetworkKind::faces ? 3 : 4, 3},
                                          {"stem_fine", fine, fine, 3},
                                          {"stem_quarter", c[0], fine, 3}};
  for (int s = 0; s < weights.stages; ++s) {
    for (int level = 0; level < kUnetLevels; ++level) {
      const auto name = [&](const char* part) { return fmt::format("stage{}.{}{}", s, part, level); };
      if (level > 0) layers.push_back({name("down"), c[level], c[level - 1], 3});
      layers.push_back({name("across"), c[level], c[level], 3});
      if (level + 1 == kUnetLevels) break;
      layers.push_back({name("lateral"), c[level], c[level + 1], 1});
      layers.push_back({name("up"), c[level], c[level], 3});
    }
    if (s + 1 < weights.stages) layers.push_back({fmt::format("between{}", s), c[0], c[0], 1});
  }
  if (kind == NetworkKind::faces) {
    layers.push_back({"face_map", 4, c[0], 3});
    return layers;
  }
  const std::string mask = fmt::format("mask{}.", weights.stages - 1);
  layers.push_back({mask + "coarse", fine, c[0], 1});
  layers.push_back({mask + "mix", fine, fine, 3});
  layers.push_back({mask + "sub_pixels", 4, fine, 3});
  return layers;
}

}  // namespace

NetworkWeights parse_weights(std::string_view bytes, const std::string& file, NetworkKind kind) {
  const char* const network = kind == NetworkKind::faces ? "face network" : "person network";
  const int most_stages = kind == NetworkKind::faces ? 1 : kMostStages;
  std::map<std::string, Tensor> tensors = parse_tensors(bytes, file);
  // Widths are the first dimension of some layers; all others must agree.
  const auto width_of = [&](const std::string& layer) {
    const auto found = tensors.find(layer + ".weight");
    if (found == tensors.end() || found->second.shape.size() != 4) {
      fail(file, fmt::format("tensor {}.weight: must be there, with four dimensions", layer));
    }
    return found->second.shape[0];
  };
  NetworkWeights weights;
  while (weights.stages < most_stages && tensors.count(fmt::format("stage{}.across0.weight", weights.stages)) != 0) {
    ++weights.stages;
  }
  if (weights.stages == 0) fail(file, fmt::format("holds no stage of a {}", network));
  weights.fine_channels = width_of("stem_half");
  for (int level = 0; level < kUnetLevels; ++level) {
    weights.unet_channels.push_back(width_of(fmt::format("stage0.across{}", level)));
  }

  for (const ConvolutionLayer& layer : layers_of(weights, kind)) {
    const auto take = [&](const std::string& part, const std::vector<int>& shape) {
      const auto found = tensors.find(layer.name + part);
      if (found == tensors.end()) fail(file, fmt::format("tensor {}{}: is missing", layer.name, part));
      if (found->second.shape != shape) {
        fail(file, fmt::format("tensor {}{}: shape {}: must be {}", layer.name, part, text_of(found->second.shape),
                               text_of(shape)));
      }
      std::vector<float> values = std::move(found->second.values);
      tensors.erase(found);
      return values;
    };
    ConvWeights conv{layer.out, layer.in, layer.kernel, {}, {}};
    conv.weight = take(".weight", {layer.out, layer.in, layer.kernel, layer.kernel});
    conv.bias = take(".bias", {layer.out});
    weights.layers.emplace(layer.name, std::move(conv));
  }
  if (!tensors.empty())
    fail(file, fmt::format("tensor {}: is not a part of a {}", printable(tensors.begin()->first), network));
  weights.file = file;
  weights.file_hash = hash_of(bytes);
  return weights;
}

NetworkWeights read_weights(const std::string& path, NetworkKind kind) {
  return parse_weights(read_file(path, kLargestFile), path, kind);
}

}  // namespace dualpixel::pipeline
