#include "pipeline/portrait/portrait.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/image/median.h"
#include "capture/image/resample.h"
#include "capture/image/rows.h"
#include "pipeline/burst/demosaic.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/render.h"
#include "pipeline/edge_aware/guide.h"

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

/// Median over a region of a picture of width x height, which `image` is a smaller copy of; none where it covers no
/// pixel.
std::optional<double> median_inside(const Image& image, const Face& region, int width, int height) {
  const auto edge = [](double at, int size) {
    return static_cast<int>(std::clamp(std::round(at * size), 0.0, 1.0 * size));
  };
  const int left = edge(region.x / width, image.width), right = edge((region.x + region.width) / width, image.width);
  const int top = edge(region.y / height, image.height);
  const int bottom = edge((region.y + region.height) / height, image.height);
  std::vector<float> values;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) values.push_back(image.at(x, y));
  }
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Of the largest face in focus, or else of what was tapped.
std::optional<double> focus_disparity(const Image& disparity, const std::vector<Face>& faces,
                                      const PortraitOptions& options, int width, int height) {
  for (const Face& face : faces) {
    const std::optional<double> median = median_inside(disparity, face, width, height);
    if (median && std::abs(*median) <= options.face_in_focus_dp_px) return median;
  }
  return options.tap ? median_inside(disparity, *options.tap, width, height) : std::nullopt;
}

TileDisparity match(const MergedBurst& burst, const Capture& capture, const PortraitOptions& options) {
  const auto left = static_cast<float>(merged_view_variance(static_cast<int>(capture.frames.size())));
  const ViewNoise noise = view_noise(capture.exposure);
  std::optional<ViewNoise> merged;
  if (noise.shot > 0 || noise.read > 0) merged = {left * noise.shot, left * noise.read};
  return matcher_named(options.matcher).match(burst.left, burst.right, merged, options.matching);
}

