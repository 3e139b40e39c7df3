#include "simulator/simulate.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/render/adaptive.h"
#include "simulator/render/truth.h"
#include "simulator/sampling/hash.h"
#include "simulator/scene/gltf.h"
#include "simulator/sensor/hand_shake.h"
#include "simulator/sensor/motion.h"

namespace dualpixel::simulator {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string beside(const std::string& json_path, const std::string& name) {
  return (std::filesystem::path(json_path).parent_path() / name).string();
}

glm::dvec3 to_vec(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

void read_camera(Fields camera, Simulation& s, double& focus_distance_m) {
  camera.text("node", s.camera_node);
  if (camera.has("position_m") || camera.has("look_at_m") || camera.has("up")) {
    if (camera.has("node")) camera.fail("node", "give either a camera node or position_m and look_at_m, not both");
    CameraPose& pose = s.pose.emplace();
    camera.required("position_m").numbers("position_m", pose.position_m.data(), 3);
    camera.required("look_at_m").numbers("look_at_m", pose.look_at_m.data(), 3);
    camera.numbers("up", pose.up.data(), 3);
    const glm::dvec3 forward = to_vec(pose.look_at_m) - to_vec(pose.position_m);
    if (!(glm::length(glm::cross(forward, to_vec(pose.up))) > 1e-9 * glm::length(forward))) {
      camera.fail("look_at_m", "must differ from position_m, and not lie along `up` from it");
    }
  }
  camera.number("focus_distance_m", focus_distance_m, 0.001, kInfinity);
  camera.done();
}

void read_sensor(Fields sensor, SensorOptions& s) {
  sensor.integer("width_px", s.width_px, 2, 32768);
  sensor.integer("height_px", s.height_px, 4, 32768);
  if (s.width_px % 2 != 0)
    sensor.fail("width_px", fmt::format("{}: must be even: the mosaic repeats every 2", s.width_px));
  if (s.height_px % 4 != 0) {
    sensor.fail("height_px", fmt::format("{}: must be a multiple of 4: a DP pixel is 4 photosites high", s.height_px));
  }
  sensor.number("pixel_pitch_um", s.pixel_pitch_um, 0.1, 100);
  sensor.numbers("electrons_per_lux_s", s.electrons_per_lux_s.data(), 3);
  for (double value : s.electrons_per_lux_s) {
    if (!(value > 0 && value < 1e9)) sensor.fail("electrons_per_lux_s", fmt::format("{}: must lie in (0, 1e9)", value));
  }
  sensor.number("full_well_e", s.full_well_e, 1, 1e7);
  sensor.number("read_noise_e", s.read_noise_e, 0, 1e4);
  sensor.number("read_noise_after_gain_dn", s.read_noise_after_gain_dn, 0, 1e4);
  sensor.number("prnu", s.prnu, 0, 0.5);
  sensor.number("dark_offset_dn", s.dark_offset_dn, 0, 1e4);
  sensor.integer("fixed_pattern_seed", s.fixed_pattern_seed, 0, std::numeric_limits<std::uint64_t>::max());
  sensor.integer("dp_downsample_x", s.dp_downsample_x, 1, 2);
  sensor.integer("dp_downsample_y", s.dp_downsample_y, 1, 4);
  const int dp_x = s.dp_downsample_x, dp_y = s.dp_downsample_y;
  if (!(dp_x == 2 && (dp_y == 2 || dp_y == 4)) && !(dp_x == 1 && dp_y == 1)) {
    sensor.fail("dp_downsample_y", fmt::format("{} x {}: a DP pixel must be 2 x 4, 2 x 2 or 1 x 1", dp_x, dp_y));
  }
  sensor.integer("bits", s.bits, 8, 16);
  sensor.number("black_level_dn", s.black_level_dn, 0, std::exp2(s.bits) / 2);
  sensor.done();
}

void read_burst(Fields burst, Simulation& s) {
  burst.integer("frames", s.burst_frames, 1, 1000);
  burst.number("hand_shake", s.hand_shake, 0, 100);
  burst.integer("hand_shake_seed", s.hand_shake_seed, 0, std::numeric_limits<std::uint64_t>::max());
  s.frame_interval_s = std::max(s.frame_interval_s, s.exposure.time_s);
  burst.number("interval_s", s.frame_interval_s, s.exposure.time_s, 1e5);
  burst.integer("exposure_poses", s.exposure_poses, 1, 64);
  burst.boolean("animation", s.animation);
  burst.done();
}

void read_environment_fields(Fields environment, Simulation& s, const std::string& path) {
  environment.choice("model", s.environment_model, {"none", "constant", "sky", "file"});
  if (s.environment_model == "constant") {
    environment.required("nits").numbers("nits", s.environment_nits.data(), 3);
    for (double value : s.environment_nits) {
      if (!(value >= 0 && value <= 1e9)) environment.fail("nits", fmt::format("{}: must lie in [0, 1e9]", value));
    }
  } else if (s.environment_model == "sky") {
    environment.number("sun_elevation_deg", s.sky.sun_elevation_deg, -90, 90);
    environment.number("sun_azimuth_deg", s.sky.sun_azimuth_deg, -360, 360);
    environment.number("zenith_nits", s.sky.zenith_nits, 0, 1e9);
    environment.number("horizon_nits", s.sky.horizon_nits, 0, 1e9);
    environment.number("ground_nits", s.sky.ground_nits, 0, 1e9);
    environment.number("sun_glow_nits", s.sky.sun_glow_nits, 0, 1e9);
    environment.number("sun_glow_width_deg", s.sky.sun_glow_width_deg, 0.5, 90);
  } else if (s.environment_model == "file") {
    std::string name;
    environment.required("path").text("path", name);
    s.environment_path = beside(path, name);
    environment.number("nits_per_unit", s.environment_nits_per_unit, 0, 1e9);
  }
  environment.done();
}

void read_render(Fields render, Simulation& s) {
  render.integer("samples_per_pixel", s.render.samples_per_pixel, 1, 65536);
  const auto share = [&](const char* key, std::optional<double>& value) {
    if (render.has(key)) render.number(key, value.emplace(), 1e-4, 100);
  };
  share("noise_fraction", s.noise_fraction);
  share("error", s.render_error);
  if (render.has("time_budget_s")) render.number("time_budget_s", s.time_budget_s.emplace(), 0, 1e7);
  if (s.noise_fraction.has_value() + s.render_error.has_value() + s.time_budget_s.has_value() > 1) {
    const char* field = s.time_budget_s ? "time_budget_s" : "error";
    render.fail(field, "give one of noise_fraction, error and time_budget_s");
  }
  render.integer("photograph_samples_per_pixel", s.photograph_samples_per_pixel, 1, 65536);
  render.integer("all_in_focus_samples_per_pixel", s.all_in_focus_samples_per_pixel, 1, 65536);
  render.integer("max_bounces", s.render.max_bounces, 0, 1000);
  render.integer("seed", s.render.seed, 0, std::numeric_limits<std::uint64_t>::max());
  render.done();
}

bool moves(const Simulation& s) { return s.hand_shake > 0 || s.animation; }

/// What simulate() holds at once for each photosite: two views, two truth pictures, the geometry, electrons, frames;
/// where something moves, the motion to each frame and the sum over the poses of an exposure.
void check_memory(Fields& sensor, const Simulation& s) {
  const double frame_bytes = 2 + 4.0 / (s.sensor.dp_downsample_x * s.sensor.dp_downsample_y);
  const double bytes_per_photosite =
      4 * (2 * 3 + 2 * 3 + 9 + 2) + frame_bytes * s.burst_frames + (moves(s) ? 4 * 2 * (s.burst_frames + 3) : 0);
  const double needed = bytes_per_photosite * s.sensor.width_px * s.sensor.height_px;
  const double available = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (needed > available) {
    sensor.fail("width_px",
                fmt::format("{} x {} with a burst of {} needs {:.0f} GB; this machine has {:.0f} GB", s.sensor.width_px,
                            s.sensor.height_px, s.burst_frames, needed / 1e9, available / 1e9));
  }
}

Matrix4 row_major(const glm::mat4& m) {
  Matrix4 result;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) result[4 * row + column] = m[column][row];
  }
  return result;
}

