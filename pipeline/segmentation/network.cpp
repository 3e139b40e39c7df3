#include "pipeline/segmentation/network.h"

#include "capture/error.h"

#ifdef DUALPIXEL_ONEDNN
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <oneapi/dnnl/dnnl.hpp>
#include <string>
#include <unordered_map>
#include <utility>

// oneDNN's OpenMP is GCC's, whichever compiler this is.
extern "C" {
int omp_get_max_threads();
void omp_set_num_threads(int threads);
}

namespace dualpixel::pipeline {
namespace {

using dnnl::memory;

// ---- what differs between oneDNN 2 and 3 ----

#if DNNL_VERSION_MAJOR >= 3

void append_relu(dnnl::post_ops& ops) { ops.append_eltwise(dnnl::algorithm::eltwise_relu, 0, 0); }

memory::dims dims_of(const memory& m) { return m.get_desc().get_dims(); }

template <typename Primitive, typename... Arguments>
typename Primitive::primitive_desc describe(const dnnl::engine& engine, const dnnl::primitive_attr& attributes,
                                            const Arguments&... arguments) {
  return {engine, dnnl::prop_kind::forward_inference, arguments..., attributes};
}

#else

void append_relu(dnnl::post_ops& ops) { ops.append_eltwise(1, dnnl::algorithm::eltwise_relu, 0, 0); }

memory::dims dims_of(const memory& m) { return m.get_desc().dims(); }

template <typename Primitive, typename... Arguments>
typename Primitive::primitive_desc describe(const dnnl::engine& engine, const dnnl::primitive_attr& attributes,
                                            const Arguments&... arguments) {
  return {typename Primitive::desc(dnnl::prop_kind::forward_inference, arguments...), attributes, engine};
}

#endif

// ---- the network ----

/// How a precision's channels lie in memory: for AVX2 eight together, missing ones 0; for AMX all of a pixel's.
struct Layout {
  memory::data_type type;
  memory::format_tag format;
  int logits_stride;  ///< values from pixel to pixel, of four channels
};
Layout layout_of(Precision precision) {
  if (precision == Precision::bf16) return {memory::data_type::bf16, memory::format_tag::nhwc, 4};
  return {memory::data_type::f32, memory::format_tag::nChw8c, 8};
}

/// oneDNN asks OpenMP how many threads to take.
class OpenMpThreads {
 public:
  explicit OpenMpThreads(int threads) : before_(omp_get_max_threads()) { omp_set_num_threads(threads); }
  ~OpenMpThreads() { omp_set_num_threads(before_); }
  OpenMpThreads(const OpenMpThreads&) = delete;
  OpenMpThreads& operator=(const OpenMpThreads&) = delete;

 private:
  int before_;
};

enum class Then { nothing, relu, add_relu };  ///< add: onto what the destination holds

dnnl::primitive_attr attributes(Then then) {
  dnnl::post_ops ops;
  if (then == Then::add_relu) ops.append_sum(1);
  if (then != Then::nothing) append_relu(ops);
  dnnl::primitive_attr attr;
  attr.set_post_ops(ops);
  return attr;
}

int side_of(const memory& m) { return static_cast<int>(dims_of(m)[2]); }

}  // namespace

struct PersonNetwork::Layers {
  Layers(const NetworkWeights& weights, int threads_, Precision precision)
      : threads(threads_),
        file(weights.file),
        layout(layout_of(precision)),
        engine(dnnl::engine::kind::cpu, 0),
        stream(engine) {
    const auto layer = [&](const std::string& name) -> const ConvWeights& { return weights.layers.at(name); };
    input =
        memory({{1, 4, kNetworkSize_px, kNetworkSize_px}, memory::data_type::f32, memory::format_tag::nchw}, engine);
    const memory fine = convolve(convolve(picture(), layer("stem_half"), 2), layer("stem_fine"));
    const memory x = convolve(fine, layer("stem_quarter"), 2);
    memory y;
    for (int s = 0; s < weights.stages; ++s) {
      const auto part = [&](const char* name, std::size_t level) -> const ConvWeights& {
        return layer(fmt::format("stage{}.{}{}", s, name, level));
      };
      std::vector<memory> skips = {convolve(x, part("across", 0))};
      for (std::size_t level = 1; level < weights.unet_channels.size(); ++level) {
        skips.push_back(convolve(convolve(skips.back(), part("down", level), 2), part("across", level)));
      }
      y = skips.back();
      for (std::size_t level = skips.size() - 1; level-- > 0;) {
        add_twice_as_large(convolve(y, part("lateral", level), 1, Then::nothing), skips[level]);
        y = convolve(skips[level], part("up", level));
      }
      if (s + 1 < weights.stages) convolve_onto(y, layer(fmt::format("between{}", s)), 1, Then::add_relu, x);
    }
    const std::string mask = fmt::format("mask{}.", weights.stages - 1);
    add_twice_as_large(convolve(y, layer(mask + "coarse"), 1, Then::nothing), fine);
    const ConvWeights& last = layer(mask + "sub_pixels");
    constexpr int kHalf = kNetworkSize_px / 2;
    sub_pixels = memory({{1, last.out, kHalf, kHalf}, memory::data_type::f32, layout.format}, engine);
    convolve_onto(convolve(fine, layer(mask + "mix")), last, 1, Then::nothing, sub_pixels);
  }

  /// The input as the first layer takes it.
  memory picture() {
    if (layout.type == memory::data_type::f32) return input;
    memory converted({dims_of(input), layout.type, layout.format}, engine);
    steps.emplace_back(dnnl::reorder(input, converted),
                       std::unordered_map<int, memory>{{DNNL_ARG_FROM, input}, {DNNL_ARG_TO, converted}});
    return converted;
  }

