#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "scenes/gltf/mesh.h"

/// Pictures by code. All repeat seamlessly: u and v run from 0 to 1 over the picture.
namespace dualpixel::scenes {

/// Each texel is color(u, v) in linear light, at its middle; the same for any number of threads.
Texture paint(int size, const std::function<glm::vec3(float u, float v)>& linear_color);

/// Seamless noise of mean 0 and deviation 1 whose amplitude spectrum falls as f^-slope between `lowest` and `highest`
/// cells across the picture (both powers of two apart). In two dimensions a slope of 1 gives every octave the same
/// contrast, as photographs have it on the average (Field 1987); surfaces by themselves are smoother, 1.2 to 1.6.
class PinkNoise {
 public:
  /// Stretched: `along_u` and `along_v` times as many cells (whole numbers, so that it still repeats).
  PinkNoise(std::uint32_t seed, int lowest, int highest, float slope, int along_u = 1, int along_v = 1);
  float operator()(float u, float v) const;

 private:
  /// Its random numbers at the corners of all cells: a texel asks for each of them many times.
  struct Octave {
    int columns, rows;
    float weight;
    std::vector<float> corners;  ///< one more a row and a column than cells: the first ones again
  };
  std::vector<Octave> octaves_;
  float scale_;
};

/// `color` lighter or darker by e^(contrast * n): reflectance varies in proportion.
glm::vec3 shaded(glm::vec3 color, float contrast, float n);

}  // namespace dualpixel::scenes
