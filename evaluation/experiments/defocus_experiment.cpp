#include "evaluation/experiments/defocus_experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "capture/image/resample.h"
#include "capture/names.h"
#include "evaluation/baselines/bilateral_space_stereo.h"
#include "evaluation/experiments/defocus_baselines.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/photograph_disparity.h"
#include "evaluation/simulated_scene.h"
#include "pipeline/burst/merge.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/methods.h"
#include "pipeline/defocus/render.h"
#include "pipeline/edge_aware/smooth_disparity.h"
#include "pipeline/portrait/run_portrait.h"

namespace dualpixel::evaluation {
namespace {

using MarkedPixels = std::vector<std::uint8_t>;
using Json = nlohmann::ordered_json;

constexpr float kEdgeJumpDpPx = 0.1f;  // a depth edge, as score has it
constexpr int kRimPx = 16;

double psnr_within(const Image& a, const Image& b, const MarkedPixels& mask) {
  double squares = 0, values = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    if (!mask[i / 3]) continue;
    squares += std::pow(a.data[i] - b.data[i], 2);
    values += 1;
  }
  return -10 * std::log10(squares / values);
}

/// Marks the pixels within `radius` of (x, y).
void mark(MarkedPixels& mask, int width, int height, int x, int y, float radius) {
  const int reach = static_cast<int>(radius);
  for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height - 1); ++v) {
    const int half = static_cast<int>(std::sqrt(std::max(radius * radius - std::pow(v - y, 2), 0.0)));
    std::fill(mask.begin() + v * width + std::max(x - half, 0),
              mask.begin() + v * width + std::min(x + half + 1, width), std::uint8_t{1});
  }
}

/// Pixels within reach_of(pixel, neighbor) of an edge: a pixel that differs from its right or lower neighbor.
template <typename Differ, typename Reach>
MarkedPixels near_edges(int width, int height, const Differ& differ, const Reach& reach_of) {
  MarkedPixels mask(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height - 1; ++y) {
    for (int x = 0; x < width - 1; ++x) {
      const int i = y * width + x;
      for (const int j : {i + 1, i + width}) {
        if (differ(i, j)) mark(mask, width, height, x, y, reach_of(i, j));
      }
    }
  }
  return mask;
}

/// Compares pictures with one photograph.
class Comparison {
 public:
  Comparison(const Truth& truth, const Image& true_disparity, const Image& true_radius_px)
      : photograph_(displayed(clipped(truth.photograph))),
        all_(true_radius_px.pixel_count(), 1),
        edges_(near_edges(
            true_radius_px.width, true_radius_px.height,
            [&](int i, int j) { return std::abs(true_disparity.data[i] - true_disparity.data[j]) > kEdgeJumpDpPx; },
            [&](int i, int j) { return std::max(true_radius_px.data[i], true_radius_px.data[j]) + 1; })),
        elsewhere_(all_) {
    for (std::size_t i = 0; i < edges_.size(); ++i) elsewhere_[i] = !edges_[i];
  }

  double db(const Image& linear, const MarkedPixels& mask) const {
    return psnr_within(displayed(clipped(linear)), photograph_, mask);
  }
  DefocusPsnr operator()(const Image& linear) const {
    const Image shown = displayed(clipped(linear));
    return {psnr_within(shown, photograph_, all_), psnr_within(shown, photograph_, edges_),
            psnr_within(shown, photograph_, elsewhere_)};
  }
  const MarkedPixels& all() const { return all_; }

 private:
  Image photograph_;
  MarkedPixels all_, edges_, elsewhere_;
};

/// Scale and offset that bring `map` closest to `truth`, weighted by confidence, applied.
Image fitted(const Image& map, const Image& truth, const Image& confidence) {
  double w = 0, a = 0, b = 0, aa = 0, ab = 0;
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    const double c = confidence.data[i], x = map.data[i], y = truth.data[i];
    w += c;
    a += c * x;
    b += c * y;
    aa += c * x * x;
    ab += c * x * y;
  }
  const double scale = (w * ab - a * b) / (w * aa - a * a), offset = (b - scale * a) / w;
  Image out = map;
  for (float& value : out.data) value = static_cast<float>(scale * value + offset);
  return out;
}

/// By a method that blurs the background by one radius: the pipeline's own choice, which follows the face. The
/// photograph has no say in it.
Image blurred_by_mask(const pipeline::DefocusMethod& method, const Capture& capture, const Image& rgb,
                      const Image& person_mask) {
  const Image no_disparity;
  pipeline::DefocusOptions options;
  options.mask_blur = pipeline::blur_for_face(capture.face_px ? (*capture.face_px)[2] : 0, rgb.width);
  return method.render({rgb, no_disparity, person_mask, {}}, options).rgb;
}

