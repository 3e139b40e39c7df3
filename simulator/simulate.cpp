#include "simulator/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "capture/error.h"
#include "simulator/picture_sampling.h"
#include "simulator/render/motion.h"
#include "simulator/render/render_error.h"
#include "simulator/render/truth.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/random_streams.h"
#include "simulator/scene/gltf/gltf.h"
#include "simulator/scene/scale.h"
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
  return middle_s(s, frame) + ((pose + 0.5) / poses_of(s) - 0.5) * s.exposure.time_s;
}

/// Reads the scene at every time that will be rendered, so that none is refused when hours have been spent on others.
void check_animation(const Simulation& s, const Scene& first) {
  std::set<double> times_s;
  for (int frame = 0; frame < s.burst_frames; ++frame) {
    times_s.insert(middle_s(s, frame));
    for (int pose = 0; pose < poses_of(s); ++pose) times_s.insert(pose_s(s, frame, pose));
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

/// Adds a `count`-th of `views` to `mean`, which is empty at first.
void add_share(Views views, int count, Views& mean) {
  if (count > 1) scale(views.left, 1.0 / count), scale(views.right, 1.0 / count);
  if (mean.left.empty()) {
    mean = std::move(views);
    return;
  }
  for (std::size_t i = 0; i < mean.left.data.size(); ++i) {
    mean.left.data[i] += views.left.data[i];
    mean.right.data[i] += views.right.data[i];
  }
}

/// The mean over the poses of frame `frame`'s exposure; `middle` is its moment.
Views render_frame(const Simulation& s, const RenderScene& first_world, const CameraView& first, const Moment& middle,
                   const SampleMap& map, int frame, const ProgressCallback& progress) {
  const auto render = [&](const Moment& now, int pose) {
    RenderOptions options = s.render;
    if (frame > 0 || pose > 0) options.seed = hash(s.render.seed, kPoseStream, frame * poses_of(s) + pose);
    const ProgressCallback part = [&](double fraction) { progress((pose + fraction) / poses_of(s)); };
    if (!now.own_scene) return render_views(first_world, now.view, options, map, part);
    const LightCacheOptions& light = first_world.light_cache ? first_world.light_cache->options : s.light;
    return render_views(RenderScene(*now.own_scene, light), now.view, options, map, part);
  };
  Views mean;
  for (int pose = 0; pose < poses_of(s); ++pose) {
    const double time_s = pose_s(s, frame, pose);
    add_share(time_s == middle_s(s, frame) ? render(middle, pose) : render(moment(s, first, time_s), pose), poses_of(s),
              mean);
  }
  return mean;
}

/// What each step of simulate() reports to.
ProgressCallback step_of(const StageCallback& stage, const char* name) {
  if (!stage) return {};
  return [&stage, name](double fraction) { stage(name, fraction); };
}

/// What the pictures of one capture have in common.
struct Job {
  const Simulation& simulation;
  RenderScene& world;
  const CameraView& view;
  double unit_per_nit;
  std::optional<ErrorTarget> goal;
  const StageCallback& stage;
};

Image in_units(Image image, double factor) {
  scale(image, factor);
  return image;
}

double rms(const Image& image) {
  double sum = 0;
  for (const float value : image.data) sum += static_cast<double>(value) * value;
  return std::sqrt(sum / static_cast<double>(image.data.size()));
}

/// One of truth's pictures and its error.
struct TruthPicture {
  Image picture, sigma;  ///< sigma: empty where it is not known by tile
  double noise;          ///< RMS of the error
};

/// Through the ideal lens, its pupil `aperture_scale` as wide as the capture's.
TruthPicture render_picture(const Job& job, double aperture_scale, std::optional<int> samples, RandomStream stream,
                            const char* name) {
  const Simulation& s = job.simulation;
  RenderOptions options = s.render;
  options.ideal_aperture_scale = aperture_scale;
  options.samples_per_pixel = samples.value_or(s.render.samples_per_pixel);
  options.seed = hash(s.render.seed, stream);
  const PictureSampling sampling = sample_picture(s, job.world, job.view, options, job.goal, {});
  Views views = render_views(job.world, job.view, options, sampling.map, step_of(job.stage, name));
  // both halves are the same light, so that errors add up, too
  const double unit_per_half_nit = 2 * job.unit_per_nit;
  TruthPicture truth{{}, in_units(standard_error(sampling, 1, views.left), unit_per_half_nit), 0};
  truth.noise =
      truth.sigma.empty() ? unit_per_half_nit * measure_error(job.world, job.view, options, 1) : rms(truth.sigma);
  truth.picture = in_units(undivided(std::move(views)), job.unit_per_nit);
  return truth;
}

/// Truth's pictures in the frames' normalized signal: a neutral gray reads the same in all channels after the sensor's
/// color response is divided out, as white balance does.
void add_truth_pictures(const Job& job, Truth& truth) {
  const Simulation& s = job.simulation;
  truth.noise.emplace();
  truth.photograph_aperture_scale = s.photograph_aperture_scale;
  if (s.with_all_in_focus) {
    TruthPicture sharp =
        render_picture(job, 0, s.all_in_focus_samples_per_pixel, kAllInFocusStream, "all-in-focus image");
    truth.all_in_focus = std::move(sharp.picture);
    truth.all_in_focus_sigma = std::move(sharp.sigma);
    truth.noise->all_in_focus = sharp.noise;
  }
  if (s.with_photograph) {
    TruthPicture wide = render_picture(job, s.photograph_aperture_scale, s.photograph_samples_per_pixel,
                                       kPhotographStream, "wide-aperture photograph");
    truth.photograph = std::move(wide.picture);
    truth.photograph_sigma = std::move(wide.sigma);
    truth.noise->photograph = wide.noise;
  }
}

/// The first frame's views, before the sensor adds its noise.
void add_truth_views(const Job& job, const Views& views, Truth& truth) {
  truth.left = in_units(views.left, job.unit_per_nit);
  truth.right = in_units(views.right, job.unit_per_nit);
}

/// What is known of the first frame's samples and error, and of truth's views', which are in `truth`.
void describe_sampling(const Job& job, const PictureSampling& sampling, Truth& truth) {
  const Simulation& s = job.simulation;
  const int pictures = poses_of(s);
  if (!sampling.target) {
    RenderOptions options = s.render;
    options.samples_per_pixel = static_cast<int>(sampling.map.samples.front());
    truth.noise->views = job.unit_per_nit * measure_error(job.world, job.view, options, pictures);
    return;
  }
  truth.samples = Image(s.sensor.width_px, s.sensor.height_px);
  for (std::size_t i = 0; i < sampling.map.samples.size(); ++i) {
    const Tile tile = tile_at(sampling.map, static_cast<int>(i));
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) {
        truth.samples.at(x, y) = static_cast<float>(tile.samples) * static_cast<float>(pictures);
      }
    }
  }
  Image half_nits = truth.left;
  for (std::size_t i = 0; i < half_nits.data.size(); ++i) half_nits.data[i] += truth.right.data[i];
  scale(half_nits, 0.5 / job.unit_per_nit);
  truth.render_sigma = truth.views_sigma = in_units(standard_error(sampling, pictures, half_nits), job.unit_per_nit);
  truth.noise->views = rms(truth.views_sigma);
}

}  // namespace