const CameraNode& camera_node(const Simulation& s, const Scene& scene) {
  if (scene.cameras.empty()) {
    throw InputError(printable(s.gltf_path) +
                     ": /cameras: none: name a file with a camera node, or give camera.position_m and look_at_m");
  }
  if (s.camera_node.empty()) return scene.cameras.front();
  std::vector<std::string> names;
  for (const CameraNode& node : scene.cameras) {
    if (node.name == s.camera_node) return node;
    names.push_back(node.name);
  }
  throw InputError(fmt::format("{}: /nodes: no camera node is named '{}'{}", printable(s.gltf_path),
                               printable(s.camera_node), did_you_mean(s.camera_node, names)));
}

bool gives_light(const Scene& scene) {
  const auto shines = [](const Material& m) { return m.unlit || m.emission_nits != glm::vec3(0); };
  return !scene.lights.empty() || !scene.environment.radiance_nits.empty() ||
         std::any_of(scene.meshes.begin(), scene.meshes.end(),
                     [&](const Mesh& mesh) { return shines(scene.materials[mesh.material]); });
}

constexpr std::uint32_t kMostSamples = 16384;

ErrorTarget scaled(ErrorTarget target, double factor) {
  for (double& value : target.per_nit) value *= factor;
  for (double& value : target.constant) value *= factor;
  return target;
}

