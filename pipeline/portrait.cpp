#include "pipeline/portrait.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "capture/error.h"
#include "pipeline/burst/demosaic.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/render.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/edge_aware/median.h"
#include "pipeline/resample.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

/// Times the stages of one run.
class StageClock {
 public:
  StageClock(std::vector<StageTime>& stages, const PortraitProgress& progress) : stages_(stages), progress_(progress) {}

  void expect(int stages) { count_ = stages; }

  template <typename Work>
  auto operator()(const std::string& name, const Work& work) {
    if (progress_) progress_(name, static_cast<double>(stages_.size()) / count_);
    const auto start = std::chrono::steady_clock::now();
    auto result = work();
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    stages_.push_back({name, elapsed.count(), static_cast<double>(usage.ru_maxrss) / 1024});
    if (progress_) progress_(name, static_cast<double>(stages_.size()) / count_);
    return result;
  }

 private:
  std::vector<StageTime>& stages_;
  int count_ = 1;
  const PortraitProgress& progress_;
};

/// The picture that the merged burst shows; grey, from the sum of its views, where it has no mosaic.
Image develop(const MergedBurst& burst, const Camera& camera, const Exposure& exposure) {
  if (!burst.mosaic.empty()) {
    return demosaic(white_balanced(burst.mosaic, camera.cfa, exposure.white_balance), camera.cfa);
  }
  Image gray(burst.left.width, burst.left.height, 3);
  for (std::size_t i = 0; i < burst.left.data.size(); ++i) {
    const float sum = burst.left.data[i] + burst.right.data[i];
    std::fill_n(gray.data.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, sum);
  }
  return resize_bilinear(gray, camera.width_px, camera.height_px);
}

/// Disparity and confidence reduced to width x height, as means weighted by confidence: what nobody is sure of must not
/// mix with what is known.
PixelDisparity reduce(const PixelDisparity& map, int width, int height) {
  Image weighted = map.disparity_dp_px;
  for (std::size_t i = 0; i < weighted.data.size(); ++i) weighted.data[i] *= map.confidence.data[i];
  weighted = resize_area(weighted, width, height);
  PixelDisparity reduced{resize_area(map.disparity_dp_px, width, height), resize_area(map.confidence, width, height)};
  for (std::size_t i = 0; i < weighted.data.size(); ++i) {
    const float confidence = reduced.confidence.data[i];
    if (confidence > 1e-6f) reduced.disparity_dp_px.data[i] = weighted.data[i] / confidence;
  }
  return reduced;
}

/// Median over the rectangle x, y, width, height, in fractions of the picture; none where it covers no pixel.
std::optional<double> median_inside(const Image& image, const std::array<double, 4>& rectangle) {
  const auto edge = [](double at, int size) {
    return static_cast<int>(std::clamp(std::round(at * size), 0.0, 1.0 * size));
  };
  std::vector<float> values;
  for (int y = edge(rectangle[1], image.height); y < edge(rectangle[1] + rectangle[3], image.height); ++y) {
    for (int x = edge(rectangle[0], image.width); x < edge(rectangle[0] + rectangle[2], image.width); ++x) {
      values.push_back(image.at(x, y));
    }
  }
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TileDisparity match(const MergedBurst& burst, const Capture& capture, const PortraitOptions& options) {
  if (options.matcher == Matcher::paper) {
    return match_tiles(normalize_locally(burst.left, options.normalize),
                       normalize_locally(burst.right, options.normalize), options.match);
  }
  const auto left = static_cast<float>(merged_view_variance(static_cast<int>(capture.frames.size())));
  const ViewNoise noise = view_noise(capture.exposure);
  LikelihoodMatchOptions likelihood = options.likelihood_match;
  likelihood.noise.reset();
  if (noise.shot > 0 || noise.read > 0) likelihood.noise = {left * noise.shot, left * noise.read};
  return match_by_likelihood(burst.left, burst.right, likelihood);
}

void require_mask(const Image& mask) {
  if (mask.empty() || mask.channels != 1) throw InputError("person mask: must have pixels, of one channel");
  for (const float value : mask.data) {
    if (!(value >= 0 && value <= 1)) throw InputError("person mask: every value must lie in [0, 1]");
  }
}

int stages_of(Mode mode) { return mode == Mode::seg ? 6 : mode == Mode::dp ? 8 : 9; }

Image stretched(const Image& mask, int width, int height) {
  return mask.width > width ? resize_area(mask, width, height) : resize_bilinear(mask, width, height);
}

}  // namespace