  memory convolve(const memory& source, const ConvWeights& conv, int stride = 1, Then then = Then::relu) {
    const int side = side_of(source) / stride;
    memory destination({{1, conv.out, side, side}, layout.type, layout.format}, engine);
    convolve_onto(source, conv, stride, then, destination);
    return destination;
  }

  void convolve_onto(const memory& source, const ConvWeights& conv, int stride, Then then, const memory& destination) {
    const memory::dims shape = {conv.out, conv.in, conv.kernel, conv.kernel};
    const memory::dim before = conv.kernel / 2, after = stride == 1 ? before : before - (stride - 1);
    const memory::dims strides = {stride, stride}, padding_before = {before, before}, padding_after = {after, after};
    const auto primitive = describe<dnnl::convolution_forward>(
        engine, attributes(then), dnnl::algorithm::convolution_direct, source.get_desc(),
        memory::desc(shape, layout.type, memory::format_tag::any),
        memory::desc({conv.out}, memory::data_type::f32, memory::format_tag::x), destination.get_desc(), strides,
        padding_before, padding_after);
    steps.emplace_back(
        dnnl::convolution_forward(primitive),
        std::unordered_map<int, memory>{
            {DNNL_ARG_SRC, source},
            {DNNL_ARG_WEIGHTS, copy_of(conv.weight, shape, memory::format_tag::oihw, primitive.weights_desc())},
            {DNNL_ARG_BIAS, copy_of(conv.bias, {conv.out}, memory::format_tag::x, primitive.bias_desc())},
            {DNNL_ARG_DST, destination}});
  }

  void add_twice_as_large(const memory& source, const memory& destination) {
    const auto primitive =
        describe<dnnl::resampling_forward>(engine, attributes(Then::add_relu), dnnl::algorithm::resampling_nearest,
                                           source.get_desc(), destination.get_desc());
    steps.emplace_back(dnnl::resampling_forward(primitive),
                       std::unordered_map<int, memory>{{DNNL_ARG_SRC, source}, {DNNL_ARG_DST, destination}});
  }

  memory copy_of(const std::vector<float>& values, const memory::dims& shape, memory::format_tag format,
                 const memory::desc& wanted) {
    memory plain({shape, memory::data_type::f32, format}, engine);
    std::memcpy(plain.get_data_handle(), values.data(), values.size() * sizeof(float));
    memory copy(wanted, engine);
    dnnl::reorder(plain, copy).execute(stream, plain, copy);
    stream.wait();
    return copy;
  }

  int threads;
  std::string file;  ///< the weights'
  Layout layout;
  dnnl::engine engine;
  dnnl::stream stream;
  memory input, sub_pixels;
  std::vector<std::pair<dnnl::primitive, std::unordered_map<int, memory>>> steps;
};

bool has_person_network() { return true; }

PersonNetwork::PersonNetwork(const NetworkWeights& weights, int threads, Precision precision) {
  static std::atomic<bool> has_run_bf16{false};
  if (precision == Precision::f32) {
    if (has_run_bf16) throw InputError("person network: f32 cannot follow bf16 in one process");
    // Refused once a primitive has run, which then was one of f32's, or the caller's own choice.
    dnnl::set_max_cpu_isa(dnnl::cpu_isa::avx2);
  }
  const OpenMpThreads limit(threads);
  try {
    layers_ = std::make_unique<Layers>(weights, threads, precision);
  } catch (const dnnl::error& error) {
    if (precision == Precision::f32 || error.status != dnnl_unimplemented) throw;
    throw InputError(
        "person network: bf16 needs a processor with AVX-512, and a process that has built no network in f32; leave it "
        "out (--bf16)");
  }
  if (precision == Precision::bf16) has_run_bf16 = true;
}

PersonNetwork::~PersonNetwork() = default;
PersonNetwork::PersonNetwork(PersonNetwork&&) noexcept = default;
PersonNetwork& PersonNetwork::operator=(PersonNetwork&&) noexcept = default;

Image PersonNetwork::operator()(const Image& input) {
  if (input.width != kNetworkSize_px || input.height != kNetworkSize_px || input.channels != 4) {
    throw InputError(fmt::format("person network: an input of {} x {} x {}: must be {} x {} x 4", input.width,
                                 input.height, input.channels, kNetworkSize_px, kNetworkSize_px));
  }
  const OpenMpThreads limit(layers_->threads);
  auto* const planes = static_cast<float*>(layers_->input.get_data_handle());
  for (std::size_t i = 0; i < input.data.size(); ++i) planes[i % 4 * input.pixel_count() + i / 4] = input.data[i];
  for (const auto& [primitive, arguments] : layers_->steps) primitive.execute(layers_->stream, arguments);
  layers_->stream.wait();

  constexpr int kHalf = kNetworkSize_px / 2;
  const auto* logits = static_cast<const float*>(layers_->sub_pixels.get_data_handle());
  Image mask(kNetworkSize_px, kNetworkSize_px);
  for (int y = 0; y < kNetworkSize_px; ++y) {
    for (int x = 0; x < kNetworkSize_px; ++x) {
      const float logit = logits[(y / 2 * kHalf + x / 2) * layers_->layout.logits_stride + 2 * (y % 2) + x % 2];
      if (!std::isfinite(logit))
        throw InputError(printable(layers_->file) + ": its weights give results that are not finite");
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
