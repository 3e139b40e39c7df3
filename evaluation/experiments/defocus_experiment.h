#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/capture.h"

/// Synthetic defocus against the photograph that a wide lens would have taken, and the loss that each cause adds.
namespace dualpixel::evaluation {

/// PSNR in decibels against the photograph; pictures are clipped and encoded for display.
struct DefocusPsnr {
  double all_db = 0;
  double edges_db = 0;  ///< within the true blur radius (the larger side's) of a depth edge
  double elsewhere_db = 0;
};

/// One picture; each step after the first adds one cause of error.
struct AblationStep {
  std::string name;
  DefocusPsnr psnr;
  Image picture;  ///< linear
};

struct RankedMethod {
  std::string name;
  double subject_db = 0;  ///< on the person's true mask
  double rim_db = 0;      ///< within 16 px of the mask's outline
  double all_db = 0;
};

struct SceneDefocus {
  std::string name;
  Image photograph;                  ///< truth, linear
  DefocusPsnr not_blurred;           ///< of the capture's picture
  std::vector<AblationStep> steps;   ///< as below
  AblationStep recovered;            ///< step "picture" with clipped highlights recovered (highlights.h)
  std::vector<RankedMethod> ranked;  ///< best first at the rim; empty where there is no person
};

/// `capture` has truth. Blur is that of the photograph's lens (match_lens.h) and the focus the capture's own, whatever
/// faces there are. The steps:
///   renderer       the true all-in-focus picture, blurred by true disparity
///   picture        the merged burst instead of the all-in-focus picture: noise, and the phone lens's own blur
///   smoothing      true disparity at DP resolution, through the edge-aware stages
///   matching       matched disparity, brought to the truth's scale and offset by least squares, through the same
///   calibration    the same without that fit: the pipeline's mode dp
///   mask           with the true person mask: mode dp+seg; only where there is a person
SceneDefocus measure_defocus(const Capture& capture, const std::string& name);

/// Simulates the scene on a quarter of a full sensor's photosites, then measures.
SceneDefocus measure_scene_defocus(const std::string& scene_file);

/// Color halos of one renderer around a sharp disc in front of a blurred wall, where the truth is known: mean
/// |blurred - sharp| on the disc, and mean |blurred - truth| beside it, both within the blur radius of its rim.
struct Halo {
  std::string method;
  double inside = 0, outside = 0;
  Image picture;     ///< linear
  Image difference;  ///< |blurred - sharp|, RGB
};
std::vector<Halo> measure_halos(float radius_px);

struct HaloStep {
  float radius_px = 0;
  std::vector<Halo> halos;  ///< the same methods at every radius
};
/// From 3 to 30 px.
std::vector<HaloStep> measure_halo_sweep();

nlohmann::ordered_json to_json(const std::vector<SceneDefocus>& scenes, const std::vector<HaloStep>& halos);
std::string to_page(const std::vector<SceneDefocus>& scenes, const std::vector<HaloStep>& halos);

}  // namespace dualpixel::evaluation
