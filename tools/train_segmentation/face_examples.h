#pragma once
#include <cstdint>
#include <vector>

#include "scenes/people/data_set/read_people_set.h"
#include "tools/train_segmentation/augment.h"
#include "tools/train_segmentation/batches.h"

/// What the face network is fed.
namespace dualpixel::tools {

/// A person's face in a picture, as a square.
struct TrueFace {
  double x = 0, y = 0, side = 0;
  double turn_deg = 0;  ///< from the camera
  bool certain = true;  ///< else it is hidden or smaller than kSmallestFace_px: finding it is neither right nor wrong
};

inline constexpr double kSmallestFace_px = 8;

/// One picture of a set and all faces in it but those turned away.
struct FacePicture {
  std::size_t sample = 0;
  std::vector<TrueFace> faces;
};
std::vector<FacePicture> face_pictures(const scenes::PeopleSet& set);

/// How one example is varied: a picture, and one of nobody that fills what is left of the square around it, or nothing.
struct FaceAugmentation {
  Augmentation picture, behind;
  bool has_behind = false;
  /// Something flat in front: x, y, width, height, as shares of the square, and its color; no width: nothing.
  std::array<double, 4> patch{};
  std::array<float, 3> patch_color{};
};

/// Rotated by up to 30 degrees, scaled by .3 to 1.5, or in one of four pictures such that a face fills .35 to .95 of
/// the square; blurred and lit more harshly than draw_augmentation() has it.
FaceAugmentation draw_face_augmentation(std::uint64_t key, const std::vector<TrueFace>& faces);

/// Channels first, of 256 x 256 pixels and 64 x 64 cells:
///   input    3: sRGB - 0.5
///   targets  6: what pipeline/segmentation/face_map.h says of each cell, the score as 0..1 (a Gaussian about the
///            center, 1 at its cell); where boxes count (0..1); where scores count (0 or 1)
/// `behind`: may be null. Returns the faces in the square.
std::vector<TrueFace> make_face_example(const scenes::PersonSample& sample, const std::vector<TrueFace>& faces,
                                        const scenes::PersonSample* behind, const FaceAugmentation& augmentation,
                                        float* input, float* targets);

inline constexpr int kFaceTargets = 6;

/// Examples of a set's pictures: the inputs, and the targets in place of heatmaps.
class FaceExamples {
 public:
  explicit FaceExamples(const scenes::PeopleSet& set);
  const std::vector<FacePicture>& pictures() const { return pictures_; }
  Batch augmented(const std::vector<Draw>& draws) const;  ///< indices of pictures()
  Batch plain(std::size_t first, std::size_t count) const;

 private:
  const scenes::PeopleSet& set_;
  std::vector<FacePicture> pictures_;
  std::vector<std::size_t> of_nobody_;
};

}  // namespace dualpixel::tools
