#include "pipeline/segmentation/network.h"

#include "capture/error.h"

#ifdef DUALPIXEL_ONEDNN
#include <fmt/format.h>

#include <cmath>
#include <string>

#include "pipeline/segmentation/onednn_graph.h"

namespace dualpixel::pipeline {

struct PersonNetwork::Layers {
  Layers(const NetworkWeights& weights, int threads, Precision precision)
      : graph(weights, 4, kNetworkSize_px, threads, precision) {
    using Then = OnednnGraph::Then;
    const dnnl::memory fine = graph.convolve(graph.convolve(graph.picture(), "stem_half", 2), "stem_fine");
    const dnnl::memory x = graph.convolve(fine, "stem_quarter", 2);
    dnnl::memory y;
    for (int s = 0; s < weights.stages; ++s) {
      y = graph.stage(s, x);
      if (s + 1 < weights.stages) graph.convolve_onto(y, fmt::format("between{}", s), 1, Then::add_relu, x);
    }
    const std::string mask = fmt::format("mask{}.", weights.stages - 1);
    graph.add_twice_as_large(graph.convolve(y, mask + "coarse", 1, Then::nothing), fine);
    graph.last(graph.convolve(fine, mask + "mix"), mask + "sub_pixels");
  }

  OnednnGraph graph;
};

bool has_person_network() { return true; }

PersonNetwork::PersonNetwork(const NetworkWeights& weights, int threads, Precision precision) {
  if (precision == Precision::f32) claim_precision(precision);
  try {
    layers_ = std::make_unique<Layers>(weights, threads, precision);
  } catch (const dnnl::error& error) {
    if (precision == Precision::f32 || error.status != dnnl_unimplemented) throw;
    throw InputError(
        "person network: bf16 needs a processor with AVX-512, and a process that has built no network in f32; leave it "
        "out (--bf16)");
  }
  if (precision == Precision::bf16) claim_precision(precision);
}

PersonNetwork::~PersonNetwork() = default;
PersonNetwork::PersonNetwork(PersonNetwork&&) noexcept = default;
PersonNetwork& PersonNetwork::operator=(PersonNetwork&&) noexcept = default;

Image PersonNetwork::operator()(const Image& input) {
  if (input.width != kNetworkSize_px || input.height != kNetworkSize_px || input.channels != 4) {
    throw InputError(fmt::format("person network: an input of {} x {} x {}: must be {} x {} x 4", input.width,
                                 input.height, input.channels, kNetworkSize_px, kNetworkSize_px));
  }
  OnednnGraph& graph = layers_->graph;
  for (std::size_t i = 0; i < input.data.size(); ++i)
    graph.input()[i % 4 * input.pixel_count() + i / 4] = input.data[i];
  graph.run();
  constexpr int kHalf = kNetworkSize_px / 2;
  Image mask(kNetworkSize_px, kNetworkSize_px);
  for (int y = 0; y < kNetworkSize_px; ++y) {
    for (int x = 0; x < kNetworkSize_px; ++x) {
      const float logit = graph.result(y / 2 * kHalf + x / 2, 2 * (y % 2) + x % 2);
      mask.at(x, y) = 1 / (1 + std::exp(-logit));
    }
  }
  return mask;
}

}  // namespace dualpixel::pipeline

#else

namespace dualpixel::pipeline {

struct PersonNetwork::Layers {};

bool has_person_network() { return false; }

PersonNetwork::PersonNetwork(const NetworkWeights&, int, Precision) {
  throw InputError("person network: this build has no oneDNN; give a mask, or install libdnnl-dev and build again");
}
PersonNetwork::~PersonNetwork() = default;
PersonNetwork::PersonNetwork(PersonNetwork&&) noexcept = default;
PersonNetwork& PersonNetwork::operator=(PersonNetwork&&) noexcept = default;
Image PersonNetwork::operator()(const Image&) { return {}; }

}  // namespace dualpixel::pipeline

#endif
