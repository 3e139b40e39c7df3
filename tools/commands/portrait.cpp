#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <system_error>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/read_mask.h"
#include "capture/views.h"
#include "evaluation/report/calibration_page.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/disparity/noise_model.h"
#include "pipeline/portrait/describe_run.h"
#include "pipeline/portrait/disparity_settings.h"
#include "pipeline/portrait/photograph.h"
#include "pipeline/portrait/plain_pair.h"
#include "pipeline/portrait/result_io.h"
#include "pipeline/portrait/run_portrait.h"
#include "pipeline/portrait/subject.h"
#include "pipeline/portrait/zoom.h"
#include "pipeline/segmentation/network.h"
#include "tools/cli/map_options.h"
#include "tools/cli/number_range.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

using pipeline::PortraitOptions;
using pipeline::PortraitResult;

/// Numbers with commas between them, as one value of the command line.
template <std::size_t N>
struct NumberList {
  std::array<double, N> values{};
  NumberList() = default;  // lest CLI11 take it for something made of one number
};

/// CLI11 finds this to read a NumberList.
template <std::size_t N>
bool lexical_cast(const std::string& text, NumberList<N>& list) {
  std::istringstream in(text);
  for (std::size_t i = 0; i < N; ++i) {
    if (i > 0 && in.get() != ',') return false;
    in >> list.values[i];
  }
  return in && in.peek() == std::istringstream::traits_type::eof();
}

template <std::size_t N>
CLI::Validator must_read(const std::string& form) {
  const auto check = [form](const std::string& text) {
    NumberList<N> list;
    return lexical_cast(text, list) ? std::string() : printable(text) + ": must read " + form + " in pixels";
  };
  return {check, ""};
}

struct PortraitCommand {
  std::string capture;
  pipeline::PlainPair pair;
  std::string output;
  std::string mode = "auto";
  std::string matcher{pipeline::kDefaultMatcher};
  std::optional<double> auto_ms, auto_error_dp_px;
  MapFiles maps;
  std::string mask;
  bool true_mask = false;
  bool bf16 = false;
  std::vector<NumberList<4>> faces;
  std::optional<NumberList<2>> tap;
  std::string calibration;
  std::string match_lens;
  pipeline::Aperture aperture;
  bool recover_highlights = false;
  bool no_noise = false;
  bool zoom = false;
  std::uint64_t seed = PortraitOptions().seed;
  std::vector<std::string> assignments;  ///< of --set

  bool plain() const { return !pair.left.empty(); }
  bool photograph() const {
    std::error_code unreadable;  // then it is no photograph, and the capture's reader says why
    return !plain() && std::filesystem::is_regular_file(capture, unreadable);
  }
  bool mask_given() const { return true_mask || !mask.empty(); }
  /// --auto or --auto-error, if either is given.
  const char* automatic() const { return auto_ms ? "--auto" : auto_error_dp_px ? "--auto-error" : nullptr; }
};

/// What needs views, or a capture's folder.
void require_usable_by_a_photograph(const PortraitCommand& command) {
  if (!command.photograph()) return;
  const std::string name = printable(command.capture);
  if (command.mode == "dp" || command.mode == "dp+seg") {
    throw InputError(
        fmt::format("--mode {}: {}: a photograph has no dual-pixel views; choose auto or seg", command.mode, name));
  }
  for (const auto& [option, given] : {std::pair{"--match-lens", !command.match_lens.empty()},
                                      {"--disparity", command.maps.any()},
                                      {"--auto", command.auto_ms.has_value()},
                                      {"--auto-error", command.auto_error_dp_px.has_value()},
                                      {"--calibration", !command.calibration.empty()},
                                      {"--true-mask", command.true_mask}}) {
    if (given) throw InputError(fmt::format("{}: {}: cannot be used with a photograph; leave it out", option, name));
  }
}

