#include "evaluation/experiments/defocus_experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "capture/image/median.h"
#include "capture/image/resample.h"
#include "evaluation/experiments/defocus_baselines.h"
#include "evaluation/metrics/image_metrics.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/render.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/portrait/run_portrait.h"

namespace dualpixel::evaluation {
namespace {

using Mask = std::vector<std::uint8_t>;
using pipeline::BilateralGridOptions;

constexpr float kEdgeJumpDpPx = 0.1f;  // a depth edge, as score has it
constexpr int kRimPx = 16;

double psnr_within(const Image& a, const Image& b, const Mask& mask) {
  double squares = 0, values = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    if (!mask[i / 3]) continue;
    squares += std::pow(a.data[i] - b.data[i], 2);
    values += 1;
  }
  return -10 * std::log10(squares / values);
}

/// Marks the pixels within `radius` of (x, y).
void mark(Mask& mask, int width, int height, int x, int y, float radius) {
  const int reach = static_cast<int>(radius);
  for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height - 1); ++v) {
    const int half = static_cast<int>(std::sqrt(std::max(radius * radius - std::pow(v - y, 2), 0.0)));
    std::fill(mask.begin() + v * width + std::max(x - half, 0),
              mask.begin() + v * width + std::min(x + half + 1, width), std::uint8_t{1});
  }
}

/// Pixels within reach_of(pixel, neighbour) of a place where differ(pixel, neighbour), to the right or below.
template <typename Differ, typename Reach>
Mask near_edges(int width, int height, const Differ& differ, const Reach& reach_of) {
  Mask mask(static_cast<std::size_t>(width) * height);
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

/// Scores pictures against one photograph.
class Judge {
 public:
  Judge(const Truth& truth, const Image& true_radius_px)
      : photograph_(displayed(clipped(truth.photograph))),
        all_(true_radius_px.pixel_count(), 1),
        edges_(near_edges(
            true_radius_px.width, true_radius_px.height,
            [&](int i, int j) {
              return std::abs(truth.disparity_dp_px.data[i] - truth.disparity_dp_px.data[j]) > kEdgeJumpDpPx;
            },
            [&](int i, int j) { return std::max(true_radius_px.data[i], true_radius_px.data[j]) + 1; })),
        elsewhere_(all_) {
    for (std::size_t i = 0; i < edges_.size(); ++i) elsewhere_[i] = !edges_[i];
  }

  double db(const Image& linear, const Mask& mask) const {
    return psnr_within(displayed(clipped(linear)), photograph_, mask);
  }
  Closeness operator()(const Image& linear) const {
    const Image shown = displayed(clipped(linear));
    return {psnr_within(shown, photograph_, all_), psnr_within(shown, photograph_, edges_),
            psnr_within(shown, photograph_, elsewhere_)};
  }
  const Mask& all() const { return all_; }

 private:
  Image photograph_;
  Mask all_, edges_, elsewhere_;
};

/// Disparity at DP resolution through the edge-aware stages of run_portrait.
Image smoothed(const Image& disparity, const Image& confidence, const Image& input,
               const BilateralGridOptions& cells = {}) {
  const int width = (input.width + 3) / 4, height = (input.height + 3) / 4;
  Image weighted = disparity;
  for (std::size_t i = 0; i < weighted.data.size(); ++i) weighted.data[i] *= confidence.data[i];
  Image small = resize_area(weighted, width, height);
  const Image sure = resize_area(confidence, width, height);
  for (std::size_t i = 0; i < small.data.size(); ++i) small.data[i] /= std::max(sure.data[i], 1e-6f);
  const Image small_input = resize_area(input, width, height);
  const float gain = pipeline::guide_gain(small_input);
  const Image guide = pipeline::encode_guide(small_input, gain);
  const pipeline::BilateralGrid grid = pipeline::make_bilateral_grid(guide, cells);
  const Image solved = median_3x3(pipeline::solve_bilateral(grid, guide, small, sure).value);
  return pipeline::joint_upsample(solved, guide, pipeline::encode_guide(input, gain));
}

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

/// The best that `blur(radius)` reaches over radii, full-resolution px.
template <typename Blur>
Image best_uniform(const Judge& judge, int width, const Blur& blur) {
  Image best;
  double best_db = -1;
  for (const double share : {0.0015, 0.003, 0.0045, 0.006, 0.008, 0.010}) {
    Image picture = blur(static_cast<float>(share * width));
    const double db = judge.db(picture, judge.all());
    if (db > best_db) best = std::move(picture);
    best_db = std::max(db, best_db);
  }
  return best;
}

Mask mask_of(const Image& image) {
  Mask mask(image.data.size());
  std::transform(image.data.begin(), image.data.end(), mask.begin(), [](float v) { return v > 0.5f; });
  return mask;
}

std::vector<Preference> rank(const std::vector<std::pair<std::string, Image>>& pictures, const Judge& judge,
                             const Image& person) {
  const Mask subject = mask_of(person);
  const Mask rim = near_edges(
      person.width, person.height, [&](int i, int j) { return subject[i] != subject[j]; },
      [](int, int) { return static_cast<float>(kRimPx); });
  std::vector<Preference> ranked;
  for (const auto& [name, picture] : pictures) {
    ranked.push_back({name, judge.db(picture, subject), judge.db(picture, rim), judge.db(picture, judge.all())});
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const Preference& a, const Preference& b) { return a.rim_db > b.rim_db; });
  return ranked;
}

}  // namespace

