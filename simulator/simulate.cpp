#include "simulator/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "capture/error.h"
#include "simulator/render/adaptive.h"
#include "simulator/render/motion.h"
#include "simulator/render/render_error.h"
#include "simulator/render/truth.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/random_streams.h"
#include "simulator/scene/gltf/gltf.h"
#include "simulator/sensor/hand_shake.h"
#include "simulator/sensor_noise.h"

namespace dualpixel::simulator {
namespace {

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

/// How many frames are rendered, and how many poses each of them is the mean of.
int rendered_frames(const Simulation& s) { return moves(s) ? s.burst_frames : 1; }
int poses(const Simulation& s) { return moves(s) ? s.exposure_poses : 1; }

ErrorTarget scaled(ErrorTarget target, double factor) {
  for (double& value : target.per_nit) value *= factor;
  for (double& value : target.constant) value *= factor;
  return target;
}

/// What each pose of each frame is sampled with.
struct ViewSampling {
  SampleMap map;
  std::optional<ErrorTarget> target;  ///< what map.error_ratio is over
};

/// The map whose samples, of all poses and frames, take what the pilot leaves of the time, with the pilot's own speed.
SampleMap samples_in_time(const Simulation& s, const RenderScene& world, const CameraView& view,
                          const ErrorTarget& target, const SampleLimits& limits, const ProgressCallback& progress) {
  constexpr std::uint32_t kMostPilotSamples = 32;  // about six a photosite in all
  const auto start = std::chrono::steady_clock::now();
  const auto spent_s = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const Pilot pilot = probe_tiles(world, view, s.render, target, kMostPilotSamples, progress);
  const double sample_s = spent_s() / pilot.samples;
  const double maps = 1.0 * rendered_frames(s) * poses(s);
  return share_budget(
      pilot, [&] { return std::max(*s.time_budget_s - spent_s(), 0.0) / (sample_s * maps); }, limits);
}

/// What the two views may be off by where the scene file sets a goal for it.
std::optional<ErrorTarget> goal_of(const Simulation& s, const ErrorTarget& noise, double unit_per_nit) {
  if (s.noise_fraction) return scaled(noise, *s.noise_fraction * *s.noise_fraction);
  if (!s.render_error) return {};
  const double nits = *s.render_error / unit_per_nit;
  return scaled(ErrorTarget{.constant = {1, 1, 1}}, nits * nits);
}

/// Gives `world` a light cache of so many samples that its square error takes half of what the goal allows. Returns how
/// much of it.
double prepare_light(const Simulation& s, RenderScene& world, const CameraView& view, const ErrorTarget& goal) {
  constexpr int kPilotSamples = 16;
  if (!world.light_cache) return 0;
  LightCacheOptions light = s.light;
  light.light_samples = kPilotSamples;
  world.light_cache = std::make_unique<LightCache>(light);
  const double error = estimate_error(world, view, s.render, goal, kPilotSamples).light;
  light.light_samples = light_samples_for(0.5, error, kPilotSamples);
  world.light_cache = std::make_unique<LightCache>(light);
  return light_error(error, kPilotSamples, light.light_samples);
}

/// Each pose draws a net of its own, and errors of independent nets average: of P poses each may have sqrt(P) times
/// the error of their mean. Counts stay powers of two, and at least 2, one for each half of the pupil. `light`: share
/// of the goal's square that the light cache takes.
ViewSampling sample_map_of(const Simulation& s, const RenderScene& world, const CameraView& view,
                           const std::optional<ErrorTarget>& goal, double light, const ProgressCallback& progress) {
  const std::uint32_t count = std::max(poses(s), 1);
  const SampleLimits all;
  const SampleLimits limits{std::max(all.fewest / std::bit_ceil(count), 2u), all.most / std::bit_floor(count)};
  if (s.time_budget_s) {
    const ErrorTarget noise = sensor_noise(s, view.lens.lux_per_nit());
    return {samples_in_time(s, world, view, noise, limits, progress), noise};
  }
  if (goal) {
    const double left = std::max(1 - light, 0.25);
    const Pilot pilot = probe_tiles(world, view, s.render, scaled(*goal, left), all.most, progress);
    ViewSampling sampling{share_samples(pilot, std::sqrt(count), limits), goal};
    for (float& ratio : sampling.map.error_ratio) {  // of a pose, while light is the same for all
      ratio = static_cast<float>(std::sqrt(left * ratio * ratio + light * count));
    }
    return sampling;
  }
  const auto samples = static_cast<std::uint32_t>(s.render.samples_per_pixel);
  const std::uint32_t each = count == 1 ? samples : std::max(std::bit_floor(samples / count), 2u);
  return {uniform_map(s.sensor.width_px, s.sensor.height_px, each), {}};
}

/// RMS over the picture of the error over the target that the mean of all poses has.
double expected_error(const SampleMap& map, int poses_of_frame) {
  double sum = 0;
  for (float ratio : map.error_ratio) sum += static_cast<double>(ratio) * ratio;
  return std::sqrt(sum / static_cast<double>(map.error_ratio.size()) / poses_of_frame);
}

void describe_sampling(const SampleMap& map, const ErrorTarget& target, int poses_of_frame, const Views& views,
                       double unit_per_nit, Truth& truth) {
  truth.samples = truth.render_sigma = Image(map.width_px, map.height_px);
  for (std::size_t i = 0; i < map.samples.size(); ++i) {
    const Tile tile = tile_at(map, static_cast<int>(i));
    const double ratio = map.error_ratio[i] / std::sqrt(poses_of_frame);
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) {
        const int c = cfa_color(x, y);
        const double nits = 0.5 * (views.left.at(x, y, c) + views.right.at(x, y, c));
        truth.samples.at(x, y) = static_cast<float>(tile.samples) * static_cast<float>(poses_of_frame);
        truth.render_sigma.at(x, y) =
            static_cast<float>(unit_per_nit * ratio * std::sqrt(target.per_nit[c] * nits + target.constant[c]));
      }
    }
  }
}