/// What the command line says by itself, before any file is read.
PortraitOptions options_of(const PortraitCommand& command) {
  const pipeline::Matcher* matcher = command.maps.any() ? nullptr : &pipeline::matcher_named(command.matcher);
  PortraitOptions options = matcher ? pipeline::default_options(matcher->name) : PortraitOptions();
  for (const std::string& assignment : command.assignments) {
    try {
      set_field(pipeline::fields(options), assignment);
      if (command.automatic()) {
        pipeline::require_not_chosen(assignment);  // the matcher is not known yet
      } else {
        pipeline::require_read_by(matcher, assignment.substr(0, assignment.find('=')));
      }
    } catch (const InputError& error) {
      throw InputError(std::string("--set ") + error.what());
    }
  }
  options.mode = value_named(pipeline::kModes, command.mode, "--mode");
  options.seed = command.seed;
  options.synthetic_noise = !command.no_noise;
  options.transposed = command.pair.vertical_split;
  options.zoom = command.zoom;
  options.defocus.bokeh.aperture = command.aperture;
  options.defocus.bokeh.recover_highlights = command.recover_highlights;
  for (const NumberList<4>& face : command.faces) {
    options.faces.push_back({face.values[0], face.values[1], face.values[2], face.values[3]});
  }
  if (!command.match_lens.empty()) {
    options.match_pupil_mm = pipeline::pupil_mm_of_lens("--match-lens", command.match_lens);
    if (options.mode == pipeline::Mode::seg)
      throw InputError("--match-lens: needs disparity, which mode seg does not compute; choose dp or dp+seg");
  }
  if (options.mode == pipeline::Mode::seg && command.maps.any()) {
    throw InputError("--mode seg: uses no disparity; leave out --disparity, or choose dp or dp+seg");
  }
  if (options.mode == pipeline::Mode::seg && command.automatic()) {
    throw InputError(
        fmt::format("{}: chooses how disparity is found, which mode seg does not use; leave it out, or choose dp or "
                    "dp+seg",
                    command.automatic()));
  }
  if (options.mode == pipeline::Mode::dp && command.mask_given()) {
    throw InputError("--mode dp: uses no person mask; leave out --mask and --true-mask, or choose dp+seg or seg");
  }
  if (command.plain() == !command.capture.empty()) {
    throw InputError("portrait: give a capture folder, a photograph, or the two views by --left FILE --right FILE");
  }
  require_usable_by_a_photograph(command);
  check(options);
  return options;
}

/// The disparity that the user names, if any.
std::optional<pipeline::GivenDisparity> given_disparity(const MapFiles& files) {
  if (!files.any()) return {};
  std::vector<std::string> problems;
  DisparityMaps maps = read_maps(files, problems);
  if (!problems.empty()) throw InputError(fmt::format("{}", fmt::join(problems, "; ")));
  return pipeline::GivenDisparity{std::move(maps.disparity_dp_px),
                                  std::move(maps.confidence),
                                  std::move(maps.sigma_dp_px),
                                  "--disparity " + printable(files.disparity),
                                  "--confidence " + printable(files.confidence),
                                  "--sigma " + printable(files.sigma)};
}

/// Maps of the size that the pictures have in their files get the sides of the capture.
void make_even(pipeline::GivenDisparity& disparity, const pipeline::PlainPairCapture& pair) {
  for (Image* map : {&disparity.disparity_dp_px, &disparity.confidence, &disparity.sigma_dp_px}) {
    if (map->width == pair.width && map->height == pair.height) *map = pipeline::even_sided(*map);
  }
}

/// What --match-lens needs to know of a plain pair's camera.
void require_lens(const pipeline::PlainPair& pair, const Camera& camera) {
  if (camera.alpha > 0 && camera.focal_length_mm > 0 && camera.f_number > 0) return;
  throw InputError((pair.metadata.empty() ? "--metadata" : printable(pair.metadata)) +
                   ": /alpha, focal_length_mm, f_number: are required by --match-lens: disparity over blur diameter in "
                   "pixels of the pair, and the lens that took it");
}

/// The capture, whose picture goes to the options where it is given apart. `assumed`: what a photograph or a pair does
/// not say.
Capture read_input(const PortraitCommand& command, PortraitOptions& options, std::vector<std::string>& assumed) {
  if (command.plain()) {
    pipeline::PlainPairCapture pair = pipeline::read_plain_pair(command.pair);
    if (options.match_pupil_mm) require_lens(command.pair, pair.capture.camera);
    if (options.calibration) options.calibration = calibration_of(command.pair, pair, std::move(*options.calibration));
    options.picture = std::move(pair.picture);
    assumed = std::move(pair.assumed);
    if (options.disparity) make_even(*options.disparity, pair);
    return std::move(pair.capture);
  }
  if (command.photograph()) {
    pipeline::Photograph photograph = pipeline::read_photograph(command.capture);
    options.picture = std::move(photograph.picture);
    assumed = std::move(photograph.assumed);
    return std::move(photograph.capture);
  }
  std::error_code unreadable;  // then the capture's reader says why
  if (!std::filesystem::exists(command.capture, unreadable) && !unreadable) {
    throw InputError(printable(command.capture) + ": no such capture folder or picture");
  }
  return read_capture(command.capture, command.true_mask);
}

