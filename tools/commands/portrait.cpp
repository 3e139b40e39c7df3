#include "pipeline/portrait/portrait.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/read_mask.h"
#include "evaluation/report/calibration_page.h"
#include "pipeline/portrait/matchable.h"
#include "pipeline/portrait/plain_pair.h"
#include "pipeline/portrait/result_io.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

const std::map<std::string, pipeline::Mode> kModes = {
    {"dp", pipeline::Mode::dp}, {"dp+seg", pipeline::Mode::dp_seg}, {"seg", pipeline::Mode::seg}};

constexpr double kMostStretch = 0.02;  ///< of a mask to the picture's shape
constexpr double kTapSize = 0.1;       ///< side of the face that a tap stands for, of the picture's shorter side

const std::map<pipeline::Mode, std::string> kModeNames = {
    {pipeline::Mode::dp, "dp"}, {pipeline::Mode::dp_seg, "dp+seg"}, {pipeline::Mode::seg, "seg"}};

struct PortraitCommand {
  std::string capture;
  pipeline::PlainPair pair;
  std::string output;
  std::string mode = "dp";
  std::string matcher = "paper";
  std::string mask;
  bool true_mask = false;
  bool bf16 = false;
  std::vector<std::string> faces;
  std::string tap;
  std::string calibration;
  std::string match_lens;
  pipeline::Aperture aperture;
  bool recover_highlights = false;
  bool no_noise = false;
  std::uint64_t seed = pipeline::PortraitOptions().seed;
};

/// The entrance pupil of a lens named as "f/1.4@50mm-equivalent": what a lens of that focal length and f-number has in
/// front of a full-frame sensor.
double pupil_mm_of(const std::string& lens) {
  double f_number = 0, focal_length_mm = 0;
  int end = 0;
  const bool read = std::sscanf(lens.c_str(), "f/%lf@%lfmm-equivalent%n", &f_number, &focal_length_mm, &end) == 2;
  if (!read || end != static_cast<int>(lens.size()) || !(f_number >= 0.5 && f_number <= 64) ||
      !(focal_length_mm >= 1 && focal_length_mm <= 2000)) {
    throw InputError("--match-lens " + printable(lens) +
                     ": must read like f/1.4@50mm-equivalent, f-number 0.5 to 64, focal length 1 to 2000 mm");
  }
  return focal_length_mm / f_number;
}

/// In the picture with its axes exchanged.
pipeline::Face exchanged(const pipeline::Face& face) { return {face.y, face.x, face.height, face.width}; }

struct KnownFaces {
  std::vector<pipeline::Face> faces;  ///< that the user names, or else the capture's own, largest first
  std::optional<pipeline::Face> tap;  ///< a region around where the user taps
  std::string source;                 ///< of the faces, for result.json
};

/// A mask is stretched to the picture. What whole pixels round is no other shape: sides of a pair are even.
void require_shape(const Image& mask, const PortraitCommand& command, const Camera& camera) {
  const bool turned = command.pair.vertical_split;  // the user's are not
  const double width = turned ? camera.height_px : camera.width_px,
               height = turned ? camera.width_px : camera.height_px;
  const double excess = std::abs(mask.width * height - mask.height * width);
  if (excess <= std::max({kMostStretch * mask.width * height, width, height})) return;
  throw InputError(fmt::format("--mask {}: {} x {} pixels; must have the shape of the picture, {} x {}",
                               printable(command.mask), mask.width, mask.height, width, height));
}