/// The map whose samples take about `budget_s` with the pilot's own; `share`: the error over `target` that it expects.
SampleMap samples_in_time(const Simulation& s, const RenderScene& world, const CameraView& view,
                          const ErrorTarget& target, double budget_s, double& share, const ProgressCallback& progress) {
  constexpr std::uint32_t kMostPilotSamples = 32;  // about six a photosite in all
  const auto start = std::chrono::steady_clock::now();
  const Pilot pilot = probe_tiles(world, view, s.render, target, kMostPilotSamples, progress);
  const double spent_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double affordable = std::max(budget_s - spent_s, 0.0) / spent_s * pilot.samples;
  double low = 1e-4, high = 1e4;
  for (int step = 0; step < 24; ++step) {
    share = std::sqrt(low * high);
    (share_samples(pilot, share, kMostSamples).total_samples() > affordable ? low : high) = share;
  }
  share = high;
  SampleMap map = share_samples(pilot, share, kMostSamples);
  // The fewest samples may do better than what the time would have allowed.
  double sum = 0;
  for (float ratio : map.error_ratio) sum += static_cast<double>(ratio) * ratio;
  share = std::sqrt(sum / static_cast<double>(map.error_ratio.size()));
  return map;
}

void describe_sampling(const SampleMap& map, const Views& views, const ErrorTarget& target, double unit_per_nit,
                       Truth& truth) {
  truth.samples = truth.render_sigma = Image(map.width_px, map.height_px);
  for (std::size_t i = 0; i < map.samples.size(); ++i) {
    const Tile tile = tile_at(map, static_cast<int>(i));
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) {
        const int c = cfa_color(x, y);
        const double nits = 0.5 * (views.left.at(x, y, c) + views.right.at(x, y, c));
        truth.samples.at(x, y) = static_cast<float>(tile.samples);
        truth.render_sigma.at(x, y) = static_cast<float>(unit_per_nit * map.error_ratio[i] *
                                                         std::sqrt(target.per_nit[c] * nits + target.constant[c]));
      }
    }
  }
}

void scale(Image& image, double factor) {
  for (float& value : image.data) value = static_cast<float>(value * factor);
}

