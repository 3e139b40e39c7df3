#include "tools/train_segmentation/checkpoint.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWeightDecay = 1e-4;

Checkpoint of_shape(const NetworkShape& shape) {
  Checkpoint checkpoint;
  checkpoint.network = Network(shape);
  for (torch::Tensor& parameter : checkpoint.network->parameters()) {
    if (parameter.dim() == 4) parameter.set_data(parameter.data().contiguous(torch::MemoryFormat::ChannelsLast));
  }
  forget_optimiser(checkpoint);
  return checkpoint;
}

}  // namespace

void forget_optimiser(Checkpoint& checkpoint) {
  checkpoint.optimiser = std::make_unique<torch::optim::AdamW>(checkpoint.network->parameters(),
                                                               torch::optim::AdamWOptions().weight_decay(kWeightDecay));
}

Checkpoint new_checkpoint(const NetworkShape& shape, std::uint64_t seed) {
  torch::manual_seed(seed);
  return of_shape(shape);
}

void write_checkpoint(const Checkpoint& checkpoint, const std::string& path) {
  torch::serialize::OutputArchive archive, network, optimiser;
  const NetworkShape& shape = checkpoint.network->shape;
  const Json text = {{"fcn", shape.fcn},
                     {"stages", shape.stages},
                     {"pose", shape.pose},
                     {"samples", checkpoint.samples},
                     {"seconds", checkpoint.seconds},
                     {"recipe", checkpoint.recipe},
                     {"points", checkpoint.points}};
  archive.write("text", c10::IValue(text.dump()));
  checkpoint.network->save(network);
  archive.write("network", network);
  checkpoint.optimiser->save(optimiser);
  archive.write("optimiser", optimiser);
  std::ostringstream bytes;
  archive.save_to(bytes);
  replace_file(path, bytes.str());
}

Checkpoint read_checkpoint(const std::string& path) {
  require_regular_file(path);
  try {
    torch::serialize::InputArchive archive, network, optimiser;
    archive.load_from(path);
    c10::IValue value;
    archive.read("text", value);
    const Json text = Json::parse(value.toStringRef());
    NetworkShape shape;
    shape.fcn = text.at("fcn");
    shape.stages = text.at("stages");
    shape.pose = text.at("pose");
    const double seconds = text.at("seconds");
    if (shape.stages < 1 || shape.stages > 3 || !std::isfinite(seconds) || seconds < 0) throw InputError("");
    Checkpoint checkpoint = of_shape(shape);
    archive.read("network", network);
    checkpoint.network->load(network);
    archive.read("optimiser", optimiser);
    checkpoint.optimiser->load(optimiser);
    checkpoint.samples = text.at("samples");
    checkpoint.seconds = seconds;
    checkpoint.recipe = text.at("recipe");
    checkpoint.points = text.at("points");
    return checkpoint;
  } catch (const std::exception&) {
    throw InputError(printable(path) + ": is no checkpoint of this program, or a damaged one");
  }
}

}  // namespace dualpixel::tools
