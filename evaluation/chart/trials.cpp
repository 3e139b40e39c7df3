#include "evaluation/chart/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "capture/image/resample.h"
#include "capture/timing.h"
#include "evaluation/experiments/defocus_baselines.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/metrics/photograph_disparity.h"
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/methods.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"

namespace dualpixel::evaluation {
namespace {

struct Cost {
  double cpu_ms = 0, memory_mb = 0;
};

/// The time of the fastest of three runs, since what is made once is in the first; the memory of one more.
Cost cost_of(const std::function<void()>& work) {
  const double cpu_ms = times({work}, 3).cpu_ms.front();
  return {cpu_ms, peak_mb(work)};
}

}  // namespace

double percent_of_white(double psnr_db) { return 100 * std::pow(10, -psnr_db / 20); }

std::vector<Trial> try_defocus(const Capture& capture) {
  const Truth& truth = *capture.truth;
  const double pupil_mm = truth.photograph_aperture_scale * capture.camera.focal_length_mm / capture.camera.f_number;
  const pipeline::DefocusInput input{truth.all_in_focus, photograph_disparity(capture), truth.person_mask,
                                     pipeline::match_lens(capture.camera, pupil_mm, 0, true)};
  const Image photograph = displayed(clipped(truth.photograph));
  std::vector<Trial> trials;
  const auto add = [&](const std::string& name, const pipeline::DefocusMethod& method,
                       const pipeline::DefocusOptions& options, bool is_default) {
    Image picture;
    const Cost cost = cost_of([&] { picture = method.render(input, options).rgb; });
    const auto psnr = psnr_db(displayed(clipped(picture)), photograph);
    trials.push_back({name, psnr ? percent_of_white(*psnr) : 0, cost.cpu_ms, cost.memory_mb, is_default});
  };
  pipeline::DefocusOptions options;
  if (capture.face_px) {
    options.mask_blur = pipeline::blur_for_face((*capture.face_px)[2], truth.all_in_focus.width);
  }
  const pipeline::DefocusMethod& layers = pipeline::defocus_method_named("layers");
  for (const int bands : {3, 5, 9}) {
    pipeline::DefocusOptions with_bands = options;
    with_bands.layers.bands = bands;
    add(fmt::format("layers, {} bands", bands), layers, with_bands, bands == options.layers.bands);
  }
  add("mask", pipeline::defocus_method_named("mask"), options, false);
  for (const pipeline::DefocusMethod& method : defocus_baselines())
    add(std::string(method.name), method, options, false);
  return trials;
}

std::vector<Trial> try_masks(const Capture& capture, const Image& picture) {
  if (!pipeline::has_person_network() || !capture.face_px) return {};
  static pipeline::PersonNetwork network;
  const Image& truth = capture.truth->person_mask;
  const std::array<double, 4>& face = *capture.face_px;
  std::vector<Trial> trials;
  const auto add = [&](const std::string& name, const std::vector<pipeline::Face>& given, bool is_default) {
    Image coarse, fine;
    const Cost find = cost_of([&] { coarse = pipeline::find_people(picture, given, network).mask; });
    if (coarse.empty()) coarse = Image(2, 2);
    const Image enlarged = resize_bilinear(coarse, truth.width, truth.height);
    const Cost filter = cost_of([&] { fine = filtered_mask(coarse, picture); });
    trials.push_back({name, 100 * (1 - mask_iou(enlarged, truth)), find.cpu_ms, find.memory_mb, is_default});
    trials.push_back({name + ", filtered", 100 * (1 - mask_iou(fine, truth)), find.cpu_ms + filter.cpu_ms,
                      std::max(find.memory_mb, filter.memory_mb), false});
  };
  add("face found", {}, true);
  add("face given", {{face[0], face[1], face[2], face[3]}}, false);
  return trials;
}

std::vector<ChartPoint> points_of(const std::vector<std::vector<Trial>>& repetitions) {
  std::vector<ChartPoint> points;
  if (repetitions.empty()) return points;
  for (std::size_t i = 0; i < repetitions.front().size(); ++i) {
    std::vector<double> errors, times;
    for (const std::vector<Trial>& trials : repetitions) {
      errors.push_back(trials[i].error);
      times.push_back(trials[i].time);
    }
    const Trial& trial = repetitions.front()[i];
    points.push_back({trial.name, mean_of(errors), mean_of(times), trial.is_default, trial.memory_mb, trial.is_bound});
  }
  return points;
}

}  // namespace dualpixel::evaluation