glm::mat4 world_from_camera(const Simulation& s, const Scene& scene) {
  if (s.pose) {
    const glm::dvec3 forward = glm::normalize(to_vec(s.pose->look_at_m) - to_vec(s.pose->position_m));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, to_vec(s.pose->up)));
    const glm::dvec3 down = glm::cross(forward, right);
    return glm::mat4(glm::dmat4(glm::dvec4(right, 0), glm::dvec4(down, 0), glm::dvec4(forward, 0),
                                glm::dvec4(to_vec(s.pose->position_m), 1)));
  }
  // glTF's camera looks along -z with y up
  return camera_node(s, scene).world_from_node * glm::mat4(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);
}

/// Scene and camera at one time of a burst.
struct Moment {
  std::unique_ptr<Scene> scene;            ///< only where it is not the first frame's
  std::unique_ptr<RenderScene> own_world;  ///< of `scene`
  const RenderScene* world = nullptr;
  CameraView view;
};

Moment moment(const Simulation& s, const RenderScene& first_world, const CameraView& first, double time_s) {
  Moment now{nullptr, nullptr, &first_world, first};
  if (s.animation && time_s != 0) {
    now.scene = std::make_unique<Scene>(load_scene(s, time_s));
    now.own_world = std::make_unique<RenderScene>(*now.scene);
    now.world = now.own_world.get();
    now.view.world_from_camera = world_from_camera(s, *now.scene);
  }
  const glm::dmat4 shake = hand_shake(s.hand_shake_seed, time_s, s.hand_shake);
  now.view.world_from_camera = glm::mat4(glm::dmat4(now.view.world_from_camera) * shake);
  return now;
}

/// The mean over the poses of frame `frame`'s exposure, each of which takes its share of the samples of `map`.
Views render_frame(const Simulation& s, const RenderScene& first_world, const CameraView& first, SampleMap map,
                   int frame, const ProgressCallback& progress) {
  const int poses = moves(s) ? s.exposure_poses : 1;
  for (std::uint32_t& samples : map.samples) samples = std::max(samples / poses, 1u);
  Views mean;
  for (int i = 0; i < poses; ++i) {
    const double middle_s = frame * s.frame_interval_s;
    const Moment now = moment(s, first_world, first, middle_s + ((i + 0.5) / poses - 0.5) * s.exposure.time_s);
    RenderOptions options = s.render;
    if (frame > 0 || i > 0) options.seed = hash(s.render.seed, 4, frame * poses + i);
    Views views =
        render_views(*now.world, now.view, options, map, [&](double fraction) { progress((i + fraction) / poses); });
    if (poses > 1) scale(views.left, 1.0 / poses), scale(views.right, 1.0 / poses);
    if (i == 0) {
      mean = std::move(views);
      continue;
    }
    for (std::size_t j = 0; j < mean.left.data.size(); ++j) {
      mean.left.data[j] += views.left.data[j];
      mean.right.data[j] += views.right.data[j];
    }
  }
  return mean;
}

}  // namespace

Simulation read_simulation(const nlohmann::json& json, const std::string& path) {
  Simulation s;
  s.json = json;
  s.path = path;
  Fields root(s.json, path);
  int version = 1;
  root.required("version").integer("version", version, 1, 1);
  std::string gltf;
  root.required("gltf").text("gltf", gltf);
  s.gltf_path = beside(path, gltf);
  double focus_distance_m = 1;
  read_camera(root.object("camera"), s, focus_distance_m);
  s.lens = read_lens(root.has("lens") ? root.raw("lens") : nlohmann::json::object(), path, "/lens", focus_distance_m);
  Fields sensor = root.object("sensor");
  read_sensor(sensor, s.sensor);
  Fields exposure = root.object("exposure");
  exposure.number("time_s", s.exposure.time_s, 1e-7, 1e4);
  exposure.number("iso", s.exposure.iso, 1, 1e6);
  exposure.done();
  read_burst(root.object("burst"), s);
  read_environment_fields(root.object("environment"), s, path);
  root.number("unlit_white_nits", s.unlit_white_nits, 0, 1e9);
  if (root.has("face_px")) {
    s.face_px.emplace();
    root.numbers("face_px", s.face_px->data(), 4);
    const auto& f = *s.face_px;
    if (f[0] < 0 || f[1] < 0 || !(f[2] > 0) || !(f[3] > 0)) {
      root.fail("face_px", "must be x, y, width, height in photosites, width and height above 0");
    }
  }
  Fields truth = root.object("truth");
  truth.number("photograph_aperture_scale", s.photograph_aperture_scale, 0, 100);
  truth.done();
  read_render(root.object("render"), s);
  root.done();
  check_memory(sensor, s);
  return s;
}

