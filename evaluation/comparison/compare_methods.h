#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "evaluation/study/crops.h"

/// Methods of synthetic defocus on one capture against its true photograph (Wadhwa et al. 2018, Table 3, where people
/// voted).
namespace dualpixel::pipeline {
class PersonNetwork;
}

namespace dualpixel::evaluation {

/// Pictures clipped and encoded for display, against the photograph.
struct PictureFigures {
  double psnr_db = 0, ssim = 0, flip = 0;
};

struct MethodFigures {
  std::string method;
  PictureFigures whole;
  PictureFigures crops;  ///< over the study's crops: PSNR of their pooled square error, means of the others
};

struct SceneComparison {
  std::string scene;
  bool shows_people = false;  ///< truth
  bool found_people = false;  ///< by the detector and the network; else seg and Shen et al. leave the picture as it is
  bool by_stated_face = false;  ///< no face was detected there; the network was told where the capture states one
  double mask_iou = 0;          ///< of the mask that was found, at its own size; 0 where there is none, or nobody
  std::vector<Crop> crops;
  std::vector<MethodFigures> methods;  ///< compared_names(): the five, and then "true disparity" and "not blurred"
};

/// In the order of tables.
std::vector<std::string> compared_methods();

/// Those of SceneComparison::methods.
std::vector<std::string> compared_names();

struct ComparedPictures {
  SceneComparison figures;
  Image photograph_srgb;
  std::vector<Image> pictures_srgb;  ///< as figures.methods
};

/// Each method knows the capture without its truth. People are those that find_faces and the network find; where they
/// find nobody, whom the network finds at the face that the capture states, as a camera's own detector would. Blur of
/// all that have disparity is the photograph's lens (match_lens.h); that of the two that have a mask alone follows the
/// face (blur_for_face), as the product's does: no radius is chosen with the photograph in view. No synthetic noise.
///   dp+seg, seg, dp   the pipeline's modes
///   Shen et al.       the mask that was found, unfiltered; the whole picture blurred by one disc, the person laid over
///                     it. Theirs is another network's mask
///   Barron et al.     bilateral_space_stereo.h on the merged views, blurred by the pipeline's renderer, as the paper
///   did
/// "true disparity" is the pipeline's renderer with truth's: what errors of disparity cost is the distance to it. A
/// method beyond it gains by blurring away the noise of what is in focus.
ComparedPictures compare_methods(const Capture& capture, const std::string& name, pipeline::PersonNetwork& network);

nlohmann::ordered_json to_json(const SceneComparison& scene);
/// Throws InputError that names the file.
SceneComparison read_scene_comparison(const std::string& path);

}  // namespace dualpixel::evaluation
