#pragma once
#include <oneapi/dnnl/dnnl.hpp>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "pipeline/segmentation/precision.h"
#include "pipeline/segmentation/weights.h"

/// What the networks have in common, on oneDNN: layers that are set up once, with their memory, and then run in order.
namespace dualpixel::pipeline {

/// Makes oneDNN use what a precision may (Precision). Throws InputError where f32 follows bf16.
void claim_precision(Precision precision);

/// Whether a network has been built in bf16: then oneDNN cannot be limited any more.
bool has_run_bf16();

class OnednnGraph {
 public:
  enum class Then { nothing, relu, add_relu };  ///< add: onto what the destination holds

  /// The input: `channels` planes of side x side values. `weights` are needed while layers are added.
  OnednnGraph(const NetworkWeights& weights, int channels, int side, int threads, Precision precision);

  /// The input as the first layer takes it.
  dnnl::memory picture();
  dnnl::memory convolve(const dnnl::memory& source, const std::string& layer, int stride = 1, Then then = Then::relu);
  void convolve_onto(const dnnl::memory& source, const std::string& layer, int stride, Then then,
                     const dnnl::memory& destination);
  /// The source, each pixel as 2 x 2, and a ReLU.
  void add_twice_as_large(const dnnl::memory& source, const dnnl::memory& destination);
  /// Stage `s`, a U-Net (network.h).
  dnnl::memory stage(int s, const dnnl::memory& x);
  /// A layer's results in f32, whatever the precision: the network's.
  dnnl::memory last(const dnnl::memory& source, const std::string& layer);

  float* input() { return static_cast<float*>(input_.get_data_handle()); }
  void run();
  /// Value `channel` of pixel i of what last() returned. Throws InputError where it is not finite.
  float result(std::size_t i, int channel) const;

 private:
  /// How a precision's channels lie in memory: for AVX2 eight together, missing ones 0; for AMX all of a pixel's.
  struct Layout {
    dnnl::memory::data_type type;
    dnnl::memory::format_tag format;
    int multiple;  ///< a layer's channels are one of this; those beyond its own are 0
    int stride;    ///< values from pixel to pixel of last()
  };
  static Layout layout_of(Precision precision);
  /// For the results of a layer, or of last().
  dnnl::memory destination_of(const std::string& layer, int side, dnnl::memory::data_type type);
  dnnl::memory copy_of(const std::vector<float>& values, const dnnl::memory::dims& shape,
                       dnnl::memory::format_tag format, const dnnl::memory::desc& wanted);

  const NetworkWeights* weights_;
  int threads_;
  std::string file_;  ///< the weights'
  Layout layout_;
  dnnl::engine engine_;
  dnnl::stream stream_;
  dnnl::memory input_, last_;
  std::vector<std::pair<dnnl::primitive, std::unordered_map<int, dnnl::memory>>> steps_;
};

}  // namespace dualpixel::pipeline