void require_picture(const Image& picture, const Capture& capture) {
  if (capture.frames.size() != 1) {
    throw InputError(fmt::format("picture: beside {} frames: a finished one stands for one", capture.frames.size()));
  }
  const Camera& camera = capture.camera;
  const bool fits = picture.width == camera.width_px && picture.height == camera.height_px && picture.channels == 3;
  if (!fits || !std::all_of(picture.data.begin(), picture.data.end(), [](float v) { return v >= 0 && v <= 1; })) {
    throw InputError(fmt::format("picture: must be {} x {} pixels of linear RGB, every value in [0, 1]",
                                 camera.width_px, camera.height_px));
  }
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
  require_valid(options.defocus.bokeh.aperture);
  check(options.smooth);
  const bool find = options.mode != Mode::dp && !person_mask;
  if (find && !options.find_people) throw InputError("person mask: missing; modes dp+seg and seg need one");
  if (options.mode != Mode::dp && person_mask) require_mask(*person_mask);
  if (options.picture) require_picture(*options.picture, capture);
  const int width = capture.camera.width_px, height = capture.camera.height_px;
  PortraitResult result;
  // before the work, not after it
  if (options.match_pupil_mm && options.mode != Mode::seg) match_lens(capture.camera, *options.match_pupil_mm, 0);
  std::optional<Correction> correction;
  const auto prepare_correction = [&] {
    if (!options.calibration) return;
    correction = make_correction(*options.calibration, capture.camera);
    const std::vector<std::string>& warnings = options.calibration->warnings;
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
    if (!correction->warning.empty()) result.warnings.push_back(correction->warning);
  };
  result.mode = options.mode;
  if (result.mode != Mode::seg) prepare_correction();
  StageClock stage(result.stages, progress);
  const auto expect_stages = [&] { stage.expect(stages_of(result.mode) + (correction ? 1 : 0) + (find ? 1 : 0)); };
  expect_stages();

  MergedBurst burst = stage("merge", [&] { return align_and_merge(capture.frames, capture.exposure); });
  result.input = stage("demosaic", [&] {
    return options.picture ? *options.picture : develop(burst, capture.camera, capture.exposure);
  });
  burst.mosaic = {};
  result.base_frame = burst.base_frame;

  DefocusOptions defocus = options.defocus;
  const std::array<double, 3>& gains = capture.exposure.white_balance;
  defocus.bokeh.white = *std::min_element(gains.begin(), gains.end());

  std::vector<Face> faces = options.faces;
  if (faces.empty() && capture.face_px) {
    const auto& [x, y, w, h] = *capture.face_px;
    faces.push_back({x, y, w, h});
  }
  FoundPeople found;
  if (find) {
    found = stage("people", [&] { return options.find_people(result.input); });
    if (faces.empty()) faces = found.faces.empty() ? found.detected : found.faces;
    if (!anybody_seen(found)) {
      if (result.mode == Mode::seg) prepare_correction();
      result.mode = Mode::dp;
      expect_stages();
      const std::string_view why = found.detected.empty() ? "no face found"
                                   : found.faces.empty()  ? "no face is large enough to be the subject's"
                                                          : "nobody is seen there";
      result.warnings.push_back(fmt::format("{}: blurred in mode dp, by disparity alone", why));
    } else {
      result.faces = found.faces;
      require_mask(found.mask);
    }
  }
  const Image& person = person_mask ? *person_mask : found.mask;  // not looked at in mode dp
  if (result.mode != Mode::dp) {
    const float least = result.mode == Mode::dp_seg ? options.merge_mask.interior : 0.5f;
    if (std::none_of(person.data.begin(), person.data.end(), [&](float m) { return m > least; })) {
      result.warnings.push_back(fmt::format("the person mask has no pixel above {}: it keeps nobody sharp", least));
    }
  }

  Defocused defocused;
  if (result.mode == Mode::seg) {
    result.mask = stage("mask", [&] {
      return filter_mask(person, encode_guide(result.input, guide_gain(result.input)), options.filter_mask);
    });
    defocused = stage("blur", [&] {
      defocus.mask_blur = blur_for_face(faces.empty() ? 0 : faces[0].width, width, defocus.mask_blur);
      return defocus_method_named("mask").render({result.input, {}, result.mask, {}}, defocus);
    });
  } else {
    PixelDisparity matched = stage("disparity", [&] {
      const TileDisparity tiles = match(burst, capture, options);
      return upsample_tiles(tiles, burst.left.width, burst.left.height, options.tile_upsample);
    });
    if (correction) {
      matched = stage("calibration", [&] {
        Image* const sigma = matched.sigma_dp_px.empty() ? nullptr : &matched.sigma_dp_px;
        correct_disparity(*correction, matched.disparity_dp_px, matched.confidence, sigma);
        return std::move(matched);
      });
    }

    const SmoothingGuide guide = make_smoothing_guide(result.input, options.smooth);
    const int small_width = guide.small.width, small_height = guide.small.height;
    ConfidentMap reduced =
        reduce_by_confidence({matched.disparity_dp_px, matched.confidence}, small_width, small_height);
    PixelDisparity small{std::move(reduced.value), std::move(reduced.confidence), {}};
    result.matched_disparity_dp_px = std::move(matched.disparity_dp_px);
    result.matched_confidence = std::move(matched.confidence);
    result.matched_sigma_dp_px = std::move(matched.sigma_dp_px);

    std::optional<double> person_dp_px;
    if (result.mode == Mode::dp_seg) {
      small = stage("mask", [&] {
        const Image mask = stretched(person, small_width, small_height);
        if (!faces.empty()) {
          const Face& face = faces[0];
          const double x = static_cast<double>(small_width) / width, y = static_cast<double>(small_height) / height;
          person_dp_px = face_disparity(small, {face.x * x, face.y * y, face.width * x, face.height * y});
        } else {
          person_dp_px = interior_disparity(small, mask, options.merge_mask);
        }
        result.mask = stretched(person, width, height);
        return flatten_person(std::move(small), mask, static_cast<float>(*person_dp_px), options.merge_mask);
      });
    }

    const Image smooth = stage("smooth", [&] {
      return solve_and_median({small.disparity_dp_px, small.confidence}, guide.small, options.smooth);
    });
    result.disparity_dp_px =
        stage("upsample", [&] { return upsample_along_edges(smooth, guide, result.input, options.smooth); });
    result.confidence = resize_bilinear(small.confidence, width, height);

    result.focus_disparity_dp_px =
        focus_disparity(smooth, faces, options, width, height).value_or(person_dp_px.value_or(0));
    defocused = stage("blur", [&] {
      const BlurMapping mapping =
          options.match_pupil_mm ? match_lens(capture.camera, *options.match_pupil_mm, result.focus_disparity_dp_px)
                                 : make_blur_mapping(capture.camera.focus_distance_m, result.focus_disparity_dp_px,
                                                     width, result.mode == Mode::dp_seg, options.blur_radius);
      return defocus_method_named("layers").render({result.input, result.disparity_dp_px, {}, mapping}, defocus);
    });
  }

  result.blur_radius_px = std::move(defocused.radius_px);
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