void scale(Image& image, double factor) {
  for (float& value : image.data) value = static_cast<float>(value * factor);
}

/// Scene and camera at one time of a burst.
struct Moment {
  std::unique_ptr<Scene> own_scene;  ///< empty: the first frame's
  CameraView view;
};

Moment moment(const Simulation& s, const CameraView& first, double time_s) {
  Moment now{nullptr, first};
  if (s.animation && time_s != 0) {
    now.own_scene = std::make_unique<Scene>(load_scene(s, time_s));
    now.view.world_from_camera = camera_pose(s, *now.own_scene);
  }
  const glm::dmat4 shake = hand_shake(s.hand_shake_seed, time_s, s.hand_shake);
  now.view.world_from_camera = glm::mat4(glm::dmat4(now.view.world_from_camera) * shake);
  return now;
}

double middle_s(const Simulation& s, int frame) { return frame * s.frame_interval_s; }

double pose_s(const Simulation& s, int frame, int pose) {
  return middle_s(s, frame) + ((pose + 0.5) / poses(s) - 0.5) * s.exposure.time_s;
}

/// Reads the scene at every time that will be rendered, so that none is refused when hours have been spent on others.
void check_animation(const Simulation& s, const Scene& first) {
  std::set<double> times_s;
  for (int frame = 0; frame < s.burst_frames; ++frame) {
    times_s.insert(middle_s(s, frame));
    for (int pose = 0; pose < poses(s); ++pose) times_s.insert(pose_s(s, frame, pose));
  }
  for (const double time_s : times_s) {
    if (time_s == 0) continue;  // `first`
    if (const auto mesh = mesh_that_differs(first, load_scene(s, time_s))) {
      throw InputError(
          fmt::format("{}: /animations: at t = {:.6g} s triangles of mesh {} appear or vanish: must be the "
                      "same in all frames",
                      printable(s.gltf_path), time_s, *mesh));
    }
  }
}

/// What `scene` holds in its large arrays; paged textures need no memory.
double bytes_of(const Scene& scene) {
  const auto size = [](const auto& values) { return static_cast<double>(values.size()) * sizeof(values[0]); };
  double bytes = size(scene.environment.radiance_nits);
  for (const Texture& t : scene.textures) bytes += size(t.rgba) + size(t.decoded);
  for (const Mesh& m : scene.meshes) {
    bytes += size(m.positions) + size(m.normals) + size(m.uv0) + size(m.uv1) + size(m.colors) + size(m.triangles);
    bytes += size(m.placements);
  }
  return bytes;
}

