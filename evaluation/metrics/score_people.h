#pragma once
#include <functional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/segmentation/network.h"
#include "scenes/people/data_set/read_people_set.h"

/// How good a network's masks of a people set are: over all, and split by what is hard.
namespace dualpixel::evaluation {

struct PeopleRow {
  std::string name;
  std::size_t samples = 0;
  double iou = 0, filtered_iou = 0;  ///< means over samples
  double iou_error = 0;              ///< standard error of iou; samples of a scene are one draw; of one draw NaN
  double iou_without_face = 0;       ///< of the network's mask where the face's channel is black
  double gradient_error = 0, filtered_gradient_error = 0;  ///< means over all pixels of the samples, or of the region
};

struct PeopleScores {
  /// Samples: "all"; "rendered", "composites"; "one person", "groups"; and one row for each value of the tags hair,
  /// hat and held.
  std::vector<PeopleRow> samples;
  /// Regions, of which the gradient errors alone are given: "hair", above the chin and within a face's width of the
  /// face's box; "hands", within 0.75 of that width of a wrist that is seen; "hands that hold", those of samples with a
  /// tag "held:...".
  std::vector<PeopleRow> regions;
  std::vector<double> filtered_iou;  ///< of each sample
};

/// The whole square of a sample, black padding included; so are all masks scored here. (The pipeline filters a mask at
/// the photograph's size, without padding.)
Image picture_of(const scenes::PersonSample& sample);  ///< linear RGB
Image mask_of(const scenes::PersonSample& sample);
Image filtered_mask_of(const scenes::PersonSample& sample, pipeline::PersonNetwork& network);

/// The truth's face is the seed: no detector is asked.
PeopleScores score_people(const scenes::PeopleSet& set, pipeline::PersonNetwork& network,
                          const std::function<void(double)>& progress = {});

}  // namespace dualpixel::evaluation