MarkedPixels mask_of(const Image& image) {
  MarkedPixels mask(image.data.size());
  std::transform(image.data.begin(), image.data.end(), mask.begin(), [](float v) { return v > 0.5f; });
  return mask;
}

std::vector<RankedMethod> rank(const std::vector<std::pair<std::string, Image>>& pictures, const Comparison& compare,
                               const Image& person) {
  const MarkedPixels subject = mask_of(person);
  const MarkedPixels rim = near_edges(
      person.width, person.height, [&](int i, int j) { return subject[i] != subject[j]; },
      [](int, int) { return static_cast<float>(kRimPx); });
  std::vector<RankedMethod> ranked;
  for (const auto& [name, picture] : pictures) {
    ranked.push_back(
        {name, compare.db(picture, subject), compare.db(picture, rim), compare.db(picture, compare.all())});
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const RankedMethod& a, const RankedMethod& b) { return a.rim_db > b.rim_db; });
  return ranked;
}

}  // namespace

SceneDefocus measure_defocus(const Capture& capture, const std::string& name) {
  const Truth& truth = *capture.truth;
  const Camera& camera = capture.camera;
  const Image true_disparity = photograph_disparity(capture);
  const double pupil_mm = truth.photograph_aperture_scale * camera.focal_length_mm / camera.f_number;
  const pipeline::BlurMapping from_sharp = pipeline::match_lens(camera, pupil_mm, 0, true);
  const pipeline::BlurMapping from_picture = pipeline::match_lens(camera, pupil_mm, 0);
  const auto render = [&](const Image& rgb, const Image& disparity, const pipeline::BlurMapping& mapping) {
    return render_defocus(rgb, disparity, blur_radii(disparity, mapping), mapping).rgb;
  };
  Capture shot = capture;
  shot.truth.reset();
  shot.face_px.reset();
  pipeline::PortraitOptions options;
  options.match_pupil_mm = pupil_mm;
  options.synthetic_noise = false;
  const pipeline::PortraitResult dp = pipeline::run_portrait(shot, options);

  const std::array<double, 3>& gains = capture.exposure.white_balance;
  const double white = *std::min_element(gains.begin(), gains.end());
  const Comparison compare(truth, true_disparity, blur_radii(true_disparity, from_sharp));
  SceneDefocus scene{name, truth.photograph, compare(dp.input), {}, {}, {}};
  pipeline::Bokeh recover;
  recover.recover_highlights = true;
  recover.white = white;
  Image bright =
      render_defocus(dp.input, true_disparity, blur_radii(true_disparity, from_picture), from_picture, {}, recover).rgb;
  scene.recovered = {"picture, highlights recovered", compare(bright), std::move(bright)};
  const auto add = [&](const std::string& step, Image picture) {
    scene.steps.push_back({step, compare(picture), std::move(picture)});
  };
  const Image& matched = dp.matched_disparity_dp_px;
  const Image& confidence = dp.matched_confidence;
  const Image coarse_truth = resize_area(true_disparity, matched.width, matched.height);
  add("renderer", render(truth.all_in_focus, true_disparity, from_sharp));
  add("picture", render(dp.input, true_disparity, from_picture));
  const Image certain(matched.width, matched.height, 1, 1.0f);
  add("smoothing", render(dp.input, pipeline::smooth_disparity({coarse_truth, certain}, dp.input), from_picture));
  add("matching",
      render(dp.input, pipeline::smooth_disparity({fitted(matched, coarse_truth, confidence), confidence}, dp.input),
             from_picture));
  add("calibration", dp.portrait);

  const Image& person = truth.person_mask;
  if (std::none_of(person.data.begin(), person.data.end(), [](float v) { return v > 0.5f; })) return scene;
  options.mode = pipeline::Mode::dp_seg;
  const pipeline::PortraitResult both = pipeline::run_portrait(shot, options, person);
  add("mask", render(both.input, both.disparity_dp_px, from_picture));
  const pipeline::MergedBurst burst = pipeline::align_and_merge(shot.frames, shot.exposure, options.merge);
  const pipeline::DefocusMethod& uniform = *find_named(defocus_baselines(), "mask and uniform blur");
  scene.ranked = rank({{"dp+seg", scene.steps.back().picture},
                       {"dp", dp.portrait},
                       {"seg", blurred_by_mask(pipeline::defocus_method_named("mask"), capture, dp.input, person)},
                       {std::string(uniform.name), blurred_by_mask(uniform, capture, dp.input, person)},
                       {"bilateral-space stereo",
                        render(dp.input, bilateral_space_stereo(burst.left, burst.right, dp.input), from_picture)},
                       {"not blurred", dp.input}},
                      compare, person);
  return scene;
}

