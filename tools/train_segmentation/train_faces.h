#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/train_segmentation/face_examples.h"
#include "tools/train_segmentation/network.h"
#include "tools/train_segmentation/train.h"

/// Training of the face detector.
namespace dualpixel::tools {

/// Of a batch's maps (batch, 4, 64, 64) against its targets: the focal loss of the scores as Zhou et al. 2019 have it
/// (section 4: alpha 2, beta 4), per face, and the boxes' mean absolute errors: of the size's logarithm, and five times
/// of the center in sides.
torch::Tensor face_loss(const torch::Tensor& map, const torch::Tensor& targets);

/// What a detector says of a set's pictures.
struct FaceFound {
  std::size_t picture = 0;
  bool is_face = true;  ///< else a false alarm
  double turn_deg = 0;  ///< of a face
  double side_px = 0;   ///< of the face, or of what was taken for one
  double score = 0;     ///< the best of those that overlap it by half; 0: none does
};
/// The certain faces of the set, and false alarms of a score of .05 or more.
std::vector<FaceFound> find_faces_of(Network& network, const FaceExamples& examples, torch::Device device);

/// The share of the faces that is found where `alarms_per_picture` false alarms are borne.
double recall_at(const std::vector<FaceFound>& found, std::size_t pictures, double alarms_per_picture);

/// Trains on sets of `dualpixel people --faces`: of the options data, held_out, output, samples or hours, seed, rate,
/// device, and threads. Writes faces.safetensors, log.json, and scores.csv (FaceFound of the held-out pictures).
/// Throws InputError for unusable data and where `output` cannot be made a folder or holds a run.
void train_faces(const TrainOptions& options, const std::function<bool(std::uint64_t samples)>& stop);

}  // namespace dualpixel::tools
