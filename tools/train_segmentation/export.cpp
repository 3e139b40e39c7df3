#include "tools/train_segmentation/export.h"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

namespace dualpixel::tools {
namespace {

FoldedConv folded(const std::string& name, const Conv& layer) {
  const torch::NoGradGuard no_gradients;
  const torch::nn::BatchNorm2d& norm = layer->norm;
  const torch::Tensor gain = norm->weight / (norm->running_var + norm->options.eps()).sqrt();
  return {name, layer->conv->weight * gain.view({-1, 1, 1, 1}), norm->bias - norm->running_mean * gain};
}

}  // namespace

std::vector<FoldedConv> folded_layers(Network& network) {
  const std::string last_mask = "mask" + std::to_string(network->shape.stages - 1);
  std::vector<FoldedConv> layers;
  for (const auto& item : network->named_modules("", false)) {
    const std::string& name = item.key();
    if (name.rfind("mask", 0) == 0 && name.rfind(last_mask, 0) != 0) continue;
    if (const auto conv = std::dynamic_pointer_cast<ConvImpl>(item.value())) layers.push_back(folded(name, Conv(conv)));
  }
  if (network->shape.faces) {
    layers.push_back({"face_map", network->face_head->weight.detach(), network->face_head->bias.detach()});
    return layers;
  }
  const torch::nn::Conv2d& sub_pixels = network->mask_heads.back()->sub_pixels;
  layers.push_back({last_mask + ".sub_pixels", sub_pixels->weight.detach(), sub_pixels->bias.detach()});
  return layers;
}

std::string safetensors(const std::vector<FoldedConv>& layers) {
  const char* const format =
      layers.back().name == "face_map" ? "dualpixel face network 1" : "dualpixel person network 1";
  nlohmann::ordered_json header = {{"__metadata__", {{"format", format}}}};
  std::string data;
  const auto add = [&](const std::string& name, const torch::Tensor& tensor) {
    const torch::Tensor half = tensor.cpu().to(torch::kHalf).contiguous();
    const std::size_t start = data.size();
    data.append(static_cast<const char*>(half.data_ptr()), half.numel() * 2);
    header[name] = {{"dtype", "F16"}, {"shape", half.sizes().vec()}, {"data_offsets", {start, data.size()}}};
  };
  for (const FoldedConv& layer : layers) {
    add(layer.name + ".weight", layer.weight);
    add(layer.name + ".bias", layer.bias);
  }
  std::string text = header.dump();
  text.resize((text.size() + 7) / 8 * 8, ' ');  // data start aligned, as the format asks
  const std::uint64_t length = text.size();     // little-endian, as is every processor that we build for
  std::string file(sizeof length, '\0');
  std::memcpy(file.data(), &length, sizeof length);
  return file + text + data;
}

}  // namespace dualpixel::tools
