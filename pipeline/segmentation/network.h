#pragma once
#include <memory>

#include "capture/image/image.h"
#include "pipeline/segmentation/precision.h"
#include "pipeline/segmentation/weights.h"

/// The person segmentation network of Wadhwa et al. 2018, section 3.2, at work: three stacked U-Nets, on oneDNN.
///
///   fine  = stem_fine(stem_half(input))                      128 x 128; every layer but lateral, between, coarse and
///   x     = stem_quarter(fine)                               64 x 64     sub_pixels ends in a ReLU
///   for each stage
///     s0 = across0(x), s1 = across1(down1(s0)), s2 = across2(down2(s1)), y = across3(down3(s2))
///     y = up2(relu(s2 + twice(lateral2(y)))), then up1 with s1, up0 with s0; twice(): each pixel to 2 x 2
///     x = relu(x + between(y))                               but after the last
///   mask  = sigmoid(sub_pixels(mix(relu(fine + twice(coarse(y))))))    four channels to 2 x 2 pixels
namespace dualpixel::pipeline {

inline constexpr int kNetworkSize_px = 256;

/// Whether this build has oneDNN; without it, PersonNetwork's constructor throws InputError.
bool has_person_network();

/// The limit to AVX2 is oneDNN's, for the whole process and for good: bf16 can be had only by a process that has built
/// no network in f32, and f32 only by one that has built none in bf16. A program that has run oneDNN before keeps what
/// it chose itself.
class PersonNetwork {
 public:
  /// One thread (22 ms a face) is not slowed down by a busy machine as several are, which wait for each other.
  /// Throws InputError where the precision cannot be had.
  explicit PersonNetwork(const NetworkWeights& weights = built_in_weights(), int threads = 1,
                         Precision precision = Precision::f32);
  ~PersonNetwork();
  PersonNetwork(PersonNetwork&&) noexcept;
  PersonNetwork& operator=(PersonNetwork&&) noexcept;

  /// `input`: 256 x 256 of four channels: sRGB in 0..1 minus 0.5, and the face's Gaussian. Returns the mask, 256 x 256,
  /// 0..1. One call at a time. Throws InputError where the weights are so large that results are not finite.
  Image operator()(const Image& input);

 private:
  struct Layers;
  std::unique_ptr<Layers> layers_;
};

}  // namespace dualpixel::pipeline
