#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "scenes/people/data_set/read_people_set.h"

/// What the network is fed: samples as they are, or varied as Wadhwa et al. 2018, section 3.2, has it.
namespace dualpixel::tools {

/// How one sample is varied. The defaults leave it as it is.
struct Augmentation {
  // Geometry, about the picture's center: mirror, then scale, rotate, shift.
  bool mirror = false;  ///< left and right keypoints change places
  double rotation_rad = 0;
  double scale = 1;
  double shift_x_px = 0, shift_y_px = 0;
  double face_shift_x = 0, face_shift_y = 0;  ///< a detector's inaccuracy, in sizes of the face box
  // Light and camera, on sRGB values: ((gain * v)^gamma - 0.5) * contrast + 0.5, then towards gray.
  std::array<double, 3> gain = {1, 1, 1};
  double gamma = 1;
  double contrast = 1;
  double saturation = 1;
  int blur_passes = 0;  ///< of a 3 x 3 binomial kernel
  double noise = 0;     ///< standard deviation
  std::uint64_t noise_key = 0;
};

/// Picture coordinates before and after an augmentation's geometry, and back.
class Warp {
 public:
  explicit Warp(const Augmentation& augmentation);
  std::array<double, 2> forward(double x, double y) const;
  std::array<double, 2> back(double x, double y) const;

 private:
  double cos_scaled_, sin_scaled_, flip_, shift_x_, shift_y_;
};

/// Red, green, blue, mask, and 1 inside the photograph, which tells it from its padding.
inline constexpr int kPlanes = 5;

/// A sample's picture and mask, varied: 256 x 256 pixels of kPlanes values, 0..1.
std::vector<float> varied_picture(const scenes::PersonSample& sample, const Augmentation& augmentation);

/// The next uniform value in [low, high) of a key's sequence.
struct Draws {
  std::uint64_t key;
  std::uint64_t count = 0;
  double operator()(double low, double high);
};

/// The paper's ranges for geometry: rotation +-10 degrees, scale 0.4 to 1.2, shift +-10 % of the side. It says nothing
/// of mirrors, faces and colors: those are ours. A value depends on `key` alone.
Augmentation draw_augmentation(std::uint64_t key);

/// Writes one example, channels last:
///   input     256 x 256 x 4: sRGB - 0.5 (padding is -0.5 but where a blur reaches), and the face's Gaussian (sigma
///             21 px, peak 1)
///   mask      256 x 256, 0..1
///   heatmaps  64 x 64 x 17, 0..1: a Gaussian of sigma 1.5 px and peak 1 (Tompson et al. 2014) at each keypoint in the
///             picture, hidden or seen; null: not wanted
void make_example(const scenes::PersonSample& sample, const Augmentation& augmentation, float* input, float* mask,
                  float* heatmaps);

}  // namespace dualpixel::tools
