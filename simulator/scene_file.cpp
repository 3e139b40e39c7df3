#include "simulator/scene_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "capture/path_beside.h"
#include "simulator/lens/lens_file.h"
#include "simulator/scene_file_names.h"

namespace dualpixel::simulator {
namespace {

constexpr double kFocusAtInfinity_m = std::numeric_limits<double>::infinity();

/// Far enough for any scene, and near enough for rays: Embree refuses coordinates of 2^60 and more.
void read_vector(Fields& camera, const char* name, glm::dvec3& vector) {
  constexpr double kMost = 1e6;  // as for nodes of glTF
  camera.numbers(name, glm::value_ptr(vector), 3);
  for (int i = 0; i < 3; ++i) {
    if (std::abs(vector[i]) > kMost) {
      camera.fail(name, fmt::format("{}: must be 3 numbers in [{}, {}]", vector[i], -kMost, kMost));
    }
  }
}

/// Returns the path of the camera file, empty where none is named.
std::string read_camera(Fields camera, Simulation& s, double& focus_distance_m) {
  std::string file;
  if (camera.has("file")) {
    camera.text("file", file);
    file = path_beside(s.path, file);
  }
  camera.text("node", s.camera_node);
  if (camera.has("position_m") || camera.has("look_at_m") || camera.has("up")) {
    if (camera.has("node")) camera.fail("node", "give either a camera node or position_m and look_at_m, not both");
    CameraPose& pose = s.pose.emplace();
    read_vector(camera.required("position_m"), "position_m", pose.position_m);
    read_vector(camera.required("look_at_m"), "look_at_m", pose.look_at_m);
    read_vector(camera, "up", pose.up);
    const glm::dvec3 forward = pose.look_at_m - pose.position_m;
    if (!(glm::length(glm::cross(forward, pose.up)) > 1e-9 * glm::length(forward))) {
      camera.fail("look_at_m", "must differ from position_m, and not lie along `up` from it");
    }
  }
  camera.number("focus_distance_m", focus_distance_m, 0.001, kFocusAtInfinity_m);
  camera.done();
  return file;
}

/// In photosites, or as `face` in shares of the picture's sides, which suits any size of it.
void read_face(Fields& root, Simulation& s) {
  if (root.has("face_px")) root.numbers("face_px", s.face_px.emplace().data(), 4);
  if (!root.has("face")) return;
  if (s.face_px) root.fail("face", "give either face or face_px");
  std::array<double, 4> shares{};
  root.numbers("face", shares.data(), 4);
  const auto& [x, y, width, height] = shares;
  constexpr double kOne = 1 + 1e-9;  // shares that meet at 1 may round above it
  if (!(x >= 0 && y >= 0 && width > 0 && height > 0 && x + width <= kOne && y + height <= kOne)) {
    root.fail("face",
              fmt::format("{} {} {} {}: must be x, y, width, height in shares of the picture's sides, and lie in it", x,
                          y, width, height));
  }
  s.face_px = {x * s.sensor.width_px, y * s.sensor.height_px, width * s.sensor.width_px, height * s.sensor.height_px};
}

constexpr std::uint64_t kAnySeed = std::numeric_limits<std::uint64_t>::max();

constexpr OptionRange<Simulation> kBurstRanges[] = {
    {"frames", &Simulation::burst_frames, 1, 1000},
    {"hand_shake", &Simulation::hand_shake, 0, 100},
    {"exposure_poses", &Simulation::exposure_poses, 1, 64},
};
constexpr OptionRange<Simulation> kEnvironmentFileRanges[] = {
    {"nits_per_unit", &Simulation::environment_nits_per_unit, 0, 1e9},
};
constexpr OptionRange<Simulation> kTruthRanges[] = {
    {"photograph_aperture_scale", &Simulation::photograph_aperture_scale, 0.001, 100},
};
/// Numbers of samples of truth's pictures, where they differ from the views'.
struct TruthSamples {
  const char* name;
  std::optional<int> Simulation::*value;
};
constexpr TruthSamples kTruthSamples[] = {
    {"photograph_samples_per_pixel", &Simulation::photograph_samples_per_pixel},
    {"all_in_focus_samples_per_pixel", &Simulation::all_in_focus_samples_per_pixel},
};
constexpr int kMostSamples = 65536;
constexpr OptionRange<Simulation> kSceneRanges[] = {{"unlit_white_nits", &Simulation::unlit_white_nits, 0, 1e9}};
constexpr double kLongestInterval_s = 1e5;
constexpr double kSmallestModel_m = 1e-3, kLargestModel_m = 1e6;

void read_burst(Fields burst, Simulation& s) {
  read_ranges(burst, s, kBurstRanges);
  burst.integer("hand_shake_seed", s.hand_shake_seed, 0, kAnySeed);
  s.frame_interval_s = std::max(s.frame_interval_s, s.exposure.time_s);
  burst.number("interval_s", s.frame_interval_s, s.exposure.time_s, kLongestInterval_s);
  burst.boolean("animation", s.animation);
  burst.done();
}

void read_environment_fields(Fields environment, Simulation& s, const std::string& path) {
  read_named(environment, "model", s.environment_model, kEnvironmentModels);
  switch (s.environment_model) {
    case EnvironmentModel::none:
      break;
    case EnvironmentModel::constant:
      environment.required("nits").numbers("nits", s.environment_nits.data(), 3);
      break;
    case EnvironmentModel::sky:
      read_ranges(environment, s.sky, kSkyRanges);
      break;
    case EnvironmentModel::file: {
      std::string name;
      environment.required("path").text("path", name);
      s.environment_path = path_beside(path, name);
      read_ranges(environment, s, kEnvironmentFileRanges);
      break;
    }
  }
  environment.done();
}

/// Truth's photograph looks through an ideal lens, through the capture's own opened wide, or through that of another
/// file, focused alike. The latter's aperture is its own. Whatever their pixels' split, both halves together are the
/// picture.
void read_truth_fields(Fields truth, const nlohmann::json& own_lens, double focus_distance_m, Simulation& s) {
  std::string lens = "ideal";
  const bool scaled = truth.has("photograph_aperture_scale");
  read_ranges(truth, s, kTruthRanges);
  truth.text("photograph_lens", lens);
  truth.done();
  if (lens == "ideal") return;
  nlohmann::json json = {{"file", lens}};
  if (lens == "own") {
    json = own_lens;
    json["f_number"] = s.lens.thin.f_number / s.photograph_aperture_scale;
  }
  try {
    s.photograph = read_lens(json, s.path, "/lens", focus_distance_m);
  } catch (const InputError& error) {
    truth.fail("photograph_lens", printable(lens) + ": " + error.what() + did_you_mean(lens, {"ideal", "own"}));
  }
  if (lens != "own" && scaled) {
    truth.fail("photograph_aperture_scale", "is that of the lens file that photograph_lens names: leave it out");
  }
  s.photograph->split = {};
  constexpr double kWidestInAir = 0.5;  // sine condition, image in air
  if (const double f_number = s.photograph->thin.f_number; f_number < kWidestInAir) {
    s.warnings.push_back(fmt::format("{}: /truth/photograph_lens: {} opens to f/{:.3g}: no lens is wider than f/{}",
                                     printable(s.path), printable(lens), f_number, kWidestInAir));
  }
  s.photograph_aperture_scale = s.photograph->thin.pupil_diameter_m() / s.lens.thin.pupil_diameter_m();
}

/// What rendering may be asked to reach, instead of a number of samples.
struct RenderGoal {
  const char* name;
  std::optional<double> Simulation::*value;
  double low, high;
};
constexpr RenderGoal kRenderGoals[] = {{"noise_fraction", &Simulation::noise_fraction, 1e-4, 100},
                                       {"error", &Simulation::render_error, 1e-4, 100},
                                       {"time_budget_s", &Simulation::time_budget_s, 0, 1e7}};

void read_render(Fields render, Simulation& s) {
  read_ranges(render, s.render, kRenderRanges);
  read_ranges(render, s.light, kLightCacheRanges);
  for (const auto& [name, goal, low, high] : kRenderGoals) {
    if (render.has(name)) render.number(name, (s.*goal).emplace(), low, high);
  }
  for (const auto& [name, samples] : kTruthSamples) {
    if (render.has(name)) render.integer(name, (s.*samples).emplace(), 1, kMostSamples);
  }
  render.integer("seed", s.render.seed, 0, kAnySeed);
  render.done();
}

std::optional<OptionProblem> check_burst(const Simulation& s) {
  if (auto problem = check_ranges(s, kBurstRanges)) return problem;
  if (const auto why = out_of_range(s.frame_interval_s, s.exposure.time_s, kLongestInterval_s)) {
    return OptionProblem{"interval_s", *why};
  }
  const double rolls_s = 1e-6 * s.sensor.row_time_us * s.sensor.height_px;
  if (s.burst_frames > 1 && rolls_s > s.frame_interval_s) {
    return OptionProblem{"interval_s", fmt::format("{}: is shorter than all rows of a frame take, {:.4g} s by "
                                                   "sensor.row_time_us",
                                                   s.frame_interval_s, rolls_s)};
  }
  return std::nullopt;
}

std::optional<OptionProblem> check_environment(const Simulation& s) {
  for (double value : s.environment_nits) {
    if (!(value >= 0 && value <= 1e9)) return OptionProblem{"nits", fmt::format("{}: must lie in [0, 1e9]", value)};
  }
  if (auto problem = check(s.sky)) return problem;
  return check_ranges(s, kEnvironmentFileRanges);
}

std::optional<OptionProblem> check_render(const Simulation& s) {
  if (auto problem = check(s.render)) return problem;
  if (auto problem = check_ranges(s.light, kLightCacheRanges)) return problem;
  if (s.noise_fraction.has_value() + s.render_error.has_value() + s.time_budget_s.has_value() > 1) {
    return OptionProblem{s.time_budget_s ? "time_budget_s" : "error",
                         "give one of noise_fraction, error and time_budget_s"};
  }
  for (const auto& [name, goal, low, high] : kRenderGoals) {
    if (!(s.*goal)) continue;
    if (const auto why = out_of_range(*(s.*goal), low, high)) return OptionProblem{name, *why};
  }
  for (const auto& [name, samples] : kTruthSamples) {
    if (!(s.*samples)) continue;
    if (const auto why = out_of_range(*(s.*samples), 1, kMostSamples)) return OptionProblem{name, *why};
  }
  return std::nullopt;
}

std::optional<OptionProblem> check_model_size(const Simulation& s) {
  if (!s.model_size_m) return std::nullopt;
  if (s.animation) return OptionProblem{"model_size_m", "cannot be given where burst.animation moves the scene"};
  const auto why = out_of_range(*s.model_size_m, kSmallestModel_m, kLargestModel_m);
  return why ? std::optional(OptionProblem{"model_size_m", *why}) : std::nullopt;
}

std::optional<OptionProblem> check_face(const Simulation& s) {
  if (!s.face_px) return std::nullopt;
  constexpr double kMost_px = 65536;
  const auto& f = *s.face_px;
  const bool is_box = f[0] >= 0 && f[1] >= 0 && f[2] > 0 && f[3] > 0;
  if (is_box && *std::max_element(f.begin(), f.end()) <= kMost_px) return std::nullopt;
  return OptionProblem{
      "face_px", fmt::format("{:g}, {:g}, {:g}, {:g}: must be x, y, width, height in photosites: x and y in [0, {}], "
                             "width and height above 0, at most {}",
                             f[0], f[1], f[2], f[3], kMost_px, kMost_px)};
}

/// Lens and sensor of the camera that the scene file names, or none.
struct CameraParts {
  nlohmann::json lens = nlohmann::json::object(), sensor = nlohmann::json::object();
};

/// A camera file, checked by itself so that its faults are told of it; its lens where it is used.
CameraParts read_camera_file(const nlohmann::json& json, const std::string& path, double focus_distance_m,
                             bool lens_used) {
  Fields root(json, path);
  int version = 1;
  std::string text;
  root.required("version").integer("version", version, 1, 1);
  for (const char* key : {"name", "source", "derived"}) root.text(key, text);
  CameraParts parts;
  if (root.has("lens")) parts.lens = root.raw("lens");
  if (lens_used) read_lens(parts.lens, path, "/lens", focus_distance_m);
  require_valid(within("sensor", check(read_sensor(root.object("sensor")))), path);
  if (root.has("sensor")) parts.sensor = root.raw("sensor");
  root.done();
  each_file_name_of_lens(parts.lens, [&](std::string& name) {  // they are relative to `path`
    name = std::filesystem::absolute(path_beside(path, name)).string();
  });
  return parts;
}

/// What the scene says laid over what its camera file says. A lens that names its own file or model is another one.
CameraParts camera_parts(Fields& root, const std::string& camera_path, double focus_distance_m, Simulation& s) {
  const nlohmann::json none = nlohmann::json::object();
  const nlohmann::json& lens = root.has("lens") ? root.raw("lens") : none;
  const nlohmann::json& sensor = root.has("sensor") ? root.raw("sensor") : none;
  if (camera_path.empty()) return {lens, sensor};
  const bool another = !lens.is_object() || lens.contains("file") || lens.contains("model");
  CameraParts parts = read_camera_file(read_json_file(camera_path), camera_path, focus_distance_m, !another);
  if (another && !parts.lens.empty()) {
    s.warnings.push_back(
        fmt::format("{}: /lens: hides the lens of {}, whose sensor alone is used; take both by lens=null",
                    printable(s.path), printable(camera_path)));
  }
  parts.lens = another ? lens : lens_laid_over(std::move(parts.lens), lens);
  if (sensor.is_object())
    parts.sensor.update(sensor);
  else
    parts.sensor = sensor;
  return parts;
}

}  // namespace

SensorOptions read_sensor(Fields sensor) {
  SensorOptions s;
  read_ranges(sensor, s, kSensorRanges);
  sensor.numbers("electrons_per_lux_s", s.electrons_per_lux_s.data(), 3);
  read_named(sensor, "readout", s.readout, kReadouts);
  sensor.numbers("color_matrix", s.color_matrix.data(), 9);
  sensor.numbers("illuminant", s.illuminant.data(), 3);
  for (const double value : s.illuminant) {
    if (const auto why = out_of_range(value, 1e-3, 1e3)) sensor.fail("illuminant", *why);
  }
  const double green = s.illuminant[1];
  for (double& value : s.illuminant) value /= green;
  sensor.integer("fixed_pattern_seed", s.fixed_pattern_seed, 0, kAnySeed);
  sensor.done();
  return s;
}

Simulation read_simulation(const nlohmann::json& json, const std::string& path) {
  Simulation s;
  s.json = json;
  s.path = path;
  Fields root(s.json, path);
  int version = 1;
  root.required("version").integer("version", version, 1, 1);
  std::string gltf;
  root.required("gltf").text("gltf", gltf);
  s.gltf_path = path_beside(path, gltf);
  double focus_distance_m = 1;
  const std::string camera_path = read_camera(root.object("camera"), s, focus_distance_m);
  const CameraParts parts = camera_parts(root, camera_path, focus_distance_m, s);
  s.lens = read_lens(parts.lens, path, "/lens", focus_distance_m);
  s.sensor = read_sensor(Fields(parts.sensor, path, "/sensor"));
  Fields exposure = root.object("exposure");
  read_ranges(exposure, s.exposure, kExposureRanges);
  exposure.done();
  read_burst(root.object("burst"), s);
  read_environment_fields(root.object("environment"), s, path);
  read_ranges(root, s, kSceneRanges);
  if (root.has("model_size_m"))
    root.number("model_size_m", s.model_size_m.emplace(), kSmallestModel_m, kLargestModel_m);
  read_face(root, s);
  read_truth_fields(root.object("truth"), parts.lens, focus_distance_m, s);
  read_render(root.object("render"), s);
  root.done();
  require_valid(check(s), path);
  check_memory(s, 0);
  if (!camera_path.empty()) {  // what was rendered, whatever becomes of the camera's file
    s.json["camera"].erase("file");
    s.json["lens"] = parts.lens;
    s.json["sensor"] = parts.sensor;
  }
  return s;
}

LensOfFile read_lens_of(nlohmann::json json, const std::string& path, std::optional<double> focus_distance_m) {
  const auto has = [&](const char* key) { return json.is_object() && json.contains(key); };
  if (has("gltf")) {
    if (focus_distance_m) json["camera"]["focus_distance_m"] = *focus_distance_m;
    Simulation s = read_simulation(json, path);
    return {std::move(s.lens), s.sensor, "/lens"};
  }
  const double distance_m = focus_distance_m.value_or(1);
  if (!has("lens") && !has("sensor")) return {read_lens(json, path, "", distance_m), {}, ""};
  const CameraParts parts = read_camera_file(json, path, distance_m, true);
  LensOfFile found{read_lens(parts.lens, path, "/lens", distance_m), {}, "/lens"};
  if (!parts.sensor.empty()) found.sensor = read_sensor(Fields(parts.sensor, path, "/sensor"));
  return found;
}

std::optional<OptionProblem> check(const Simulation& s) {
  if (auto problem = within("sensor", check(s.sensor))) return problem;
  if (auto problem = within("exposure", check(s.exposure))) return problem;
  if (auto problem = within("sensor", check_dark(s.sensor, s.exposure))) return problem;
  if (auto problem = within("burst", check_burst(s))) return problem;
  if (auto problem = within("environment", check_environment(s))) return problem;
  if (auto problem = check_ranges(s, kSceneRanges)) return problem;
  if (auto problem = check_model_size(s)) return problem;
  if (auto problem = check_face(s)) return problem;
  if (auto problem = within("truth", check_ranges(s, kTruthRanges))) return problem;
  return within("render", check_render(s));
}

bool moves(const Simulation& s) { return s.hand_shake > 0 || s.animation; }

int poses_of(const Simulation& s) { return moves(s) ? s.exposure_poses : 1; }

void check_memory(const Simulation& s, double scene_bytes) {
  // Held at once for each photosite: two views and their mean over the burst, two truth pictures, the geometry,
  // electrons, frames; samples and the error of each picture; where something moves, the motion to each frame and the
  // sum over the poses of an exposure.
  const double frame_bytes = 2 + 4.0 / (s.sensor.dp_downsample_x * s.sensor.dp_downsample_y);
  const bool by_error = s.noise_fraction || s.render_error || s.time_budget_s;
  const double bytes_per_photosite = 4 * (2 * 3 + 2 * 3 + 2 * 3 + 9 + 2 + (by_error ? 5 : 0)) +
                                     frame_bytes * s.burst_frames + (moves(s) ? 4 * 2 * (s.burst_frames + 3) : 0);
  const double needed = bytes_per_photosite * s.sensor.width_px * s.sensor.height_px + scene_bytes;
  const double available = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (needed > available) {
    throw InputError(fmt::format(
        "{}: /sensor/width_px: {} x {} with a burst of {} needs {:.0f} GB; this machine has {:.0f} GB",
        printable(s.path), s.sensor.width_px, s.sensor.height_px, s.burst_frames, needed / 1e9, available / 1e9));
  }
}

}  // namespace dualpixel::simulator