/// What --auto or --auto-error chooses for this capture.
struct AutoChoice {
  const pipeline::DisparitySetting* setting = nullptr;  ///< none: nobody asked for a choice
  double cpu_ms = 0;                                    ///< as charted
};

/// Puts the choice into the options.
AutoChoice choose_setting(const PortraitCommand& command, const Capture& capture, PortraitOptions& options) {
  if (!command.automatic()) return {};
  if (!has_views(capture)) {
    throw InputError(fmt::format("{}: {}: has no dual-pixel views to find disparity in; leave it out",
                                 command.automatic(), printable(command.capture)));
  }
  pipeline::Megapixels size = pipeline::megapixels_of(capture);
  if (options.zoom) {
    const pipeline::Window seen = pipeline::zoom_window(capture.camera, holds_photosites(capture));
    const double share = 1e-6 * seen.width * seen.height / size.picture;
    size = {share * size.picture, share * size.view};
  }
  const pipeline::DisparitySetting& setting = command.auto_ms ? pipeline::best_setting(*command.auto_ms, size)
                                                              : pipeline::fastest_setting(*command.auto_error_dp_px);
  options = with_setting(std::move(options), setting);
  return {&setting, cpu_ms(setting, size)};
}

void say_choice(const PortraitCommand& command, const AutoChoice& choice, nlohmann::ordered_json& provenance) {
  if (!choice.setting) return;
  const pipeline::DisparitySetting& setting = *choice.setting;
  provenance["auto"] = {
      {"setting", setting.name}, {"charted_cpu_ms", choice.cpu_ms}, {"promised_error_dp_px", setting.error_dp_px}};
  if (command.auto_ms) provenance["auto"]["most_cpu_ms"] = *command.auto_ms;
  if (command.auto_error_dp_px) provenance["auto"]["most_error_dp_px"] = *command.auto_error_dp_px;
  std::cerr << fmt::format(
      "{}: {} ({}): some {:.1f} ms of CPU time for disparity, at most {:g} DP px on charted scenes\n",
      command.automatic(), setting.name, command_line(setting), choice.cpu_ms, setting.error_dp_px);
}

/// The mask that the user names, if any. Takes the truth out of the capture.
std::optional<Image> given_mask(const PortraitCommand& command, Capture& capture) {
  std::optional<Image> mask;
  if (command.true_mask) {
    if (!capture.truth) throw InputError(printable(command.capture) + ": --true-mask: this capture has no truth");
    mask = std::move(capture.truth->person_mask);
    capture.truth.reset();
  } else if (!command.mask.empty()) {
    mask = read_mask(command.mask);
    const bool turned = command.pair.vertical_split;  // the user's picture is upright
    const Camera& camera = capture.camera;
    require_shape(*mask, turned ? camera.height_px : camera.width_px, turned ? camera.width_px : camera.height_px,
                  "--mask " + printable(command.mask));
  }
  return mask;
}

std::string absolute(const std::string& path) { return std::filesystem::absolute(path).lexically_normal().string(); }