PortraitResult run_portrait(const Capture& capture, const PortraitOptions& options,
                            const std::optional<Image>& person_mask, const PortraitProgress& progress) {
  require_valid(options.bokeh.aperture);
  const bool find = options.mode != Mode::dp && !person_mask;
  if (find && !options.find_people) throw InputError("person mask: missing; modes dp+seg and seg need one");
  if (options.mode != Mode::dp && person_mask) require_mask(*person_mask);
  const int width = capture.camera.width_px, height = capture.camera.height_px;
  PortraitResult result;
  // before the work, not after it
  if (options.match_pupil_mm && options.mode != Mode::seg) match_lens(capture.camera, *options.match_pupil_mm, 0);
  std::optional<Correction> correction;
  if (options.calibration && (options.mode != Mode::seg || find)) {
    correction = make_correction(*options.calibration, capture.camera);
    result.warnings = options.calibration->warnings;
    if (!correction->warning.empty()) result.warnings.push_back(correction->warning);
  }
  result.mode = options.mode;
  StageClock stage(result.stages, progress);
  const auto expect_stages = [&] {
    stage.expect(stages_of(result.mode) + (correction && result.mode != Mode::seg ? 1 : 0) + (find ? 1 : 0));
  };
  expect_stages();

  MergedBurst burst = stage("merge", [&] { return align_and_merge(capture.frames, capture.exposure); });
  result.input = stage("demosaic", [&] { return develop(burst, capture.camera, capture.exposure); });
  burst.mosaic = {};
  result.base_frame = burst.base_frame;

  Bokeh bokeh = options.bokeh;
  const std::array<double, 3>& gains = capture.exposure.white_balance;
  bokeh.white = *std::min_element(gains.begin(), gains.end());

  std::optional<std::array<double, 4>> face_px = capture.face_px;
  FoundPeople found;
  if (find) {
    found = stage("people", [&] { return options.find_people(result.input); });
    result.faces = found.faces;
    if (found.faces.empty()) {
      result.mode = Mode::dp;
      expect_stages();
      result.warnings.emplace_back("no face found: blurred in mode dp, by disparity alone");
    } else {
      require_mask(found.mask);
      const Face& largest = found.faces.front();
      if (!face_px) face_px = {largest.x, largest.y, largest.width, largest.height};
    }
  }
  const Image& person = person_mask ? *person_mask : found.mask;  // not looked at in mode dp

  Defocused defocused;
  if (result.mode == Mode::seg) {
    result.mask = stage("mask", [&] {
      return filter_mask(person, encode_guide(result.input, guide_gain(result.input)), options.filter_mask);
    });
    MaskBlurred blurred = stage("blur", [&] {
      const MaskBlurOptions mask_blur = blur_for_face(face_px ? (*face_px)[2] : 0, width, options.mask_blur);
      return blur_background(result.input, result.mask, mask_blur, bokeh);
    });
    defocused = std::move(blurred.picture);
    result.blur_radius_px = std::move(blurred.radius_px);
  } else {
    PixelDisparity matched = stage("disparity", [&] {
      const TileDisparity tiles = match(burst, capture, options);
      return upsample_tiles(tiles, burst.left.width, burst.left.height, options.tile_upsample);
    });
    if (correction) {
      matched = stage("calibration", [&] {
        correct_disparity(*correction, matched.disparity_dp_px, matched.confidence);
        return std::move(matched);
      });
    }

    const int small_width = (width + 3) / 4, small_height = (height + 3) / 4;
    PixelDisparity small = reduce(matched, small_width, small_height);
    result.matched_disparity_dp_px = std::move(matched.disparity_dp_px);
    result.matched_confidence = std::move(matched.confidence);

    std::optional<double> person_dp_px;
    if (result.mode == Mode::dp_seg) {
      small = stage("mask", [&] {
        const Image mask = stretched(person, small_width, small_height);
        if (face_px) {
          const std::array<double, 4>& face = *face_px;
          const double x = static_cast<double>(small_width) / width, y = static_cast<double>(small_height) / height;
          person_dp_px = face_disparity(small, {face[0] * x, face[1] * y, face[2] * x, face[3] * y});
        } else {
          person_dp_px = interior_disparity(small, mask, options.merge_mask);
        }
        result.mask = stretched(person, width, height);
        return flatten_person(std::move(small), mask, static_cast<float>(*person_dp_px), options.merge_mask);
      });
    }

    const Image small_input = resize_area(result.input, small_width, small_height);
    const float gain = guide_gain(small_input);
    const Image small_guide = encode_guide(small_input, gain);
    const Image smooth = stage("smooth", [&] {
      const BilateralGrid grid = make_bilateral_grid(small_guide, options.grid);
      return median_3x3(
          solve_bilateral(grid, small_guide, small.disparity_dp_px, small.confidence, options.solver).value);
    });
    result.disparity_dp_px = stage("upsample", [&] {
      return joint_upsample(smooth, small_guide, encode_guide(result.input, gain), options.joint_upsample);
    });
    result.confidence = resize_bilinear(small.confidence, width, height);

    result.focus_disparity_dp_px = person_dp_px.value_or(0);
    if (face_px) {
      const std::array<double, 4>& face = *face_px;
      const std::optional<double> median =
          median_inside(smooth, {face[0] / width, face[1] / height, face[2] / width, face[3] / height});
      if (median && std::abs(*median) <= options.face_in_focus_dp_px) result.focus_disparity_dp_px = *median;
    }
    defocused = stage("blur", [&] {
      const BlurMapping mapping =
          options.match_pupil_mm ? match_lens(capture.camera, *options.match_pupil_mm, result.focus_disparity_dp_px)
                                 : make_blur_mapping(capture.camera.focus_distance_m, result.focus_disparity_dp_px,
                                                     width, result.mode == Mode::dp_seg, options.blur_radius);
      result.blur_radius_px = blur_radii(result.disparity_dp_px, mapping);
      return render_defocus(result.input, result.disparity_dp_px, result.blur_radius_px, mapping, options.layers,
                            bokeh);
    });
  }

  result.portrait = stage("noise", [&] {
    if (options.synthetic_noise) {
      add_noise(defocused.rgb, defocused.blurred, make_noise_patches(options.seed, options.noise),
                merged_noise(capture.exposure, static_cast<int>(capture.frames.size())));
    }
    return std::move(defocused.rgb);
  });
  result.portrait_srgb = stage("display", [&] { return encode_for_display(result.portrait, options.display); });
  return result;
}

}  // namespace dualpixel::pipeline