/// The mean over the poses of frame `frame`'s exposure; `middle` is its moment.
Views render_frame(const Simulation& s, const RenderScene& first_world, const CameraView& first, const Moment& middle,
                   const SampleMap& map, int frame, const ProgressCallback& progress) {
  const auto render = [&](const Moment& now, int pose) {
    RenderOptions options = s.render;
    if (frame > 0 || pose > 0) options.seed = hash(s.render.seed, kPoseStream, frame * poses(s) + pose);
    const ProgressCallback part = [&](double fraction) { progress((pose + fraction) / poses(s)); };
    if (!now.own_scene) return render_views(first_world, now.view, options, map, part);
    return render_views(RenderScene(*now.own_scene, s.light), now.view, options, map, part);
  };
  Views mean;
  for (int pose = 0; pose < poses(s); ++pose) {
    const double time_s = pose_s(s, frame, pose);
    Views views = time_s == middle_s(s, frame) ? render(middle, pose) : render(moment(s, first, time_s), pose);
    if (poses(s) > 1) scale(views.left, 1.0 / poses(s)), scale(views.right, 1.0 / poses(s));
    if (pose == 0) {
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

/// What each step of simulate() reports to.
ProgressCallback step_of(const StageCallback& stage, const char* name) {
  if (!stage) return {};
  return [&stage, name](double fraction) { stage(name, fraction); };
}

/// Truth's pictures in the frames' normalized signal: a neutral gray reads the same in all channels after the sensor's
/// color response is divided out, as white balance does.
void add_truth_pictures(const Simulation& s, const RenderScene& world, const CameraView& view, double unit_per_nit,
                        const StageCallback& stage, Truth& truth) {
  RenderOptions options = s.render;
  options.ideal_aperture_scale = 0;
  options.samples_per_pixel = s.all_in_focus_samples_per_pixel;
  options.seed = hash(s.render.seed, kAllInFocusStream);
  truth.all_in_focus = undivided(render_views(world, view, options, step_of(stage, "all-in-focus image")));
  options.ideal_aperture_scale = s.photograph_aperture_scale;
  options.samples_per_pixel = s.photograph_samples_per_pixel;
  options.seed = hash(s.render.seed, kPhotographStream);
  truth.photograph = undivided(render_views(world, view, options, step_of(stage, "wide-aperture photograph")));
  truth.photograph_aperture_scale = s.photograph_aperture_scale;
  scale(truth.all_in_focus, unit_per_nit);
  scale(truth.photograph, unit_per_nit);
}

}  // namespace

Scene load_scene(const Simulation& s, double time_s) {
  Scene scene = read_gltf(s.gltf_path, s.animation ? std::optional(time_s) : std::nullopt);
  scene.unlit_white_nits = static_cast<float>(s.unlit_white_nits);
  if (s.environment_model == EnvironmentModel::constant) {
    const glm::vec3 nits(s.environment_nits[0], s.environment_nits[1], s.environment_nits[2]);
    scene.environment = {2, 1, {nits, nits}};
  } else if (s.environment_model == EnvironmentModel::sky) {
    scene.environment = make_sky(s.sky);
  } else if (s.environment_model == EnvironmentModel::file) {
    scene.environment = read_environment(s.environment_path, static_cast<float>(s.environment_nits_per_unit));
  }
  if (!gives_light(scene)) {
    throw InputError(printable(s.gltf_path) +
                     ": no light: give the scene file an environment, or the glTF file lights or emissive materials");
  }
  return scene;
}

Camera describe_camera(const Simulation& s) {
  Camera c;
  c.name = "simulated " + s.lens.name;
  describe_sensor(s.sensor, c);
  const ThinLens& thin = s.lens.thin;
  c.focal_length_mm = thin.focal_length_m * 1e3;
  c.f_number = thin.f_number;
  c.focus_distance_m = thin.focus_distance_m;
  c.split = name_of(kSplitKinds, s.lens.split.kind);
  c.alpha = s.lens.split.alpha(thin.rim_slope());
  return c;
}

glm::mat4 camera_pose(const Simulation& s, const Scene& scene) {
  if (s.pose) {
    const glm::dvec3 forward = glm::normalize(s.pose->look_at_m - s.pose->position_m);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, s.pose->up));
    const glm::dvec3 down = glm::cross(forward, right);
    return glm::mat4(glm::dmat4(glm::dvec4(right, 0), glm::dvec4(down, 0), glm::dvec4(forward, 0),
                                glm::dvec4(s.pose->position_m, 1)));
  }
  // glTF's camera looks along -z with y up
  return camera_node(s, scene).world_from_node * glm::mat4(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);
}