SceneDefocus measure_defocus(const Capture& capture, const std::string& name) {
  const Truth& truth = *capture.truth;
  const Camera& camera = capture.camera;
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
  const Judge judge(truth, blur_radii(truth.disparity_dp_px, from_sharp));
  SceneDefocus scene{name, truth.photograph, judge(dp.input), {}, {}, {}};
  pipeline::Bokeh recover;
  recover.recover_highlights = true;
  recover.white = white;
  Image bright = render_defocus(dp.input, truth.disparity_dp_px, blur_radii(truth.disparity_dp_px, from_picture),
                                from_picture, {}, recover)
                     .rgb;
  scene.recovered = {"picture, highlights recovered", judge(bright), std::move(bright)};
  const auto add = [&](const std::string& rung, Image picture) {
    scene.rungs.push_back({rung, judge(picture), std::move(picture)});
  };
  const Image& matched = dp.matched_disparity_dp_px;
  const Image& confidence = dp.matched_confidence;
  const Image coarse_truth = resize_area(truth.disparity_dp_px, matched.width, matched.height);
  add("renderer", render(truth.all_in_focus, truth.disparity_dp_px, from_sharp));
  add("picture", render(dp.input, truth.disparity_dp_px, from_picture));
  const Image certain(matched.width, matched.height, 1, 1.0f);
  add("smoothing", render(dp.input, smoothed(coarse_truth, certain, dp.input), from_picture));
  add("matching",
      render(dp.input, smoothed(fitted(matched, coarse_truth, confidence), confidence, dp.input), from_picture));
  add("calibration", dp.portrait);

  const Image& person = truth.person_mask;
  if (std::none_of(person.data.begin(), person.data.end(), [](float v) { return v > 0.5f; })) return scene;
  options.mode = pipeline::Mode::dp_seg;
  const pipeline::PortraitResult both = pipeline::run_portrait(shot, options, person);
  add("mask", render(both.input, both.disparity_dp_px, from_picture));
  const auto seg = [&](float radius_px) {
    return pipeline::blur_background(dp.input, person, {radius_px, static_cast<double>(camera.width_px)}).rgb;
  };
  BilateralGridOptions coarse;
  coarse.cell_px = coarse.cell_luma = coarse.cell_chroma = 16;
  scene.preferred =
      rank({{"dp+seg", scene.rungs.back().picture},
            {"dp", dp.portrait},
            {"seg", best_uniform(judge, camera.width_px, seg)},
            {"mask and uniform blur",
             best_uniform(judge, camera.width_px,
                          [&](float radius_px) { return blur_behind_mask(dp.input, person, radius_px); })},
            {"bilateral space, coarse, unweighted",
             render(dp.input, smoothed(matched, certain, dp.input, coarse), from_picture)},
            {"not blurred", dp.input}},
           judge, person);
  return scene;
}

std::vector<Halo> measure_halos(float radius_px) {
  constexpr int kSide = 240;
  constexpr float kDisc = 60;
  // a yellow disc in focus before a blue wall with lights on it
  Image wall(kSide, kSide, 3), rgb, disparity(kSide, kSide, 1, 1.0f), radii(kSide, kSide, 1, radius_px);
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
    disparity.data[i] = radii.data[i] = 0;
  }
  const Image truth = blur_by_gathering(wall, Image(kSide, kSide, 1, radius_px));
  const pipeline::BlurMapping mapping{radius_px, 0, 0, 1, radius_px};  // the wall's disparity is 1

  std::vector<Halo> halos = {{"ours", 0, 0, render_defocus(rgb, disparity, radii, mapping).rgb, {}},
                             {"naive gather", 0, 0, blur_by_gathering(rgb, radii), {}},
                             {"single pass", 0, 0, blur_in_one_pass(rgb, radii), {}}};
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

}  // namespace dualpixel::evaluation