/// All in pixels of the capture's pictures.
KnownFaces known_faces(const PortraitCommand& command, const Capture& capture) {
  const bool turned = command.pair.vertical_split;  // the user's are not
  const int width = turned ? capture.camera.height_px : capture.camera.width_px;
  const int height = turned ? capture.camera.width_px : capture.camera.height_px;
  const auto in_picture = [&](double x, double y) { return x >= 0 && x <= width && y >= 0 && y <= height; };
  KnownFaces known;
  for (const std::string& text : command.faces) {
    pipeline::Face face;
    int end = 0;
    const bool read =
        std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%n", &face.x, &face.y, &face.width, &face.height, &end) == 4;
    if (!read || end != static_cast<int>(text.size()) || !(face.width > 0 && face.height > 0) ||
        !in_picture(face.x + face.width / 2, face.y + face.height / 2)) {
      throw InputError(
          fmt::format("--face {}: must read X,Y,WIDTH,HEIGHT in pixels, its centre in the picture of {} x {}",
                      printable(text), width, height));
    }
    known.faces.push_back(turned ? exchanged(face) : face);
    known.source = "given";
  }
  if (!command.tap.empty()) {
    double x = 0, y = 0;
    int end = 0;
    const bool read = std::sscanf(command.tap.c_str(), "%lf,%lf%n", &x, &y, &end) == 2;
    if (!read || end != static_cast<int>(command.tap.size()) || !in_picture(x, y)) {
      throw InputError(fmt::format("--tap {}: must read X,Y in pixels, in the picture of {} x {}",
                                   printable(command.tap), width, height));
    }
    const double side = kTapSize * std::min(width, height);
    const pipeline::Face face = {x - side / 2, y - side / 2, side, side};
    known.tap = turned ? exchanged(face) : face;
  }
  if (known.faces.empty() && !known.tap && capture.face_px) {
    const auto& [x, y, w, h] = *capture.face_px;
    if (x + w / 2 >= 0 && x + w / 2 <= capture.camera.width_px && y + h / 2 >= 0 &&
        y + h / 2 <= capture.camera.height_px) {
      known.faces.push_back({x, y, w, h});
      known.source = "capture";
    } else {
      std::cerr << "dualpixel: warning: capture: /face_px: its middle lies outside the picture; not used\n";
    }
  }
  std::stable_sort(known.faces.begin(), known.faces.end(),
                   [](const auto& a, const auto& b) { return a.area() > b.area(); });
  return known;
}

/// The faces known beforehand, in pixels of the user's pictures.
std::vector<pipeline::Face> user_faces(const KnownFaces& known, bool turned) {
  std::vector<pipeline::Face> faces = known.faces;
  if (known.tap) faces.push_back(*known.tap);
  for (pipeline::Face& face : faces) face = turned ? exchanged(face) : face;
  return faces;
}

/// find_people on a picture whose axes may be exchanged, as are the faces.
pipeline::FoundPeople people_in(const Image& picture, std::vector<pipeline::Face> faces, bool turned,
                                pipeline::PersonNetwork& network) {
  if (!turned) return pipeline::find_people(picture, faces, network);
  for (pipeline::Face& face : faces) face = exchanged(face);
  pipeline::FoundPeople found = pipeline::find_people(pipeline::transposed(picture), faces, network);
  for (std::vector<pipeline::Face>* found_faces : {&found.faces, &found.detected}) {
    for (pipeline::Face& face : *found_faces) face = exchanged(face);
  }
  found.mask = pipeline::transposed(found.mask);
  return found;
}

/// Of a pair that was transposed to run: as its pictures are.
void transpose_back(pipeline::PortraitResult& result) {
  using Result = pipeline::PortraitResult;
  for (Image Result::*image : {&Result::input, &Result::portrait, &Result::portrait_srgb, &Result::disparity_dp_px,
                               &Result::confidence, &Result::matched_disparity_dp_px, &Result::matched_confidence,
                               &Result::matched_sigma_dp_px, &Result::mask, &Result::blur_radius_px}) {
    result.*image = pipeline::transposed(result.*image);
  }
  for (pipeline::Face& face : result.faces) face = exchanged(face);
}