Scene load_scene(const Simulation& s, double time_s) {
  Scene scene = read_gltf(s.gltf_path, s.animation ? std::optional(time_s) : std::nullopt);
  scene.unlit_white_nits = static_cast<float>(s.unlit_white_nits);
  if (s.environment_model == "constant") {
    const glm::vec3 nits(s.environment_nits[0], s.environment_nits[1], s.environment_nits[2]);
    scene.environment = {2, 1, {nits, nits}};
  } else if (s.environment_model == "sky") {
    scene.environment = make_sky(s.sky);
  } else if (s.environment_model == "file") {
    scene.environment = read_environment(s.environment_path, static_cast<float>(s.environment_nits_per_unit));
  }
  if (!gives_light(scene)) {
    throw InputError(printable(s.gltf_path) +
                     ": no light: give the scene file an environment, or the glTF file lights or emissive materials");
  }
  return scene;
}

SensorGrid sensor_grid(const Simulation& s) {
  return {s.sensor.width_px,
          s.sensor.height_px,
          s.sensor.pixel_pitch_um * 1e-6,
          {0.5 * s.sensor.width_px, 0.5 * s.sensor.height_px}};
}

Camera describe_camera(const Simulation& s) {
  Camera c;
  c.name = "simulated " + s.lens.name;
  c.width_px = s.sensor.width_px;
  c.height_px = s.sensor.height_px;
  c.pixel_pitch_um = s.sensor.pixel_pitch_um;
  c.dp_downsample_x = s.sensor.dp_downsample_x;
  c.dp_downsample_y = s.sensor.dp_downsample_y;
  const ThinLens& thin = s.lens.thin;
  c.focal_length_mm = thin.focal_length_m * 1e3;
  c.f_number = thin.f_number;
  c.focus_distance_m = thin.focus_distance_m;
  const glm::dvec2 centre = sensor_grid(s).principal_point_px;
  c.principal_point_px = {centre.x, centre.y};
  constexpr const char* kSplitNames[] = {"hard", "ramp", "microlens", "table"};
  c.split = kSplitNames[static_cast<int>(s.lens.split.kind)];
  c.alpha = s.lens.split.alpha(thin.rim_slope());
  return c;
}

CameraView place_camera(const Simulation& s, const Scene& scene) {
  try {
    return {world_from_camera(s, scene), LensSampler(s.lens, sensor_grid(s))};
  } catch (const std::invalid_argument& error) {
    throw InputError(printable(s.path) + ": /lens: " + error.what());
  }
}

ErrorTarget sensor_noise(const Simulation& s, double lux_per_nit) {
  ErrorTarget target;
  for (int c = 0; c < 3; ++c) {
    const double electrons_per_nit = lux_per_nit * s.exposure.time_s * s.sensor.electrons_per_lux_s[c];
    const double after_gain_e = s.sensor.read_noise_after_gain_dn / gain_dn_per_electron(s.sensor, s.exposure.iso);
    const double read_nits = std::hypot(s.sensor.read_noise_e, after_gain_e) / electrons_per_nit;
    target.per_nit[c] = 1 / electrons_per_nit;
    target.constant[c] = std::max(read_nits * read_nits, 1e-12);
  }
  return target;
}