LensSampler prepare_lens(const Simulation& s) { return prepare_lens(s, s.lens, sensor_grid(s.sensor)); }

LensSampler prepare_lens(const Simulation& s, const Lens& lens, const SensorGrid& sensor) {
  try {
    return {lens, sensor};
  } catch (const InputError& error) {
    throw InputError(printable(s.path) + ": /lens/" + error.what());
  }
}

CameraView place_camera(const Simulation& s, const Scene& scene) { return {camera_pose(s, scene), prepare_lens(s)}; }

Capture simulate(const Simulation& s, const Scene& scene, const StageCallback& stage) {
  require_valid(check(s), s.path);  // a lens can only be prepared for a sensor that can be
  return simulate(s, scene, place_camera(s, scene), stage);
}

Capture simulate(const Simulation& s, const Scene& scene, const CameraView& view, const StageCallback& stage) {
  require_valid(check(s), s.path);
  check_memory(s, (s.animation ? 2 : 1) * bytes_of(scene));
  if (s.animation) check_animation(s, scene);
  RenderScene world(scene, s.light);

  Capture capture;
  capture.camera = describe_camera(s);
  capture.exposure = describe_exposure(s.sensor, s.exposure);
  capture.face_px = s.face_px;
  const double lux_s_per_nit = view.lens.lux_per_nit() * s.exposure.time_s;
  const double unit_per_nit = lux_s_per_nit / capture.exposure.lux_s_per_unit;
  const ErrorTarget noise = sensor_noise(s, view.lens.lux_per_nit());
  const std::optional<ErrorTarget> goal = goal_of(s, noise, unit_per_nit);
  const double light = goal ? prepare_light(s, world, view, *goal) : 0;
  if (!goal && !s.time_budget_s) {
    const RenderError error = estimate_error(world, view, s.render, noise, s.render.samples_per_pixel);
    capture.provenance.noise_fraction_reached = std::sqrt(error.both());
  }
  Truth& truth = capture.truth.emplace(trace_truth(world, view));
  add_truth_pictures(s, world, view, unit_per_nit, stage, truth);

  const ViewSampling sampling = sample_map_of(s, world, view, goal, light, step_of(stage, "error of the two views"));
  if (s.time_budget_s || s.noise_fraction) {
    const double over_target = expected_error(sampling.map, poses(s));
    capture.provenance.noise_fraction_reached = over_target * s.noise_fraction.value_or(1);
  }
  Image electrons;
  for (int i = 0; i < s.burst_frames; ++i) {
    const Moment middle = moment(s, view, middle_s(s, i));
    if (i < rendered_frames(s)) {
      const Views views = render_frame(s, world, view, middle, sampling.map, i, [&](double fraction) {
        if (stage) stage("left and right view", (i + fraction) / rendered_frames(s));
      });
      if (i == 0 && sampling.target) {
        describe_sampling(sampling.map, *sampling.target, poses(s), views, unit_per_nit, truth);
      }
      if (i > 0) {
        truth.motion.push_back(trace_motion(world, view, middle.own_scene ? *middle.own_scene : scene, middle.view));
      }
      electrons = expected_electrons(views.left, views.right, s.sensor, s.exposure, view.lens.lux_per_nit());
    }
    capture.frames.push_back(expose(electrons, s.sensor, s.exposure, hash(s.render.seed, kSensorNoiseStream, i)));
    capture.frames.back().camera_from_world = row_major(glm::inverse(middle.view.world_from_camera));
    if (stage) stage("sensor", (i + 1.0) / s.burst_frames);
  }
  capture.provenance.scene = s.json.dump();
  return capture;
}

}  // namespace dualpixel::simulator