nlohmann::ordered_json provenance_of(const PortraitCommand& command, const Capture& capture,
                                     const PortraitOptions& options, const PortraitResult& result) {
  nlohmann::ordered_json provenance = {{"program", "dualpixel " DUALPIXEL_VERSION}};
  if (command.plain()) {
    provenance["left"] = absolute(command.pair.left);
    provenance["right"] = absolute(command.pair.right);
    provenance["left_hash"] = file_hash(command.pair.left);
    provenance["right_hash"] = file_hash(command.pair.right);
    provenance["split"] = command.pair.vertical_split ? "vertical" : "horizontal";
    if (!command.pair.metadata.empty()) provenance["metadata"] = absolute(command.pair.metadata);
  } else if (command.photograph()) {
    provenance["picture"] = absolute(command.capture);
    provenance["picture_hash"] = file_hash(command.capture);
  } else {
    provenance["capture"] = absolute(command.capture);
    provenance["capture_hash"] = file_hash(command.capture + "/capture.json");
  }
  if (!command.maps.any() && !command.photograph()) provenance["matcher"] = options.matcher;
  for (const auto& [name, file] : {std::pair{"disparity", &command.maps.disparity},
                                   {"confidence", &command.maps.confidence},
                                   {"sigma", &command.maps.sigma}}) {
    if (!file->empty()) provenance[name] = absolute(*file);
  }
  if (options.match_pupil_mm) provenance["match_lens"] = command.match_lens;
  if (!command.calibration.empty()) {
    provenance["calibration"] = absolute(command.calibration);
    provenance["calibration_hash"] = file_hash(command.calibration + "/calibration.json");
  }
  provenance.update(describe_run(capture, options, result));
  if (!result.faces.empty()) {
    provenance["person_network"] = command.bf16 ? "bf16" : "f32";
  } else if (command.mask_given()) {
    provenance["mask"] = command.true_mask ? "truth" : command.mask;
  }
  return provenance;
}

/// The region that --tap means.
pipeline::Face tapped(const NumberList<2>& tap, const Camera& camera, bool transposed) {
  const double x = tap.values[0], y = tap.values[1];
  const auto [width, height] =
      transposed ? std::pair{camera.height_px, camera.width_px} : std::pair{camera.width_px, camera.height_px};
  if (!(x >= 0 && x <= width && y >= 0 && y <= height)) {
    throw InputError(fmt::format("--tap {:g},{:g}: must lie in the picture of {} x {}", x, y, width, height));
  }
  return pipeline::tapped_region(x, y, camera);
}

/// The tap in the pixels of the picture that people are looked for in.
std::optional<pipeline::Face> tap_in_sight(const PortraitOptions& options, const Capture& capture) {
  if (!options.tap || !options.zoom) return options.tap;
  PortraitOptions tap_alone;
  tap_alone.tap = options.tap;
  tap_alone.transposed = options.transposed;
  return pipeline::zoomed(tap_alone, pipeline::zoom_window(capture.camera, holds_photosites(capture)), capture.camera)
      .tap;
}

PortraitResult run_with_progress(const PortraitCommand& command, const Capture& capture, const PortraitOptions& options,
                                 const std::optional<Image>& mask) {
  Progress bar("portrait");
  try {
    return pipeline::run_portrait(capture, options, mask, [&](const std::string&, double fraction) { bar(fraction); });
  } catch (const pipeline::NobodyFound& error) {
    throw InputError(fmt::format("{}: {}", printable(command.capture), error.what()));
  }
}

/// What matcher split takes the pixel's split for, where neither --set nor the camera says it.
std::optional<std::string> assumed_split(const PortraitOptions& options, pipeline::Mode mode, const Camera& camera) {
  const bool matched = mode != pipeline::Mode::seg && !options.disparity;
  if (!matched || options.matcher != "split" || options.matching.split_match.alpha > 0) return {};
  if (pipeline::alpha_of_camera(pipeline::of_camera({}, camera).alpha) > 0) return {};
  const std::string instead = camera.alpha > 0 ? fmt::format(", not {:g} as stated", camera.alpha) : "";
  return fmt::format("disparity over blur diameter (alpha) is {:g}, a phone's{}", pipeline::kPhoneAlpha, instead);
}