Capture simulate(const Simulation& s, const Scene& scene, const StageCallback& stage) {
  const auto report = [&](const char* name) -> ProgressCallback {
    if (!stage) return {};
    return [&stage, name](double fraction) { stage(name, fraction); };
  };
  const CameraView view = place_camera(s, scene);
  const RenderScene world(scene);

  Capture capture;
  capture.camera = describe_camera(s);
  capture.exposure = describe_exposure(s.sensor, s.exposure);
  capture.face_px = s.face_px;

  // Truth pictures in the frames' normalised signal: a neutral grey reads the same in all channels after the sensor's
  // colour response is divided out, as white balance does.
  const double lux_s_per_nit = view.lens.lux_per_nit() * s.exposure.time_s;
  const double unit_per_nit = lux_s_per_nit / capture.exposure.lux_s_per_unit;
  capture.truth = trace_truth(world, view);
  scale(capture.truth->disparity_dp_px, 2.0 / s.sensor.dp_downsample_x);  // it takes DP pixels to be 2 photosites wide
  RenderOptions options = s.render;
  options.ideal_aperture_scale = 0;
  options.samples_per_pixel = s.all_in_focus_samples_per_pixel;
  options.seed = hash(s.render.seed, 1);
  capture.truth->all_in_focus = undivided(render_views(world, view, options, report("all-in-focus image")));
  options.ideal_aperture_scale = s.photograph_aperture_scale;
  options.samples_per_pixel = s.photograph_samples_per_pixel;
  options.seed = hash(s.render.seed, 2);
  capture.truth->photograph = undivided(render_views(world, view, options, report("wide-aperture photograph")));
  capture.truth->photograph_aperture_scale = s.photograph_aperture_scale;
  scale(capture.truth->all_in_focus, unit_per_nit);
  scale(capture.truth->photograph, unit_per_nit);

  const int rendered_frames = moves(s) ? s.burst_frames : 1;
  std::optional<ErrorTarget> target;
  SampleMap map = uniform_map(s.sensor.width_px, s.sensor.height_px, s.render.samples_per_pixel);
  if (s.time_budget_s) {
    target = sensor_noise(s, view.lens.lux_per_nit());
    double share = 0;
    map = samples_in_time(s, world, view, *target, *s.time_budget_s / rendered_frames, share,
                          report("error of the two views"));
    capture.provenance["noise_fraction_reached"] = share;
  } else if (s.noise_fraction || s.render_error) {
    const double share = s.noise_fraction ? *s.noise_fraction : *s.render_error / unit_per_nit;
    target = scaled(s.noise_fraction ? sensor_noise(s, view.lens.lux_per_nit()) : ErrorTarget{.constant = {1, 1, 1}},
                    share * share);
    const Pilot pilot = probe_tiles(world, view, s.render, *target, kMostSamples, report("error of the two views"));
    map = share_samples(pilot, 1, kMostSamples);
  }
  Image electrons;
  for (int i = 0; i < s.burst_frames; ++i) {
    const Moment middle = moment(s, world, view, i * s.frame_interval_s);
    if (i < rendered_frames) {
      const Views views = render_frame(s, world, view, map, i, [&](double fraction) {
        if (stage) stage("left and right view", (i + fraction) / rendered_frames);
      });
      if (i == 0 && target) describe_sampling(map, views, *target, unit_per_nit, *capture.truth);
      if (i > 0) capture.truth->motion.push_back(trace_motion(world, view, middle.world->scene, middle.view));
      electrons = expected_electrons(views.left, views.right, s.sensor, s.exposure, view.lens.lux_per_nit());
    }
    capture.frames.push_back(expose(electrons, s.sensor, s.exposure, hash(s.render.seed, 3, i)));
    capture.frames.back().camera_from_world = row_major(glm::inverse(middle.view.world_from_camera));
    if (stage) stage("sensor", (i + 1.0) / s.burst_frames);
  }
  capture.provenance["scene"] = s.json;
  return capture;
}

}  // namespace dualpixel::simulator
