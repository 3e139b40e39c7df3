#include "tools/export_onnx/onnx_model.h"

#include <fmt/format.h>
#include <onnx/onnx_pb.h>

#include <cstdint>
#include <vector>

#include "pipeline/segmentation/network.h"

namespace dualpixel::tools {
namespace {

using pipeline::ConvWeights;

/// Builds the graph node by node; a value is known by the name of the node that makes it.
class Graph {
 public:
  explicit Graph(onnx::GraphProto& graph) : graph_(graph) {
    add_constant("no_region", {0}, {});
    add_constant("twice", {4}, {1, 1, 2, 2});
  }

  std::string convolution(const std::string& name, const ConvWeights& conv, const std::string& x, int stride = 1) {
    add_constant(name + ".weight", {conv.out, conv.in, conv.kernel, conv.kernel}, conv.weight);
    add_constant(name + ".bias", {conv.out}, conv.bias);
    onnx::NodeProto& node = add("Conv", name, {x, name + ".weight", name + ".bias"});
    const std::int64_t before = conv.kernel / 2;
    set(node, "kernel_shape", {conv.kernel, conv.kernel});
    set(node, "strides", {stride, stride});
    set(node, "pads", {before, before, before, before});
    return name;
  }
  std::string relu(const std::string& x) {
    add("Relu", x + ".relu", {x});
    return x + ".relu";
  }
  std::string sum(const std::string& name, const std::string& x, const std::string& y) {
    add("Add", name, {x, y});
    return name;
  }
  /// Each pixel to 2 x 2.
  std::string twice(const std::string& x) {
    onnx::NodeProto& node = add("Resize", x + ".twice", {x, "no_region", "twice"});
    set(node, "mode", "nearest");
    set(node, "coordinate_transformation_mode", "asymmetric");
    set(node, "nearest_mode", "floor");
    return x + ".twice";
  }
  /// Four channels to 2 x 2 pixels.
  std::string sub_pixels(const std::string& x) {
    onnx::NodeProto& node = add("DepthToSpace", x + ".pixels", {x});
    onnx::AttributeProto& size = *node.add_attribute();
    size.set_name("blocksize");
    size.set_type(onnx::AttributeProto::INT);
    size.set_i(2);
    set(node, "mode", "CRD");
    return x + ".pixels";
  }
  void sigmoid(const std::string& x, const std::string& name) { add("Sigmoid", name, {x}); }

 private:
  onnx::NodeProto& add(const char* type, const std::string& name, const std::vector<std::string>& inputs) {
    onnx::NodeProto& node = *graph_.add_node();
    node.set_op_type(type);
    node.set_name(name);
    for (const std::string& input : inputs) node.add_input(input);
    node.add_output(name);
    return node;
  }
  void add_constant(const std::string& name, const std::vector<std::int64_t>& shape, const std::vector<float>& values) {
    onnx::TensorProto& tensor = *graph_.add_initializer();
    tensor.set_name(name);
    tensor.set_data_type(onnx::TensorProto::FLOAT);
    for (const std::int64_t size : shape) tensor.add_dims(size);
    tensor.set_raw_data(values.data(), values.size() * sizeof(float));
  }
  static void set(onnx::NodeProto& node, const char* name, const std::vector<std::int64_t>& values) {
    onnx::AttributeProto& attribute = *node.add_attribute();
    attribute.set_name(name);
    attribute.set_type(onnx::AttributeProto::INTS);
    for (const std::int64_t value : values) attribute.add_ints(value);
  }
  static void set(onnx::NodeProto& node, const char* name, const char* value) {
    onnx::AttributeProto& attribute = *node.add_attribute();
    attribute.set_name(name);
    attribute.set_type(onnx::AttributeProto::STRING);
    attribute.set_s(value);
  }

  onnx::GraphProto& graph_;
};

void describe(onnx::ValueInfoProto& value, const char* name, int channels) {
  value.set_name(name);
  onnx::TypeProto::Tensor& tensor = *value.mutable_type()->mutable_tensor_type();
  tensor.set_elem_type(onnx::TensorProto::FLOAT);
  tensor.mutable_shape()->add_dim()->set_dim_param("N");
  for (const int size : {channels, pipeline::kNetworkSize_px, pipeline::kNetworkSize_px}) {
    tensor.mutable_shape()->add_dim()->set_dim_value(size);
  }
}

}  // namespace

std::string onnx_model(const pipeline::NetworkWeights& weights) {
  onnx::ModelProto model;
  model.set_ir_version(7);
  model.set_producer_name("dualpixel");
  model.set_producer_version(DUALPIXEL_VERSION);
  model.add_opset_import()->set_version(13);
  onnx::GraphProto& proto = *model.mutable_graph();
  proto.set_name("person");
  describe(*proto.add_input(), "input", 4);
  describe(*proto.add_output(), "mask", 1);

  Graph graph(proto);
  const auto plain = [&](const std::string& name, const std::string& x, int stride = 1) {
    return graph.convolution(name, weights.layers.at(name), x, stride);
  };
  const auto layer = [&](const std::string& name, const std::string& x, int stride = 1) {
    return graph.relu(plain(name, x, stride));
  };
  const std::string fine = layer("stem_fine", layer("stem_half", "input", 2));
  std::string x = layer("stem_quarter", fine, 2), y;
  for (int stage = 0; stage < weights.stages; ++stage) {
    const auto part = [&](const char* name, std::size_t level) {
      return fmt::format("stage{}.{}{}", stage, name, level);
    };
    std::vector<std::string> skips = {layer(part("across", 0), x)};
    for (std::size_t level = 1; level < weights.unet_channels.size(); ++level) {
      skips.push_back(layer(part("across", level), layer(part("down", level), skips.back(), 2)));
    }
    y = skips.back();
    for (std::size_t level = skips.size() - 1; level-- > 0;) {
      const std::string wide = graph.twice(plain(part("lateral", level), y));
      y = layer(part("up", level), graph.relu(graph.sum(part("join", level), skips[level], wide)));
    }
    if (stage + 1 == weights.stages) break;
    x = graph.relu(graph.sum(fmt::format("join{}", stage), x, plain(fmt::format("between{}", stage), y)));
  }
  const std::string mask = fmt::format("mask{}.", weights.stages - 1);
  const std::string joined = graph.relu(graph.sum(mask + "join", fine, graph.twice(plain(mask + "coarse", y))));
  graph.sigmoid(graph.sub_pixels(plain(mask + "sub_pixels", layer(mask + "mix", joined))), "mask");
  return model.SerializeAsString();
}

}  // namespace dualpixel::tools
