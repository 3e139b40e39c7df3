#include "pipeline/portrait/run_portrait.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/image/demosaic.h"
#include "capture/image/resample.h"
#include "capture/shading.h"
#include "capture/views.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/defocus/aperture.h"
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/methods.h"
#include "pipeline/disparity/match_pixels.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/portrait/focus.h"
#include "pipeline/portrait/plain_pair.h"
#include "pipeline/portrait/subject.h"
#include "pipeline/portrait/zoom.h"

namespace dualpixel::pipeline {
namespace {

/// The state of one run, from step to step. For transposed pictures (PortraitOptions::transposed) everything here is
/// transposed; run_portrait transposes its input and its result.
struct Run {
  const Capture& capture;
  const PortraitOptions& options;
  int width, height;              ///< of the full sensor
  const Image* person = nullptr;  ///< mask that was given or found; of any size
  bool looks_for_people = false;  ///< as the mode needs a mask and none is given
  std::vector<Face> faces;        ///< known or found, largest first
  std::optional<Face> tap;        ///< the region that the user pointed at
  DefocusOptions defocus;         ///< the options', with the capture's white level and the face's radius
  PortraitResult result;          ///< filled step by step
  std::vector<Face> seeds;        ///< upright, for find_people
  const Camera* whole = nullptr;  ///< of which `window` is a part; null: the picture is whole
  Window window;
  std::optional<Correction> correction;
  MergedBurst burst;
  Image shading;  ///< that the picture was multiplied by; empty: by none
  Image found_mask;
  PixelDisparity matched;
  SmoothingGuide guide;
  PixelDisparity reduced;              ///< of the guide's size
  std::optional<double> person_dp_px;  ///< disparity that the person was flattened to
  Image smooth;                        ///< of the guide's size
  Defocused defocused;
};

void require_picture(const Image& picture, const Capture& capture) {
  if (capture.frames.size() != 1) {
    throw InputError(fmt::format("picture: given beside {} frames: must be beside one", capture.frames.size()));
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

Image stretched(const Image& mask, int width, int height) {
  return mask.width > width ? resize_area(mask, width, height) : resize_bilinear(mask, width, height);
}

/// Section 4.2: the calibration at the capture's focus distance, for a mode that needs disparity.
void prepare_correction(Run& run) {
  if (!run.options.calibration) return;
  run.correction = make_correction(*run.options.calibration, run.whole ? *run.whole : run.capture.camera);
  if (run.whole) {
    const double width = run.whole->width_px, height = run.whole->height_px;
    run.correction = of_part(*run.correction, run.window.x / width, run.window.y / height, run.window.width / width,
                             run.window.height / height);
  }
  std::vector<std::string>& warnings = run.result.warnings;
  const std::vector<std::string>& sweep = run.options.calibration->warnings;
  warnings.insert(warnings.end(), sweep.begin(), sweep.end());
  if (!run.correction->warning.empty()) warnings.push_back(run.correction->warning);
}

void warn_of_empty_mask(Run& run) {
  const float least = run.result.mode == Mode::dp_seg ? run.options.merge_mask.interior : 0.5f;
  const std::vector<float>& mask = run.person->data;
  if (std::any_of(mask.begin(), mask.end(), [&](float m) { return m > least; })) return;
  run.result.warnings.push_back(fmt::format("the person mask has no pixel above {}: nothing is kept sharp", least));
}

/// Section 4.1: the burst aligned and merged (Hasinoff et al. 2016).
void merge_frames(Run& run) {
  run.burst = align_and_merge(run.capture.frames, run.capture.exposure, run.options.merge);
  run.result.base_frame = run.burst.base_frame;
}

/// The picture that the merged burst shows, lens shading taken out where the camera states it; gray, from the sum of
/// its views, where it has no mosaic.
void develop(Run& run) {
  const Camera& camera = run.capture.camera;
  MergedBurst& burst = run.burst;
  if (run.options.picture) {
    run.result.input = *run.options.picture;
  } else if (!burst.mosaic.empty()) {
    const Exposure& exposure = run.capture.exposure;
    run.result.input = in_srgb(demosaic(white_balanced(burst.mosaic, camera.cfa, exposure.white_balance), camera.cfa),
                               exposure.color_matrix);
  } else {
    Image gray(burst.left.width, burst.left.height, 3);
    for (std::size_t i = 0; i < burst.left.data.size(); ++i) {
      const float sum = burst.left.data[i] + burst.right.data[i];
      std::fill_n(gray.data.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, sum);
    }
    run.result.input = resize_bilinear(gray, camera.width_px, camera.height_px);
  }
  burst.mosaic = {};
  if (run.options.picture) return;  // finished
  run.shading = run.whole ? cut(shading_gain(*run.whole), run.window, *run.whole) : shading_gain(camera);
  correct_shading(run.result.input, run.shading, static_cast<float>(run.defocus.bokeh.white));
}

/// options.find_people sees the picture upright.
FoundPeople people_in(const Run& run) {
  if (!run.options.transposed) return run.options.find_people(run.result.input, run.seeds);
  FoundPeople found = run.options.find_people(transposed(run.result.input), run.seeds);
  for (std::vector<Face>* faces : {&found.faces, &found.detected}) {
    for (Face& face : *faces) face = transposed(face);
  }
  found.mask = transposed(found.mask);
  return found;
}

/// Where no people are found, the mask that the mode needs is missing, and the run goes on in mode dp.
void fall_back_to_disparity(Run& run, const FoundPeople& found) {
  const std::string_view why = found.detected.empty() && run.options.tap
                                   ? "no person found at the tap (--face says where a face is)"
                               : found.detected.empty() ? "no face found"
                               : found.faces.empty()    ? "no face is large enough to be the subject's"
                                                        : "the network finds no person there";
  if (!has_views(run.capture)) {
    throw NobodyFound(
        fmt::format("{}, and there are no dual-pixel views: nothing says what to blur; give --face or --mask", why));
  }
  if (run.result.mode == Mode::seg) prepare_correction(run);
  run.result.mode = Mode::dp;
  if (run.options.mode == Mode::automatic) {
    run.result.mode_reason = fmt::format("dual-pixel views, {}", why);
  } else {
    run.result.warnings.push_back(fmt::format("{}: blurred in mode dp, by disparity alone", why));
  }
}

/// Section 3.3: faces, and the mask of the people they belong to.
void find_people(Run& run) {
  FoundPeople found = people_in(run);
  if (run.faces.empty()) run.faces = found.faces.empty() ? found.detected : found.faces;
  if (!anybody_seen(found)) {
    fall_back_to_disparity(run, found);
    return;
  }
  require_mask(found.mask);
  run.result.faces = std::move(found.faces);
  run.found_mask = std::move(found.mask);
  run.person = &run.found_mask;
  warn_of_empty_mask(run);
}

/// Section 4.1: disparity of every tile, then of every DP pixel.
void match_views(Run& run) {
  const double noise_left = merged_view_variance(static_cast<int>(run.capture.frames.size()));
  ViewSensor sensor = view_sensor(run.capture.exposure, noise_left);
  if (run.correction) sensor.skew = run.correction->skew;
  run.matched = match_pixels(run.capture, run.burst.left, run.burst.right, sensor, matcher_named(run.options.matcher),
                             run.options.matching, run.options.tile_upsample);
}

/// Section 4.2: the lens's aberrations taken out.
void correct_aberrations(Run& run) {
  Image* const sigma = run.matched.sigma_dp_px.empty() ? nullptr : &run.matched.sigma_dp_px;
  correct_disparity(*run.correction, run.matched.disparity_dp_px, run.matched.confidence, sigma);
}

/// Section 4.4: reduces the matches to the solver's resolution, unless that is done already.
void reduce(Run& run) {
  if (!run.reduced.confidence.empty()) return;
  run.guide = make_smoothing_guide(run.result.input, run.options.smooth);
  ConfidentMap reduced = reduce_by_confidence({run.matched.disparity_dp_px, run.matched.confidence},
                                              run.guide.small.width, run.guide.small.height);
  run.reduced = {std::move(reduced.value), std::move(reduced.confidence), {}};
  run.result.matched_disparity_dp_px = std::move(run.matched.disparity_dp_px);
  run.result.matched_confidence = std::move(run.matched.confidence);
  run.result.matched_sigma_dp_px = std::move(run.matched.sigma_dp_px);
}

/// Section 4.3: the mask's interior set to the face's disparity.
void merge_mask(Run& run) {
  reduce(run);
  const int width = run.guide.small.width, height = run.guide.small.height;
  const Image mask = stretched(*run.person, width, height);
  if (!run.faces.empty()) {
    const Face& face = run.faces[0];
    const double x = static_cast<double>(width) / run.width, y = static_cast<double>(height) / run.height;
    run.person_dp_px = face_disparity(run.reduced, {face.x * x, face.y * y, face.width * x, face.height * y});
  } else {
    run.person_dp_px = interior_disparity(run.reduced, mask, run.options.merge_mask);
  }
  run.result.mask = stretched(*run.person, run.width, run.height);
  run.reduced =
      flatten_person(std::move(run.reduced), mask, static_cast<float>(*run.person_dp_px), run.options.merge_mask);
}

/// Section 4.4: bilateral solver and median.
void smooth(Run& run) {
  reduce(run);
  run.smooth =
      solve_and_median({run.reduced.disparity_dp_px, run.reduced.confidence}, run.guide.small, run.options.smooth);
}

/// Section 4.4: joint bilateral upsampling.
void upsample(Run& run) {
  run.result.disparity_dp_px = upsample_along_edges(run.smooth, run.guide, run.result.input, run.options.smooth);
  run.result.confidence = resize_bilinear(run.reduced.confidence, run.width, run.height);
}

/// Of the picture as the user sees it, by which blur is measured.
Camera upright_camera(const Run& run) {
  Camera camera = run.capture.camera;
  if (run.options.transposed) std::swap(camera.width_px, camera.height_px);
  return camera;
}

/// What --match-lens can do about a picture without blur.
std::string advice_on_sharp_picture(const Run& run) {
  const Camera& camera = run.capture.camera;
  if (run.options.match_pupil_mm) return "the lens to match is not wider than the camera's, or nothing is out of focus";
  if (!(camera.alpha > 0 && camera.focal_length_mm > 0 && camera.f_number > 0)) return "nothing is far from the focus";
  return "--match-lens f/3.3@41mm-equivalent blurs as such a lens does";
}

/// Where nothing is far from the focus, or the picture is small, nothing may be left of the blur.
void warn_of_sharp_picture(Run& run) {
  constexpr float kSeen_px = 0.5f;
  const std::vector<float>& radii = run.defocused.radius_px.data;
  const float largest = radii.empty() ? 0 : *std::max_element(radii.begin(), radii.end());
  if (largest >= kSeen_px) return;
  run.result.warnings.push_back(
      fmt::format("nothing is blurred: the largest radius is {:.2g} px; {}", largest, advice_on_sharp_picture(run)));
}

/// Sections 5.1 and 5.2: d_focus, Eq. 5's radii, and the layered blur.
void blur_by_disparity(Run& run) {
  const PortraitOptions& options = run.options;
  PortraitResult& result = run.result;
  const Camera camera = upright_camera(run);
  const double in_focus_dp_px =
      options.face_in_focus_dp_px / reference_dp_px(camera.width_px, camera.dp_downsample_x, options.blur_radius);
  result.focus_disparity_dp_px = focus_disparity(run.smooth, run.faces, run.tap, in_focus_dp_px, run.width, run.height)
                                     .value_or(run.person_dp_px.value_or(0));
  const BlurMapping mapping =
      options.match_pupil_mm
          ? match_lens(camera, *options.match_pupil_mm, result.focus_disparity_dp_px)
          : make_blur_mapping(camera.focus_distance_m, result.focus_disparity_dp_px, camera.width_px,
                              result.mode == Mode::dp_seg, options.blur_radius, camera.dp_downsample_x);
  run.defocused =
      defocus_method_named("layers").render({result.input, result.disparity_dp_px, {}, mapping}, run.defocus);
  warn_of_sharp_picture(run);
}

/// Section 3.4: the mask made to follow the picture's edges.
void filter_person_mask(Run& run) {
  const Image& input = run.result.input;
  run.result.mask = filter_mask(*run.person, encode_guide(input, guide_gain(input)), run.options.filter_mask);
}

/// End of section 5.2: what is behind the person, by one radius.
void blur_by_mask(Run& run) {
  DefocusOptions& defocus = run.defocus;
  double face_width_px = 0;
  if (!run.faces.empty()) face_width_px = run.options.transposed ? run.faces[0].height : run.faces[0].width;
  defocus.mask_blur = blur_for_face(face_width_px, upright_camera(run).width_px, defocus.mask_blur);
  run.defocused = defocus_method_named("mask").render({run.result.input, {}, run.result.mask, {}}, defocus);
}

/// The picture is the sum of the views, gray.
bool is_of_views(const Run& run) { return run.capture.frames[0].mosaic.empty() && !run.options.picture; }

/// Section 5.3: noise on what the blur has smoothed. It has the mosaic's colors, so a gray picture gets none.
void synthesize_noise(Run& run) {
  run.result.blur_radius_px = std::move(run.defocused.radius_px);
  if (run.options.synthetic_noise && !is_of_views(run)) {
    add_noise(run.defocused.rgb, run.defocused.blurred, make_noise_patches(run.options.seed, run.options.noise),
              merged_noise(run.capture.exposure, static_cast<int>(run.capture.frames.size())), run.shading);
  }
  run.result.portrait = std::move(run.defocused.rgb);
}

void encode(Run& run) { run.result.portrait_srgb = encode_for_display(run.result.portrait, run.options.display); }

bool always(const Run&) { return true; }
bool holds_frames(const Run& run) { return holds_photosites(run.capture); }
bool seeks_people(const Run& run) { return run.looks_for_people; }
bool needs_disparity(const Run& run) { return run.result.mode != Mode::seg; }
bool needs_matching(const Run& run) { return needs_disparity(run) && !run.options.disparity; }
bool needs_correction(const Run& run) { return run.correction.has_value(); }
bool needs_flattening(const Run& run) { return run.result.mode == Mode::dp_seg; }
bool needs_mask_alone(const Run& run) { return run.result.mode == Mode::seg; }

struct Step {
  const char* name;  ///< of the stage, in result.json and on the progress bar
  void (*work)(Run& run);
  bool (*needed)(const Run& run);
};

constexpr Step kSteps[] = {
    {"merge", merge_frames, holds_frames},
    {"demosaic", develop, always},
    {"people", find_people, seeks_people},
    {"disparity", match_views, needs_matching},
    {"calibration", correct_aberrations, needs_correction},
    {"mask", merge_mask, needs_flattening},
    {"smooth", smooth, needs_disparity},
    {"upsample", upsample, needs_disparity},
    {"blur", blur_by_disparity, needs_disparity},
    {"mask", filter_person_mask, needs_mask_alone},
    {"blur", blur_by_mask, needs_mask_alone},
    {"noise", synthesize_noise, always},
    {"display", encode, always},
};

/// Runs a step and notes what it took.
void run_step(const Step& step, Run& run, const PortraitProgress& progress) {
  std::vector<StageTime>& done = run.result.stages;
  const auto report = [&] {  // finding nobody changes which steps are needed
    if (!progress) return;
    const auto all = std::count_if(std::begin(kSteps), std::end(kSteps), [&](const Step& s) { return s.needed(run); });
    progress(step.name, static_cast<double>(done.size()) / static_cast<double>(all));
  };
  report();
  const auto start = std::chrono::steady_clock::now();
  step.work(run);
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  done.push_back({step.name, elapsed.count(), static_cast<double>(usage.ru_maxrss) / 1024});
  report();
}

/// The disparity that is given, checked.
PixelDisparity given_disparity(const PortraitOptions& options, const Camera& camera) {
  int width = camera.dp_width(), height = camera.dp_height();
  if (options.transposed) std::swap(width, height);
  return as_matched(*options.disparity, width, height);
}

/// In place of match_views.
void take_disparity(Run& run) {
  run.matched = given_disparity(run.options, run.capture.camera);
  if (!run.options.transposed) return;
  for (Image* map : {&run.matched.disparity_dp_px, &run.matched.confidence, &run.matched.sigma_dp_px}) {
    *map = transposed(*map);
  }
}

/// Without views there is no disparity for these. Where the user names the mode, they are refused by its name.
void require_no_disparity_options(const PortraitOptions& options) {
  for (const auto& [what, given] : {std::pair{"disparity", options.disparity.has_value()},
                                    {"calibration", options.calibration.has_value()},
                                    {"match_lens", options.match_pupil_mm.has_value()}}) {
    if (given) throw InputError(fmt::format("{}: there are no dual-pixel views to use it with; leave it out", what));
  }
}

/// The mode, as far as it is known before people are looked for: dp_seg and seg may become dp.
void choose_mode(Run& run, bool mask_given) {
  const PortraitOptions& options = run.options;
  const bool views = has_views(run.capture);
  PortraitResult& result = run.result;
  result.mode = options.mode;
  if (options.mode == Mode::automatic) {
    if (!views) require_no_disparity_options(options);
    const bool people = mask_given || options.find_people;
    result.mode = !views ? Mode::seg : people ? Mode::dp_seg : Mode::dp;
    result.mode_reason = !people ? "dual-pixel views, people not looked for"
                                 : fmt::format("{}, {}", views ? "dual-pixel views" : "no dual-pixel views",
                                               mask_given ? "a person mask is given" : "people found");
  } else if (!views && options.mode != Mode::seg) {
    throw InputError(fmt::format("mode {}: there are no dual-pixel views; choose seg", name_of(kModes, options.mode)));
  }
  run.looks_for_people = result.mode != Mode::dp && !mask_given;
  if (run.looks_for_people && !options.find_people) {
    throw InputError("person mask: missing; modes dp+seg and seg need one");
  }
}

/// Checks all input before any work, and prepares the run. `person_mask` has the capture's orientation.
void prepare(Run& run, const std::optional<Image>& person_mask) {
  const PortraitOptions& options = run.options;
  check(options);
  choose_mode(run, person_mask.has_value());
  if (options.picture) require_picture(*options.picture, run.capture);
  if (options.match_pupil_mm && run.result.mode != Mode::seg)
    match_lens(run.capture.camera, *options.match_pupil_mm, 0);
  KnownSubject known = known_subject(run.capture, options);
  run.seeds = known.faces;
  run.faces = std::move(known.faces);
  run.tap = known.tap;
  if (options.transposed) {
    for (Face& face : run.faces) face = transposed(face);
    if (run.tap) run.tap = transposed(*run.tap);
    run.defocus.bokeh.aperture.transposed = true;
  }
  const std::array<double, 3>& gains = run.capture.exposure.white_balance;
  run.defocus.bokeh.white = is_of_views(run)
                                ? 2 * view_white(run.capture.exposure)
                                : mosaic_white(run.capture.exposure) * *std::min_element(gains.begin(), gains.end());
  run.result.warnings = std::move(known.warnings);
  if (run.result.mode != Mode::seg) prepare_correction(run);
  if (options.disparity) take_disparity(run);
  if (run.result.mode != Mode::dp && person_mask) {
    require_mask(*person_mask);
    run.person = &*person_mask;
    warn_of_empty_mask(run);
  }
}

void turn_upright(PortraitResult& result) {
  using Result = PortraitResult;
  for (Image Result::*image : {&Result::input, &Result::portrait, &Result::portrait_srgb, &Result::disparity_dp_px,
                               &Result::confidence, &Result::matched_disparity_dp_px, &Result::matched_confidence,
                               &Result::matched_sigma_dp_px, &Result::mask, &Result::blur_radius_px}) {
    result.*image = transposed(result.*image);
  }
  for (Face& face : result.faces) face = transposed(face);
}

/// Of the whole capture, or, where it is but a window of it, with the whole one's camera.
PortraitResult run_whole(const Capture& capture, const PortraitOptions& options,
                         const std::optional<Image>& person_mask, const PortraitProgress& progress, const Camera* whole,
                         const Window& window) {
  std::optional<Image> turned_mask;
  if (options.transposed && person_mask) turned_mask = transposed(*person_mask);
  Run run{.capture = capture,
          .options = options,
          .width = capture.camera.width_px,
          .height = capture.camera.height_px,
          .defocus = options.defocus,
          .whole = whole,
          .window = window};
  prepare(run, options.transposed ? turned_mask : person_mask);
  for (const Step& step : kSteps) {
    if (step.needed(run)) run_step(step, run, progress);
  }
  if (options.transposed) turn_upright(run.result);
  return std::move(run.result);
}

}  // namespace

PortraitResult run_portrait(const Capture& capture, const PortraitOptions& options,
                            const std::optional<Image>& person_mask, const PortraitProgress& progress) {
  if (capture.frames.empty()) throw InputError("burst: no frames");
  if (!options.zoom) return run_whole(capture, options, person_mask, progress, nullptr, {});
  check(options);
  const KnownSubject known = known_subject(capture, options);
  const Camera& camera = capture.camera;
  // what is given is of the whole picture: checked before a window is cut out of it
  if (options.picture) require_picture(*options.picture, capture);
  if (options.disparity) given_disparity(options, camera);
  const Window window = zoom_window(camera, holds_photosites(capture));
  const Window upright = options.transposed ? Window{window.y, window.x, window.height, window.width} : window;
  std::optional<Image> mask;
  if (person_mask) {
    Camera seen = camera;
    if (options.transposed) std::swap(seen.width_px, seen.height_px);
    mask = cut(*person_mask, upright, seen);
  }
  const Capture part = zoomed(capture, window);
  PortraitResult result = run_whole(part, zoomed(options, window, camera), mask, progress, &camera, window);
  if (known.source == "capture" && !part.face_px) {
    result.warnings.emplace_back("the center of the capture's /face_px is cut away by the zoom; not used");
  }
  result.window_px = {upright.x, upright.y, upright.width, upright.height};
  for (Face& face : result.faces) {
    face.x += upright.x;
    face.y += upright.y;
  }
  return result;
}

}  // namespace dualpixel::pipeline