void run(const PortraitCommand& command) {
  PortraitOptions options = options_of(command);
  if (!command.calibration.empty()) options.calibration = evaluation::read_calibration_folder(command.calibration);
  options.disparity = given_disparity(command.maps);
  const bool looks_for_people = options.mode != pipeline::Mode::dp && !command.mask_given();
  std::optional<pipeline::PersonNetwork> network;
  if (looks_for_people && (command.mode != "auto" || command.photograph() || pipeline::has_person_network())) {
    network.emplace(pipeline::built_in_weights(), 1,
                    command.bf16 ? pipeline::Precision::bf16 : pipeline::Precision::f32);
  } else if (command.bf16) {
    throw InputError(looks_for_people
                         ? "--bf16: this build has no person network (oneDNN); leave it out"
                         : "--bf16: people are not looked for in mode dp, or where a mask is given; leave it out");
  }
  { const NewFolder writable(command.output, "result.json"); }  // before the work, not after it

  std::vector<std::string> assumed;
  Capture capture = read_input(command, options, assumed);
  const AutoChoice choice = choose_setting(command, capture, options);
  if (command.tap) options.tap = tapped(*command.tap, capture.camera, options.transposed);
  if (network) {
    const std::optional<pipeline::Face> tap = tap_in_sight(options, capture);
    options.find_people = [&, tap](const Image& picture, const std::vector<pipeline::Face>& seeds) {
      return tap && seeds.empty() ? pipeline::find_people_at(picture, *tap, *network)
                                  : pipeline::find_people(picture, seeds, *network, options.seed_faces);
    };
  }
  const std::optional<Image> mask = given_mask(command, capture);

  const PortraitResult result = run_with_progress(command, capture, options, mask);
  print_warnings(result.warnings);
  nlohmann::ordered_json provenance = provenance_of(command, capture, options, result);
  say_choice(command, choice, provenance);
  if (const auto split = assumed_split(options, result.mode, capture.camera)) assumed.push_back(*split);
  if (!assumed.empty()) {
    provenance["assumed"] = assumed;
    std::cerr << fmt::format("{}: assumed: {}\n", printable(command.plain() ? command.pair.left : command.capture),
                             fmt::join(assumed, "; "));
  }
  pipeline::write_result(result, provenance, command.output);
}

/// --left, --right and what goes with them. Returns --left.
CLI::Option* add_pair_options(CLI::App& command, pipeline::PlainPair& pair, CLI::Option* capture) {
  CLI::Option* left =
      command
          .add_option("--left", pair.left,
                      "Instead of a capture, the left view: PNG, TIFF or JPEG, sRGB unless it declares linear light")
          ->type_name("FILE")
          ->excludes(capture);
  CLI::Option* right =
      command.add_option("--right", pair.right, "The right view: right(x + d) = left(x), d < 0 in front of the focus")
          ->type_name("FILE")
          ->needs(left);
  left->needs(right);
  command
      .add_option("--metadata", pair.metadata,
                  "JSON about the views: encoding (srgb, linear), black_level, white_level, noise, focus_distance_m, "
                  "face_px; alpha, for matchers likelihood and split, and --match-lens; for that also focal_length_mm, "
                  "f_number")
      ->type_name("FILE")
      ->needs(left);
  command
      .add_option_function<std::string>(
          "--split", [&pair](const std::string& split) { pair.vertical_split = split == "vertical"; },
          "How the views were split: horizontal (default), or vertical where disparity runs down the columns")
      ->check(CLI::IsMember({"horizontal", "vertical"}))
      ->type_name("TEXT")
      ->needs(left);
  return left;
}

}  // namespace

