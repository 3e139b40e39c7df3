#include "simulator/scene_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <limits>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"

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
    sensor.fail("height_px",
                fmt::format("{}: must be a multiple of 4: a DP pixel is up to 4 photosites high", s.height_px));
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
  check_memory(s, 0);
  return s;
}

bool moves(const Simulation& s) { return s.hand_shake > 0 || s.animation; }

void check_memory(const Simulation& s, double scene_bytes) {
  // Held at once for each photosite: two views, two truth pictures, the geometry, electrons, frames; samples and their
  // error; where something moves, the motion to each frame and the sum over the poses of an exposure.
  const double frame_bytes = 2 + 4.0 / (s.sensor.dp_downsample_x * s.sensor.dp_downsample_y);
  const bool by_error = s.noise_fraction || s.render_error || s.time_budget_s;
  const double bytes_per_photosite = 4 * (2 * 3 + 2 * 3 + 9 + 2 + (by_error ? 2 : 0)) + frame_bytes * s.burst_frames +
                                     (moves(s) ? 4 * 2 * (s.burst_frames + 3) : 0);
  const double needed = bytes_per_photosite * s.sensor.width_px * s.sensor.height_px + scene_bytes;
  const double available = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (needed > available) {
    throw InputError(fmt::format(
        "{}: /sensor/width_px: {} x {} with a burst of {} needs {:.0f} GB; this machine has {:.0f} GB",
        printable(s.path), s.sensor.width_px, s.sensor.height_px, s.burst_frames, needed / 1e9, available / 1e9));
  }
}

}  // namespace dualpixel::simulator