void run(const PortraitCommand& command) {
  pipeline::PortraitOptions options;
  options.mode = kModes.at(command.mode);
  options.matcher = command.matcher;
  options.seed = command.seed;
  const bool needs_mask = options.mode != pipeline::Mode::dp;
  const bool find_people = needs_mask && command.mask.empty() && !command.true_mask;
  if (!needs_mask && (!command.mask.empty() || command.true_mask)) {
    throw InputError("--mode dp: uses no person mask; leave out --mask and --true-mask, or choose dp+seg or seg");
  }
  options.synthetic_noise = !command.no_noise;
  options.defocus.bokeh.aperture = command.aperture;
  options.defocus.bokeh.aperture.lying = command.pair.vertical_split;
  if (command.recover_highlights) options.defocus.bokeh.recover_highlights = true;
  if (!command.match_lens.empty()) {
    options.match_pupil_mm = pupil_mm_of(command.match_lens);
    if (options.mode == pipeline::Mode::seg) throw InputError("--match-lens: needs disparity, which mode seg has not");
  }
  const bool plain = !command.pair.left.empty();
  if (plain == !command.capture.empty()) {
    throw InputError("portrait: give a capture folder, or the two views by --left FILE --right FILE");
  }
  if (!command.calibration.empty()) options.calibration = evaluation::read_calibration_folder(command.calibration);
  std::optional<pipeline::PersonNetwork> network;
  if (find_people) {
    network.emplace(pipeline::built_in_weights(), 1,
                    command.bf16 ? pipeline::Precision::bf16 : pipeline::Precision::f32);
  } else if (command.bf16) {
    throw InputError("--bf16: nobody is looked for in mode dp, or where a mask is given; leave it out");
  }
  { const NewFolder writable(command.output, "result.json"); }  // before the work, not after it

  Capture capture;
  if (plain) {
    pipeline::PlainPairCapture pair = pipeline::read_plain_pair(command.pair);
    capture = std::move(pair.capture);
    options.picture = std::move(pair.picture);
  } else {
    capture = read_capture(command.capture, command.true_mask);
  }
  if (!plain && options.mode != pipeline::Mode::seg) {
    pipeline::require_matchable(capture.camera, command.capture, "/camera/dp_downsample_x");
  }
  const bool turned = command.pair.vertical_split;
  const KnownFaces known = known_faces(command, capture);
  capture.face_px.reset();  // known has it, where it is of use
  options.faces = known.faces;
  options.tap = known.tap;
  if (find_people) {
    std::vector<pipeline::Face> seeds = known.faces;
    if (known.tap && seeds.empty()) seeds.push_back(*known.tap);
    if (seeds.empty() && !pipeline::has_face_detector()) {
      throw InputError(
          fmt::format("--mode {}: this build has no face detector (dlib): give --face, --tap or --mask", command.mode));
    }
    options.find_people = [&, seeds](const Image& picture) {
      pipeline::FoundPeople found = people_in(picture, seeds, turned, *network);
      if (!anybody_seen(found) && !plain)
        pipeline::require_matchable(capture.camera, command.capture, "/camera/dp_downsample_x");
      return found;
    };
  }
  std::optional<Image> mask;
  if (command.true_mask) {
    if (!capture.truth) throw InputError(printable(command.capture) + ": --true-mask: this capture has no truth");
    mask = std::move(capture.truth->person_mask);
    capture.truth.reset();
  } else if (!command.mask.empty()) {
    mask = read_mask(command.mask);
    require_shape(*mask, command, capture.camera);
    if (turned) mask = pipeline::transposed(*mask);
  }

  Progress bar("portrait");
  pipeline::PortraitResult result =
      pipeline::run_portrait(capture, options, mask, [&](const std::string&, double fraction) { bar(fraction); });
  if (turned) transpose_back(result);
  for (const std::string& warning : result.warnings) std::cerr << "dualpixel: warning: " << warning << '\n';

  const auto absolute = [](const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal().string();
  };
  nlohmann::ordered_json provenance = {{"program", "dualpixel " DUALPIXEL_VERSION}};
  if (plain) {
    provenance["left"] = absolute(command.pair.left);
    provenance["right"] = absolute(command.pair.right);
    provenance["split"] = command.pair.vertical_split ? "vertical" : "horizontal";
    if (!command.pair.metadata.empty()) provenance["metadata"] = absolute(command.pair.metadata);
  } else {
    provenance["capture"] = absolute(command.capture);
    provenance["capture_hash"] = file_hash(command.capture + "/capture.json");
  }
  provenance["mode"] = kModeNames.at(result.mode);
  if (result.mode != options.mode) provenance["mode_asked_for"] = command.mode;
  provenance["matcher"] = command.matcher;
  provenance["seed"] = command.seed;
  if (options.match_pupil_mm) provenance["match_lens"] = command.match_lens;
  if (command.aperture.blades > 0) provenance["blades"] = command.aperture.blades;
  if (command.aperture.cats_eye > 0) provenance["cats_eye"] = command.aperture.cats_eye;
  if (command.recover_highlights) provenance["recover_highlights"] = true;
  if (command.no_noise) provenance["synthetic_noise"] = false;
  if (!command.calibration.empty()) provenance["calibration"] = absolute(command.calibration);
  if (!result.warnings.empty()) provenance["warnings"] = result.warnings;
  const std::vector<pipeline::Face> faces = result.faces.empty() ? user_faces(known, turned) : result.faces;
  for (const pipeline::Face& face : faces) {
    provenance["faces_px"].push_back({face.x, face.y, face.width, face.height});
  }
  if (!faces.empty()) provenance["faces"] = known.source.empty() ? (known.tap ? "tapped" : "detected") : known.source;
  if (!result.faces.empty()) {
    provenance["mask"] = "found";
    provenance["person_weights_hash"] = pipeline::built_in_weights().file_hash;
    provenance["person_network"] = command.bf16 ? "bf16" : "f32";
  } else if (needs_mask && !find_people) {
    provenance["mask"] = command.true_mask ? "truth" : command.mask;
  }
  pipeline::write_result(result, provenance, command.output);
}

}  // namespace

