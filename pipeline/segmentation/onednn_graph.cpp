#ifdef DUALPIXEL_ONEDNN
#include "pipeline/segmentation/onednn_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "capture/error.h"

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

dnnl::primitive_attr attributes(OnednnGraph::Then then) {
  dnnl::post_ops ops;
  if (then == OnednnGraph::Then::add_relu) ops.append_sum(1);
  if (then != OnednnGraph::Then::nothing) append_relu(ops);
  dnnl::primitive_attr attr;
  attr.set_post_ops(ops);
  return attr;
}

int side_of(const memory& m) { return static_cast<int>(dims_of(m)[2]); }

/// The weights of `conv`, with zeros up to `in` and `out` channels.
std::vector<float> with_channels(const ConvWeights& conv, memory::dim in, memory::dim out) {
  const std::size_t kernel = std::size_t{1} * conv.kernel * conv.kernel, row = conv.in * kernel;
  std::vector<float> weights(out * in * kernel);
  for (int o = 0; o < conv.out; ++o) {
    std::copy_n(conv.weight.begin() + o * row, row, weights.begin() + o * in * kernel);
  }
  return weights;
}

std::atomic<bool> has_claimed_bf16{false};

}  // namespace

bool has_run_bf16() { return has_claimed_bf16; }

void claim_precision(Precision precision) {
  if (precision == Precision::bf16) {
    has_claimed_bf16 = true;
    return;
  }
  if (has_claimed_bf16) throw InputError("person network: f32 cannot follow bf16 in one process");
  // Refused once a primitive has run, which then was one of f32's, or the caller's own choice.
  dnnl::set_max_cpu_isa(dnnl::cpu_isa::avx2);
}

OnednnGraph::Layout OnednnGraph::layout_of(Precision precision) {
  // oneDNN 3.7's bf16 convolutions for AVX-512 err by a third where output channels are no multiple of 16.
  if (precision == Precision::bf16) return {memory::data_type::bf16, memory::format_tag::nhwc, 16, 16};
  return {memory::data_type::f32, memory::format_tag::nChw8c, 1, 8};
}

OnednnGraph::OnednnGraph(const NetworkWeights& weights, int channels, int side, int threads, Precision precision)
    : weights_(&weights),
      threads_(threads),
      file_(weights.file),
      layout_(layout_of(precision)),
      engine_(dnnl::engine::kind::cpu, 0),
      stream_(engine_),
      input_({{1, channels, side, side}, memory::data_type::f32, memory::format_tag::nchw}, engine_) {}

memory OnednnGraph::picture() {
  if (layout_.type == memory::data_type::f32) return input_;
  memory converted({dims_of(input_), layout_.type, layout_.format}, engine_);
  const OpenMpThreads limit(threads_);
  steps_.emplace_back(dnnl::reorder(input_, converted),
                      std::unordered_map<int, memory>{{DNNL_ARG_FROM, input_}, {DNNL_ARG_TO, converted}});
  return converted;
}

memory OnednnGraph::destination_of(const std::string& layer, int side, memory::data_type type) {
  const int multiple = layout_.multiple;
  const int channels = (weights_->layers.at(layer).out + multiple - 1) / multiple * multiple;
  return memory({{1, channels, side, side}, type, layout_.format}, engine_);
}

memory OnednnGraph::convolve(const memory& source, const std::string& layer, int stride, Then then) {
  memory destination = destination_of(layer, side_of(source) / stride, layout_.type);
  convolve_onto(source, layer, stride, then, destination);
  return destination;
}

void OnednnGraph::convolve_onto(const memory& source, const std::string& layer, int stride, Then then,
                                const memory& destination) {
  const ConvWeights& conv = weights_->layers.at(layer);
  const memory::dim in = dims_of(source)[1], out = dims_of(destination)[1];
  const memory::dims shape = {out, in, conv.kernel, conv.kernel};
  const memory::dim before = conv.kernel / 2, after = stride == 1 ? before : before - (stride - 1);
  const memory::dims strides = {stride, stride}, padding_before = {before, before}, padding_after = {after, after};
  const OpenMpThreads limit(threads_);  // a primitive runs with as many threads as it was described for
  const auto primitive =
      describe<dnnl::convolution_forward>(engine_, attributes(then), dnnl::algorithm::convolution_direct,
                                          source.get_desc(), memory::desc(shape, layout_.type, memory::format_tag::any),
                                          memory::desc({out}, memory::data_type::f32, memory::format_tag::x),
                                          destination.get_desc(), strides, padding_before, padding_after);
  std::vector<float> bias = conv.bias;
  bias.resize(out);
  steps_.emplace_back(dnnl::convolution_forward(primitive),
                      std::unordered_map<int, memory>{
                          {DNNL_ARG_SRC, source},
                          {DNNL_ARG_WEIGHTS, copy_of(with_channels(conv, in, out), shape, memory::format_tag::oihw,
                                                     primitive.weights_desc())},
                          {DNNL_ARG_BIAS, copy_of(bias, {out}, memory::format_tag::x, primitive.bias_desc())},
                          {DNNL_ARG_DST, destination}});
}

void OnednnGraph::add_twice_as_large(const memory& source, const memory& destination) {
  const OpenMpThreads limit(threads_);
  const auto primitive =
      describe<dnnl::resampling_forward>(engine_, attributes(Then::add_relu), dnnl::algorithm::resampling_nearest,
                                         source.get_desc(), destination.get_desc());
  steps_.emplace_back(dnnl::resampling_forward(primitive),
                      std::unordered_map<int, memory>{{DNNL_ARG_SRC, source}, {DNNL_ARG_DST, destination}});
}

memory OnednnGraph::stage(int s, const memory& x) {
  const auto part = [&](const char* name, std::size_t level) { return fmt::format("stage{}.{}{}", s, name, level); };
  std::vector<memory> skips = {convolve(x, part("across", 0))};
  for (std::size_t level = 1; level < weights_->unet_channels.size(); ++level) {
    skips.push_back(convolve(convolve(skips.back(), part("down", level), 2), part("across", level)));
  }
  memory y = skips.back();
  for (std::size_t level = skips.size() - 1; level-- > 0;) {
    add_twice_as_large(convolve(y, part("lateral", level), 1, Then::nothing), skips[level]);
    y = convolve(skips[level], part("up", level));
  }
  return y;
}

memory OnednnGraph::last(const memory& source, const std::string& layer) {
  last_ = destination_of(layer, side_of(source), memory::data_type::f32);
  convolve_onto(source, layer, 1, Then::nothing, last_);
  return last_;
}

void OnednnGraph::run() {
  const OpenMpThreads limit(threads_);
  for (const auto& [primitive, arguments] : steps_) primitive.execute(stream_, arguments);
  stream_.wait();
}

float OnednnGraph::result(std::size_t i, int channel) const {
  const float value = static_cast<const float*>(last_.get_data_handle())[i * layout_.stride + channel];
  if (!std::isfinite(value)) throw InputError(printable(file_) + ": its weights give results that are not finite");
  return value;
}

memory OnednnGraph::copy_of(const std::vector<float>& values, const memory::dims& shape, memory::format_tag format,
                            const memory::desc& wanted) {
  memory plain({shape, memory::data_type::f32, format}, engine_);
  std::memcpy(plain.get_data_handle(), values.data(), values.size() * sizeof(float));
  memory copy(wanted, engine_);
  dnnl::reorder(plain, copy).execute(stream_, plain, copy);
  stream_.wait();
  return copy;
}

}  // namespace dualpixel::pipeline

#endif
