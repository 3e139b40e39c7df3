#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace dualpixel::scenes {

inline constexpr int kPictureSide_px = 256;
inline constexpr int kKeypoints = 17;  ///< COCO's: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles

/// One picture and one of its people.
struct PeopleSample {
  std::vector<std::uint8_t> picture;  ///< 256 x 256 x 3, sRGB; the photograph centered, 0 around it
  std::vector<std::uint8_t> mask;     ///< 256 x 256: 255 times the fraction of the pixel that shows this person
  std::array<glm::vec3, kKeypoints> keypoints{};  ///< COCO's order; x, y, 0 outside the picture | 1 hidden | 2 visible
  glm::vec4 face{0};                              ///< x, y, width, height: brow to chin, square
  std::uint64_t seed = 0;                         ///< of the picture
  int picture_index = 0;                          ///< samples of one picture have the same
  int people = 1;                                 ///< in the picture, without bystanders
  bool composite = false;
  std::vector<std::string> tags;
};

}  // namespace dualpixel::scenes
