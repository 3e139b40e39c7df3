#pragma once
#include <memory>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/segmentation/face_map.h"
#include "pipeline/segmentation/weights.h"

/// The network that finds faces, on oneDNN: one U-Net of network.h's, whose features at a quarter of the size are
/// convolved to the map of face_map.h.
///
///   x   = stem_quarter(stem_fine(stem_half(input)))           every layer but face_map ends in a ReLU
///   map = face_map(stage0(x))
namespace dualpixel::pipeline {

inline constexpr int kFacePicture_px = 320;

class FaceNetwork {
 public:
  /// In f32, on one thread; with instructions up to AVX2 alone, unless the process has run a network in bf16. Throws
  /// InputError in a build without oneDNN.
  explicit FaceNetwork(const NetworkWeights& weights = built_in_weights(NetworkKind::faces));
  ~FaceNetwork();
  FaceNetwork(FaceNetwork&&) noexcept;
  FaceNetwork& operator=(FaceNetwork&&) noexcept;

  /// `picture`: 320 x 320 of three channels: sRGB in 0..1 minus 0.5, and -0.5 where there is no picture. Returns the
  /// map, four planes of 80 x 80 values. One call at a time. Throws InputError where the weights are so large that
  /// results are not finite.
  std::vector<float> operator()(const Image& picture);

 private:
  struct Layers;
  std::unique_ptr<Layers> layers_;
};

}  // namespace dualpixel::pipeline