void add_portrait(CLI::App& program) {
  auto command = std::make_shared<PortraitCommand>();
  CLI::App* sub = program.add_subcommand(
      "portrait",
      "Turn a dual-pixel capture, or any photograph of people, into a portrait with shallow depth of field");
  CLI::Option* capture =
      sub->add_option("capture", command->capture, "Capture folder, or a photograph: JPEG, PNG, TIFF or DNG")
          ->type_name("CAPTURE");
  CLI::Option* left = add_pair_options(*sub, command->pair, capture);
  sub->add_option("-o,--output", command->output, "Result folder to write")->required()->type_name("DIR");
  sub->add_option("--mode", command->mode,
                  "auto: dp+seg where there are views and people, dp without people, seg without views; dp: disparity "
                  "alone; dp+seg: with a person mask; seg: mask alone. Without a mask, people are detected; where none "
                  "are found, the mode becomes dp")
      ->check(CLI::IsMember(names_of(pipeline::kModes)))
      ->capture_default_str();
  std::string matchers = "How to match the views";
  for (const pipeline::Matcher& matcher : pipeline::matchers()) {
    matchers += fmt::format("; {}: {}, up to {} DP px", matcher.name, matcher.description, matcher.range_dp_px({}));
  }
  CLI::Option* matcher = sub->add_option("--matcher", command->matcher, matchers)
                             ->check(CLI::IsMember(names_of(pipeline::matchers())))
                             ->capture_default_str();
  CLI::Option* by_time =
      sub->add_option("--auto", command->auto_ms,
                      "In place of --matcher: matcher and smoothing of the least charted error that take at most MS "
                      "milliseconds of CPU time, all else of a portrait not counted (docs/disparity.md)")
          ->type_name("MS")
          ->check(number_range(0.001, 1e9))
          ->excludes(matcher);
  CLI::Option* by_error =
      sub->add_option("--auto-error", command->auto_error_dp_px,
                      "In place of --matcher: the fastest matcher and smoothing whose error over the charted scenes is "
                      "at most PX DP px, root mean square")
          ->type_name("PX")
          ->check(number_range(0.001, 1000))
          ->excludes(matcher)
          ->excludes(by_time);
  CLI::Option* disparity = add_map_options(*sub, command->maps, "of the views' size, in place of a matcher's");
  for (CLI::Option* other : {matcher, by_time, by_error}) disparity->excludes(other);
  for (const char* of_a_disparity : {"--confidence", "--sigma", "--scale"}) {
    sub->get_option(of_a_disparity)->needs(disparity);
  }
  CLI::Option* mask = sub->add_option("--mask", command->mask,
                                      "Person mask: a picture, white on the person, of the picture's shape in any size")
                          ->type_name("FILE");
  sub->add_flag("--true-mask", command->true_mask, "Take the capture's true person mask")
      ->excludes(mask)
      ->excludes(left);
  sub->add_flag("--bf16", command->bf16,
                "Run the person network in 16-bit floats: several times as fast on processors with AMX, but the result "
                "depends on the processor");
  sub->add_option("--face", command->faces, "A face of a person to keep sharp, in pixels; repeat for several")
      ->type_name("X,Y,WIDTH,HEIGHT")
      ->check(must_read<4>("X,Y,WIDTH,HEIGHT"))
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  sub->add_option(
         "--tap", command->tap,
         "Point to focus on where no face is in focus, in pixels; without --face, the person there gets the mask, if "
         "their face is found")
      ->type_name("X,Y")
      ->check(must_read<2>("X,Y"));
  sub->add_option("--calibration", command->calibration,
                  "Calibration folder of this camera, as `dualpixel calibrate` writes it: corrects disparity, and for "
                  "simulated cameras says how kernels change over the field; with --left, --metadata must state "
                  "focus_distance_m")
      ->type_name("DIR");
  sub->add_option("--match-lens", command->match_lens,
                  "Physically true blur: that of this lens on a full-frame camera, e.g. f/1.4@50mm-equivalent")
      ->type_name("LENS");
  sub->add_option("--blades", command->aperture.blades,
                  "Aperture blades: blur to polygons of 3 to 16 sides, one corner up behind the focus; 0: discs")
      ->check(CLI::Range(0, 16))
      ->type_name("N");
  sub->add_option("--cats-eye", command->aperture.cats_eye,
                  "Cat's-eye blur towards the corners: share of the radius that is cut off there on either side")
      ->check(number_range(0.0, 0.9))
      ->type_name("SHARE");
  sub->add_flag("--zoom", command->zoom,
                "The middle of the picture alone, two thirds as wide and high, as the paper has it; not enlarged");
  sub->add_flag("--recover-highlights", command->recover_highlights,
                "Estimate the true brightness of clipped highlights before the blur");
  sub->add_flag("--no-noise", command->no_noise, "Leave out the synthetic noise on what the blur has smoothed");
  sub->add_option("--seed", command->seed, "Seed of the synthetic noise")
      ->check(any_seed())
      ->type_name("N")
      ->capture_default_str();
  sub->add_option("--set", command->assignments, "Set an option of a stage, e.g. layers.bands=8; --options lists them")
      ->type_name("FIELD=VALUE")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  sub->add_flag_callback(
      "--options",
      [command] {
        std::cout << pipeline::describe_fields(command->matcher);
        throw CLI::Success();
      },
      "List what --set can change, with the matcher's default, range, unit and source, and exit");
  add_threads_option(*sub);
  sub->footer(
      "Example:\n  dualpixel portrait out/capture -o out/portrait\n"
      "  dualpixel portrait photo.jpg -o out/portrait\n"
      "  dualpixel portrait --left l.png --right r.png -o out/portrait --matcher likelihood\n"
      "  dualpixel portrait out/capture -o out/portrait --auto 200\n"
      "  dualpixel portrait out/capture -o out/portrait --disparity d.npy --sigma s.npy");
  sub->callback([command] { run(*command); });
}

}  // namespace dualpixel::tools
