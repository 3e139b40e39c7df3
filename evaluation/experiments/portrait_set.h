#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/experiments/mask_experiment.h"

/// The portraits of Shen et al. 2016, on which Wadhwa et al. 2018 compare with them (Table 1), as people bring them.
namespace dualpixel::evaluation {

/// Portraits with masks in the layout in which that set goes round (EG1800): pictures NAME.* in Images or
/// images_data_crop; masks in Labels (NAME.*) or GT_png (NAME_mask.*), of which the largest value, 1 or 255, is the
/// person; and the names of those to test, a line each, in eg1800_test.txt, testlist.txt or test.txt: without such a
/// file, all. faces.json, where it is there, gives the face of each of them: {"NAME": [x, y, width, height]}, a box
/// from brow to chin in pixels. Throws InputError that names what is missing or wrong.
std::vector<MaskedPicture> read_portrait_set(const std::string& folder);

/// A row of Table 1: mean IoU, 0..1.
struct PortraitSetRow {
  std::string model, training;
  double iou = 0;
  std::size_t pictures = 0;  ///< 0: the paper's figure
};

/// Theirs, then ours: faces found; where scores with faces given are not empty, these; each without and with edge-aware
/// filtering. `training`: what our network was trained on.
std::vector<PortraitSetRow> portrait_set_table(const std::vector<PictureMaskScore>& automatic,
                                               const std::vector<PictureMaskScore>& given, const std::string& training);
nlohmann::ordered_json to_json(const std::vector<PortraitSetRow>& table);
std::string to_text(const std::vector<PortraitSetRow>& table);

}  // namespace dualpixel::evaluation
