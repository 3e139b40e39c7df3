#include "tools/train_segmentation/checkpoint.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWeightDecay = 1e-4;
constexpr const char* kOptimizerKey = "optimiser";  // as checkpoints of earlier builds spell it

/// Names, types and shapes of all tensors of a network. Loading a file replaces them whatever their shapes, so these
/// are compared before and after.
std::string layout_of(Network& network) {
  std::string layout;
  for (const auto& items : {network->named_parameters(), network->named_buffers()}) {
    for (const auto& item : items) {
      layout += fmt::format("{} {} {}\n", item.key(), item.value().toString(), fmt::join(item.value().sizes(), " "));
    }
  }
  return layout;
}

/// What a log's entries must have: chart and progress line look them up.
bool are_points(const Json& points) {
  return points.is_array() && std::all_of(points.begin(), points.end(), [](const Json& point) {
           for (const char* name : {"samples", "size_px", "mask_loss", "held_out_iou", "held_out_gradient_error"}) {
             if (!point.is_object() || !point.contains(name) || !point[name].is_number()) return false;
           }
           return !point.contains("pose_loss") || point["pose_loss"].is_number();
         });
}

Checkpoint of_shape(const NetworkShape& shape, bool sgd, torch::Device device) {
  Checkpoint checkpoint;
  checkpoint.sgd = sgd;
  checkpoint.network = Network(shape);
  checkpoint.network->to(device);
  for (torch::Tensor& parameter : checkpoint.network->parameters()) {
    if (parameter.dim() == 4) parameter.set_data(parameter.data().contiguous(torch::MemoryFormat::ChannelsLast));
  }
  forget_optimizer(checkpoint);
  return checkpoint;
}

}  // namespace

void forget_optimizer(Checkpoint& checkpoint) {
  if (checkpoint.sgd) {
    checkpoint.optimizer =
        std::make_unique<torch::optim::SGD>(checkpoint.network->parameters(), torch::optim::SGDOptions(0));
    return;
  }
  checkpoint.optimizer = std::make_unique<torch::optim::AdamW>(checkpoint.network->parameters(),
                                                               torch::optim::AdamWOptions().weight_decay(kWeightDecay));
}

Checkpoint new_checkpoint(const NetworkShape& shape, std::uint64_t seed) {
  torch::manual_seed(seed);
  return of_shape(shape, false, torch::kCPU);
}

std::string weights_hash(Network& network) {
  std::string bytes;
  for (const auto& items : {network->named_parameters(), network->named_buffers()}) {
    for (const auto& item : items) {
      const torch::Tensor values = item.value().detach().cpu().contiguous();
      bytes.append(static_cast<const char*>(values.data_ptr()), values.nbytes());
    }
  }
  return hash_of(bytes);
}

void write_checkpoint(const Checkpoint& checkpoint, const std::string& path) {
  torch::serialize::OutputArchive archive, network, optimizer;
  const NetworkShape& shape = checkpoint.network->shape;
  const Json text = {{"fcn", shape.fcn},
                     {"stages", shape.stages},
                     {"pose", shape.pose},
                     {"sgd", checkpoint.sgd},
                     {"samples", checkpoint.samples},
                     {"seconds", checkpoint.seconds},
                     {"recipe", checkpoint.recipe},
                     {"points", checkpoint.points}};
  archive.write("text", c10::IValue(text.dump()));
  checkpoint.network->save(network);
  archive.write("network", network);
  checkpoint.optimizer->save(optimizer);
  archive.write(kOptimizerKey, optimizer);
  std::ostringstream bytes;
  archive.save_to(bytes);
  replace_file(path, bytes.str());
}

Checkpoint read_checkpoint(const std::string& path, torch::Device device) {
  require_regular_file(path);
  try {
    torch::serialize::InputArchive archive, network, optimizer;
    archive.load_from(path, device);
    c10::IValue value;
    archive.read("text", value);
    const nlohmann::json text = parse_json(value.toStringRef(), path);
    NetworkShape shape;
    Checkpoint checkpoint;
    Fields fields(text, path);
    fields.required("fcn").boolean("fcn", shape.fcn);
    fields.required("stages").integer("stages", shape.stages, 1, 3);
    fields.required("pose").boolean("pose", shape.pose);
    fields.boolean("sgd", checkpoint.sgd);  // which checkpoints of earlier builds lack
    fields.required("samples").integer("samples", checkpoint.samples, 0, std::uint64_t{1} << 40);
    fields.required("seconds").number("seconds", checkpoint.seconds, 0, 1e9);
    checkpoint.recipe = Json(fields.raw("recipe"));
    checkpoint.points = Json(fields.raw("points"));
    if (!are_points(checkpoint.points) || !checkpoint.recipe.is_object()) fields.fail("points", "are not a log's");
    Checkpoint fresh = of_shape(shape, checkpoint.sgd, device);
    checkpoint.network = fresh.network;
    checkpoint.optimizer = std::move(fresh.optimizer);
    const std::string layout = layout_of(checkpoint.network);
    archive.read("network", network);
    checkpoint.network->load(network);
    if (layout_of(checkpoint.network) != layout) fields.fail("network", "its layers are of other sizes");
    archive.read(kOptimizerKey, optimizer);
    checkpoint.optimizer->load(optimizer);
    return checkpoint;
  } catch (const InputError&) {
    throw;
  } catch (const std::exception&) {
    throw InputError(printable(path) + ": is not a checkpoint of this program, or a damaged one");
  }
}

}  // namespace dualpixel::tools
