#pragma once
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "evaluation/metrics/score_people.h"
#include "pipeline/segmentation/face.h"
#include "pipeline/segmentation/network.h"

/// Person masks of pictures against true ones: IoU, gradient error, and the worst shown.
namespace dualpixel::evaluation {

struct MaskedPicture {
  std::string name;
  std::string picture, mask;               ///< paths
  std::vector<pipeline::Face> faces = {};  ///< those given; none: they are to be found
  bool labels = false;                     ///< the mask's largest value is the person, and not white
};

/// The regular files of a folder, by name, without hidden ones. Throws InputError where it cannot be read.
std::vector<std::filesystem::path> regular_files(const std::string& folder);

/// Every picture of one folder with the mask of the same name in the other, whatever their extensions. Throws
/// InputError where a folder cannot be read or a mask is missing.
std::vector<MaskedPicture> pair_masks(const std::string& pictures_folder, const std::string& masks_folder);

/// Where no face is given or found the mask is empty.
struct PictureMaskScore {
  std::string name;
  std::size_t faces = 0;
  /// At the picture's size: of the network's mask enlarged, and after edge-aware filtering.
  double iou = 0, filtered_iou = 0;
  /// At the network's size, of the same two; 0 without a face.
  double gradient_error = 0, filtered_gradient_error = 0;
  double find_cpu_ms = 0;  ///< faces and network, without the filter; in the first picture with what is made once
};

struct MaskMeans {
  std::size_t count = 0, with_face = 0;
  double iou = 0, filtered_iou = 0;              ///< over all
  double iou_found = 0, filtered_iou_found = 0;  ///< over those with a face, as the following; 0 if there are none
  double gradient_error = 0, filtered_gradient_error = 0;
  double find_cpu_ms = 0;  ///< median over all
};
MaskMeans means_of(const std::vector<PictureMaskScore>& scores);

/// A picture with its mask's errors: too much in orange, missing in blue.
struct WorstMask {
  std::string name, caption;
  Image errors_srgb;
};

struct PictureMasks {
  std::vector<PictureMaskScore> pictures;
  std::vector<WorstMask> worst;  ///< the twenty lowest filtered IoU, lowest first
};
PictureMasks score_pictures(const std::vector<MaskedPicture>& pictures, pipeline::PersonNetwork& network,
                            const std::function<void(double fraction)>& progress);

struct PeopleMasks {
  PeopleScores scores;
  std::vector<WorstMask> worst;
};
PeopleMasks score_people_masks(const scenes::PeopleSet& set, pipeline::PersonNetwork& network,
                               const std::function<void(double fraction)>& progress);

/// The network that was measured.
struct NetworkId {
  std::string weights_hash;
  std::string precision;  ///< "f32" or "bf16"
};
nlohmann::ordered_json to_json(const std::vector<PictureMaskScore>& pictures, const NetworkId& network);
nlohmann::ordered_json to_json(const PeopleScores& scores, const std::string& people_hash, const NetworkId& network);

std::string to_page(const PictureMasks& masks);
std::string to_page(const PeopleMasks& masks);

}  // namespace dualpixel::evaluation
