#pragma once
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/capture.h"

/// Synthetic defocus against the photograph that a wide lens would have taken, and by what it falls short of it.
namespace dualpixel::evaluation {

/// PSNR in decibels of pictures clipped and encoded for display, against the photograph.
struct Closeness {
  double all_db = 0;
  double edges_db = 0;  ///< within the larger side's true radius of a depth edge
  double elsewhere_db = 0;
};

/// One picture; each after the first adds one cause of error.
struct Rung {
  std::string name;
  Closeness closeness;
  Image picture;  ///< linear
};

struct Preference {
  std::string name;
  double subject_db = 0;  ///< on the person's true mask
  double rim_db = 0;      ///< within 16 px of the mask's outline
  double all_db = 0;
};

struct SceneDefocus {
  std::string name;
  Image photograph;                   ///< truth, linear
  Closeness untouched;                ///< of the capture's picture
  std::vector<Rung> rungs;            ///< renderer alone, capture's picture, smoothing, matching, calibration, mask
  Rung recovered;                     ///< the rung "picture" with clipped highlights recovered (highlights.h)
  std::vector<Preference> preferred;  ///< best first at the rim; empty where there is no person
};

/// `capture` has truth. Blur is that of the photograph's lens (match_lens.h) and the focus the capture's own, whatever
/// faces there are. The rungs:
///   renderer       the true all-in-focus picture, blurred by true disparity
///   picture        the merged burst in its place: noise, and the phone lens's own blur
///   smoothing      true disparity at DP resolution, through the edge-aware stages
///   matching       matched disparity, brought to the truth's scale and offset by least squares, through the same
///   calibration    the same without that fit: the pipeline's mode dp
///   mask           with the true person mask: mode dp+seg; only where there is a person
SceneDefocus measure_defocus(const Capture& capture, const std::string& name);

/// Halos around a sharp disc in front of a wall blurred by `radius_px`, where the truth is known: mean |B - I| on the
/// disc, and mean |B - truth| beside it, both within the radius of its rim.
struct Halo {
  std::string method;
  double inside = 0, outside = 0;
  Image picture;     ///< linear
  Image difference;  ///< |B - I|, RGB
};
std::vector<Halo> measure_halos(float radius_px);

}  // namespace dualpixel::evaluation
