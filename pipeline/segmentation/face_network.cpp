#include "pipeline/segmentation/face_network.h"

#include "capture/error.h"

#ifdef DUALPIXEL_ONEDNN
#include <fmt/format.h>

#include "pipeline/segmentation/onednn_graph.h"

namespace dualpixel::pipeline {

struct FaceNetwork::Layers {
  explicit Layers(const NetworkWeights& weights) : graph(weights, 3, kFacePicture_px, 1, Precision::f32) {
    const dnnl::memory fine = graph.convolve(graph.convolve(graph.picture(), "stem_half", 2), "stem_fine");
    graph.last(graph.stage(0, graph.convolve(fine, "stem_quarter", 2)), "face_map");
  }

  OnednnGraph graph;
};

FaceNetwork::FaceNetwork(const NetworkWeights& weights) {
  if (!has_run_bf16()) claim_precision(Precision::f32);
  layers_ = std::make_unique<Layers>(weights);
}

std::vector<float> FaceNetwork::operator()(const Image& picture) {
  if (picture.width != kFacePicture_px || picture.height != kFacePicture_px || picture.channels != 3) {
    throw InputError(fmt::format("face network: a picture of {} x {} x {}: must be {} x {} x 3", picture.width,
                                 picture.height, picture.channels, kFacePicture_px, kFacePicture_px));
  }
  OnednnGraph& graph = layers_->graph;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    graph.input()[i % 3 * picture.pixel_count() + i / 3] = picture.data[i];
  }
  graph.run();
  constexpr std::size_t kCells = std::size_t{kFacePicture_px / kFaceCell_px} * (kFacePicture_px / kFaceCell_px);
  std::vector<float> map(kFaceChannels * kCells);
  for (int c = 0; c < kFaceChannels; ++c) {
    for (std::size_t i = 0; i < kCells; ++i) map[c * kCells + i] = graph.result(i, c);
  }
  return map;
}

}  // namespace dualpixel::pipeline

#else

namespace dualpixel::pipeline {

struct FaceNetwork::Layers {};

FaceNetwork::FaceNetwork(const NetworkWeights&) {
  throw InputError("face network: this build has no oneDNN; name the face, or install libdnnl-dev and build again");
}
std::vector<float> FaceNetwork::operator()(const Image&) { return {}; }

}  // namespace dualpixel::pipeline

#endif

namespace dualpixel::pipeline {

FaceNetwork::~FaceNetwork() = default;
FaceNetwork::FaceNetwork(FaceNetwork&&) noexcept = default;
FaceNetwork& FaceNetwork::operator=(FaceNetwork&&) noexcept = default;

}  // namespace dualpixel::pipeline