std::vector<Halo> measure_halos(float radius_px) {
  constexpr int kSide = 240;
  constexpr float kDisc = 60;
  // a yellow disc in focus before a blue wall with lights on it
  Image wall(kSide, kSide, 3), rgb, disparity(kSide, kSide, 1, 1.0f);
  std::vector<float> from_rim(wall.pixel_count());
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool light = x % 24 < 4 && y % 24 < 4;
      float* color = &wall.at(x, y);
      color[0] = light ? 0.8f : 0.05f;
      color[1] = light ? 0.7f : 0.12f;
      color[2] = light ? 0.6f : 0.35f;
      from_rim[y * kSide + x] = std::hypot(static_cast<float>(x) - 119.5f, static_cast<float>(y) - 119.5f) - kDisc;
    }
  }
  rgb = wall;
  for (std::size_t i = 0; i < from_rim.size(); ++i) {
    if (from_rim[i] > 0) continue;
    rgb.data[3 * i] = 0.7f;
    rgb.data[3 * i + 1] = 0.55f;
    rgb.data[3 * i + 2] = 0.05f;
    disparity.data[i] = 0;
  }
  const Image truth = blur_by_gathering(wall, Image(kSide, kSide, 1, radius_px));
  const pipeline::BlurMapping mapping{radius_px, 0, 0, 1, radius_px};  // the wall's disparity is 1

  const Image no_mask;
  const pipeline::DefocusInput input{rgb, disparity, no_mask, mapping};
  std::vector<Halo> halos;
  for (const auto methods : {pipeline::defocus_methods(), defocus_baselines()}) {
    for (const pipeline::DefocusMethod& method : methods) {
      if (method.by_mask) continue;
      const std::string name(method.name == "layers" ? "ours" : method.name);
      halos.push_back({name, 0, 0, method.render(input, {}).rgb, {}});
    }
  }
  for (Halo& halo : halos) {
    double inside = 0, outside = 0;
    halo.difference = halo.picture;
    for (std::size_t i = 0; i < rgb.data.size(); ++i) {
      halo.difference.data[i] = std::abs(halo.picture.data[i] - rgb.data[i]);
      const float distance = from_rim[i / 3];
      if (std::abs(distance) > radius_px) continue;
      if (distance <= 0) {
        halo.inside += halo.difference.data[i];
        inside += 1;
      } else {
        halo.outside += std::abs(halo.picture.data[i] - truth.data[i]);
        outside += 1;
      }
    }
    halo.inside /= inside;
    halo.outside /= outside;
  }
  return halos;
}

std::vector<HaloStep> measure_halo_sweep() {
  std::vector<HaloStep> steps;
  for (const float radius_px : {3.0f, 6.0f, 10.0f, 15.0f, 20.0f, 30.0f}) {
    steps.push_back({radius_px, measure_halos(radius_px)});
  }
  return steps;
}

SceneDefocus measure_scene_defocus(const std::string& scene_file) {
  // The photograph's rendering noise lies well below the errors that are measured.
  const Capture capture =
      simulate_scene(scene_file, {"sensor.width_px=1344", "sensor.height_px=1008", "sensor.pixel_pitch_um=2.8",
                                  "render.samples_per_pixel=64", "render.photograph_samples_per_pixel=256",
                                  "render.all_in_focus_samples_per_pixel=64"});
  return measure_defocus(capture, scene_file);
}

namespace {

Json to_json(const DefocusPsnr& psnr) {
  return {{"psnr_db", psnr.all_db}, {"psnr_edges_db", psnr.edges_db}, {"psnr_elsewhere_db", psnr.elsewhere_db}};
}

Json to_json(const SceneDefocus& scene) {
  Json json = {{"scene", scene.name},
               {"not_blurred", to_json(scene.not_blurred)},
               {"highlights_recovered", to_json(scene.recovered.psnr)}};
  double before = 0;
  for (const AblationStep& step : scene.steps) {
    json["steps"][step.name] = to_json(step.psnr);
    if (before > 0) json["steps"][step.name]["loss_db"] = before - step.psnr.all_db;
    before = step.psnr.all_db;
  }
  for (const RankedMethod& m : scene.ranked) {
    json["ranking"].push_back(
        {{"method", m.name}, {"psnr_rim_db", m.rim_db}, {"psnr_subject_db", m.subject_db}, {"psnr_db", m.all_db}});
  }
  return json;
}

}  // namespace

Json to_json(const std::vector<SceneDefocus>& scenes, const std::vector<HaloStep>& halos) {
  Json json = {{"experiment", "defocus"}, {"scenes", Json::array()}};
  for (const SceneDefocus& scene : scenes) json["scenes"].push_back(to_json(scene));
  for (const HaloStep& step : halos) {
    for (const Halo& halo : step.halos) {
      json["halos"].push_back(
          {{"radius_px", step.radius_px}, {"method", halo.method}, {"inside", halo.inside}, {"outside", halo.outside}});
    }
  }
  return json;
}

}  // namespace dualpixel::evaluation