void add_portrait(CLI::App& program) {
  auto command = std::make_shared<PortraitCommand>();
  CLI::App* sub =
      program.add_subcommand("portrait", "Turn a dual-pixel capture into a portrait with shallow depth of field");
  CLI::Option* capture = sub->add_option("capture", command->capture, "Capture folder")->type_name("CAPTURE_DIR");
  pipeline::PlainPair& pair = command->pair;
  CLI::Option* left =
      sub->add_option("--left", pair.left, "In place of a capture, the left view: PNG, TIFF or JPEG, sRGB-encoded")
          ->type_name("FILE")
          ->excludes(capture);
  CLI::Option* right =
      sub->add_option("--right", pair.right, "The right view: right(x + d) = left(x), d < 0 in front of the focus")
          ->type_name("FILE")
          ->needs(left);
  left->needs(right);
  sub->add_option("--metadata", pair.metadata,
                  "JSON about the views: encoding (srgb, linear), black_level, white_level, noise, focus_distance_m, "
                  "face_px")
      ->type_name("FILE")
      ->needs(left);
  sub->add_option_function<std::string>(
         "--split", [&pair](const std::string& split) { pair.vertical_split = split == "vertical"; },
         "How the views were split: horizontal (default), or vertical where disparity runs down the columns")
      ->check(CLI::IsMember({"horizontal", "vertical"}))
      ->type_name("TEXT")
      ->needs(left);
  sub->add_option("-o,--output", command->output, "Result folder to write")->required()->type_name("DIR");
  sub->add_option(
         "--mode", command->mode,
         "dp: disparity alone; dp+seg: with a person mask; seg: mask alone. Where no mask is given, people are "
         "found; where there are none, it becomes dp")
      ->check(CLI::IsMember({"dp", "dp+seg", "seg"}))
      ->capture_default_str();
  sub->add_option("--matcher", command->matcher,
                  "paper: as in Wadhwa et al. 2018, disparities up to 3 DP px; likelihood: up to 16")
      ->check(CLI::IsMember({"paper", "likelihood"}))
      ->capture_default_str();
  CLI::Option* mask = sub->add_option("--mask", command->mask,
                                      "Person mask: a picture, white on the person, of the picture's shape in any size")
                          ->type_name("FILE");
  sub->add_flag("--true-mask", command->true_mask, "Take the capture's true person mask")
      ->excludes(mask)
      ->excludes(left);
  sub->add_flag("--bf16", command->bf16,
                "Find people, where any are looked for, in 16-bit floats: several times as fast where the processor "
                "has AMX, but not the same bytes "
                "on every one");
  sub->add_option("--face", command->faces, "A face of a person to keep sharp, in pixels; repeat for several")
      ->type_name("X,Y,WIDTH,HEIGHT")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  sub->add_option(
         "--tap", command->tap,
         "A point to focus on where no face is sharp, in pixels; without --face it also says whose mask to find")
      ->type_name("X,Y");
  sub->add_option("--calibration", command->calibration,
                  "Calibration folder of this camera, as `dualpixel calibrate` writes it: corrects disparity")
      ->type_name("DIR")
      ->excludes(left);
  sub->add_option("--match-lens", command->match_lens,
                  "Physically true blur: that of this lens in front of a full frame, e.g. f/1.4@50mm-equivalent")
      ->type_name("LENS");
  sub->add_option("--blades", command->aperture.blades,
                  "Blur to regular polygons of so many sides, 3 to 16, one corner up behind the focus; 0: discs")
      ->check(CLI::Range(0, 16))
      ->type_name("N");
  sub->add_option("--cats-eye", command->aperture.cats_eye,
                  "Blur to cat's eyes towards the corners: share of the radius cut off there on either side")
      ->check(CLI::Range(0.0, 0.9))
      ->type_name("SHARE");
  sub->add_flag("--recover-highlights", command->recover_highlights,
                "Blur clipped highlights as bright as they are likely to have been");
  sub->add_flag("--no-noise", command->no_noise, "Leave out the synthetic noise on what the blur has smoothed");
  sub->add_option("--seed", command->seed, "Seed of the synthetic noise")
      ->check(any_seed())
      ->type_name("N")
      ->capture_default_str();
  add_threads_option(*sub);
  sub->footer(
      "Example:\n  dualpixel portrait out/capture -o out/portrait --mode dp+seg\n"
      "  dualpixel portrait --left l.png --right r.png -o out/portrait --matcher likelihood");
  sub->callback([command] { run(*command); });
}

}  // namespace dualpixel::tools