Scene load_scene(const Simulation& s, double time_s) {
  Scene scene = read_gltf(s.gltf_path, s.animation ? std::optional(time_s) : std::nullopt);
  if (s.model_size_m) scale_to(scene, *s.model_size_m);
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
  RenderScene world(scene, s.light);
  return simulate(s, world, view, stage);
}

Capture simulate(const Simulation& s, RenderScene& world, const CameraView& view, const StageCallback& stage) {
  require_valid(check(s), s.path);
  check_memory(s, (s.animation ? 2 : 1) * bytes_of(world.scene));
  if (s.animation) check_animation(s, world.scene);

  Capture capture;
  capture.camera = describe_camera(s);
  capture.exposure = describe_exposure(s.sensor, s.exposure);
  capture.face_px = s.face_px;
  const double lux_s_per_nit = view.lens.lux_per_nit() * s.exposure.time_s;
  const double unit_per_nit = lux_s_per_nit / capture.exposure.lux_s_per_unit;
  const ErrorTarget noise = sensor_noise(s, view.lens.lux_per_nit());
  const Job job{s, world, view, unit_per_nit, goal_of(s, noise, unit_per_nit), stage};
  prepare_light(s, world, view, job.goal);
  if (!job.goal && !s.time_budget_s) {
    const RenderError error = estimate_error(world, view, s.render, noise, s.render.samples_per_pixel);
    capture.provenance.noise_fraction_reached = std::sqrt(error.both());
  }
  Truth& truth = capture.truth.emplace(trace_truth(world, view));
  add_truth_pictures(job, truth);

  const PictureSampling sampling =
      sample_views(s, world, view, noise, job.goal, step_of(stage, "error of the two views"));
  if (s.time_budget_s || s.noise_fraction) {
    const double over_target = expected_error(sampling, poses_of(s));
    capture.provenance.noise_fraction_reached = over_target * s.noise_fraction.value_or(1);
  }
  Views views;
  for (int i = 0; i < s.burst_frames; ++i) {
    const Moment middle = moment(s, view, middle_s(s, i));
    if (i == 0 || moves(s)) {  // else all frames see the first one's light
      views = render_frame(s, world, view, middle, sampling.map, i, [&](double fraction) {
        if (stage) stage("left and right view", (i + fraction) / s.burst_frames);
      });
    }
    if (i == 0) add_truth_views(job, views, truth);
    if (i > 0 && moves(s)) {
      const Scene& then = middle.own_scene ? *middle.own_scene : world.scene;
      truth.motion.push_back(trace_motion(world, view, then, middle.view));
    }
    const Image electrons = expected_electrons(views.left, views.right, s.sensor, s.exposure, view.lens.lux_per_nit());
    capture.frames.push_back(expose(electrons, s.sensor, s.exposure, hash(s.render.seed, kSensorNoiseStream, i)));
    capture.frames.back().camera_from_world = row_major(glm::inverse(middle.view.world_from_camera));
    if (stage) stage("sensor", (i + 1.0) / s.burst_frames);
  }
  describe_sampling(job, sampling, truth);
  capture.provenance.scene = s.json.dump();
  return capture;
}

}  // namespace dualpixel::simulator
