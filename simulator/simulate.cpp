#include "simulator/simulate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "capture/error.h"
#include "capture/folder/capture_json.h"
#include "simulator/held_camera.h"
#include "simulator/lens/lens_shading.h"
#include "simulator/picture_sampling.h"
#include "simulator/render/motion.h"
#include "simulator/render/render_error.h"
#include "simulator/render/render_scene.h"
#include "simulator/render/truth.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/random_streams.h"
#include "simulator/scene/gltf/gltf.h"
#include "simulator/scene/scale.h"
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
  throw InputError(fmt::format("{}: /nodes: no camera node is named '{}', the scene's camera.node{}",
                               printable(s.gltf_path), printable(s.camera_node), did_you_mean(s.camera_node, names)));
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

/// Rows of a picture that see one and the same scene.
struct Band {
  int first_row, end_row;
};

/// Where things are animated and the shutter rolls, the scene changes from band to band, whole tiles each; elsewhere
/// all rows see the same.
std::vector<Band> bands_of(const Simulation& s) {
  constexpr int kMostBands = 32;
  const int height = s.sensor.height_px;
  if (!(s.animation && s.sensor.row_time_us > 0)) return {{0, height}};
  const int tiles = (height + SampleMap::kTile - 1) / SampleMap::kTile;
  const int rows = (tiles + kMostBands - 1) / kMostBands * SampleMap::kTile;
  std::vector<Band> bands;
  for (int row = 0; row < height; row += rows) bands.push_back({row, std::min(row + rows, height)});
  return bands;
}

/// When the middle of a band is exposed in a picture whose middle is exposed at `time_s`.
double band_s(const Simulation& s, double time_s, const Band& band) {
  return time_s + row_delay_s(s, 0.5 * (band.first_row + band.end_row));
}

/// Scene and camera at one time of a burst.
struct Moment {
  std::unique_ptr<Scene> own_scene;  ///< empty: the first frame's
  CameraView view;
};

/// What a band sees of a picture whose middle is exposed at `time_s`; `view.world_from_camera` is that of its middle.
Moment moment(const Simulation& s, const CameraView& first, double time_s, const Band& band) {
  Moment now{nullptr, first};
  const double scene_s = band_s(s, time_s, band);
  if (s.animation && scene_s != 0) {
    now.own_scene = std::make_unique<Scene>(load_scene(s, scene_s));
    now.view.world_from_camera = camera_pose(s, *now.own_scene);
  }
  now.view = held_at(s, std::move(now.view), time_s);
  return now;
}

Moment moment(const Simulation& s, const CameraView& first, double time_s) {
  return moment(s, first, time_s, {0, s.sensor.height_px});
}

double middle_s(const Simulation& s, int frame) { return frame * s.frame_interval_s; }

double pose_s(const Simulation& s, int frame, int pose) {
  return middle_s(s, frame) + ((pose + 0.5) / poses_of(s) - 0.5) * s.exposure.time_s;
}

/// Reads the scene at every time that will be rendered or that truth is of (a frame's middle, and each band's), so that
/// none is refused when hours have been spent on others.
void check_animation(const Simulation& s, const Scene& first) {
  std::set<double> times_s;
  for (int frame = 0; frame < s.burst_frames; ++frame) {
    times_s.insert(middle_s(s, frame));
    for (const Band& band : bands_of(s)) {
      times_s.insert(band_s(s, middle_s(s, frame), band));
      for (int pose = 0; pose < poses_of(s); ++pose) times_s.insert(band_s(s, pose_s(s, frame, pose), band));
    }
  }
  for (const double time_s : times_s) {
    if (time_s == 0) continue;  // `first`
    if (const auto mesh = mesh_that_differs(first, load_scene(s, time_s, /*decode_textures=*/false))) {
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
    bytes += size(m.placements) + size(m.radii);
  }
  return bytes;
}

/// The world of a moment that has a scene of its own.
RenderScene world_of(const Simulation& s, const Moment& now, const RenderScene& first_world) {
  return RenderScene(*now.own_scene, first_world.light_cache ? first_world.light_cache->options : s.light);
}

/// A picture whose middle is exposed at `time_s`.
Views render_at(const Simulation& s, const RenderScene& first_world, const CameraView& first, double time_s,
                RenderOptions options, const SampleMap& map, const ProgressCallback& progress) {
  Views views;
  for (const Band& band : bands_of(s)) {
    options.first_row = band.first_row, options.end_row = band.end_row;
    const Moment now = moment(s, first, time_s, band);
    Views part = now.own_scene ? render_views(world_of(s, now, first_world), now.view, options, map, progress)
                               : render_views(first_world, now.view, options, map, progress);
    if (views.left.empty()) {
      views = std::move(part);
      continue;
    }
    for (Image Views::*view : {&Views::left, &Views::right}) {
      std::copy((part.*view).row(band.first_row), (part.*view).row(band.end_row - 1) + 3 * s.sensor.width_px,
                (views.*view).row(band.first_row));
    }
  }
  return views;
}

/// The mean over the poses of frame `frame`'s exposure.
Views render_frame(const Simulation& s, const RenderScene& first_world, const CameraView& first, const SampleMap& map,
                   int frame, const ProgressCallback& progress) {
  Views mean;
  for (int pose = 0; pose < poses_of(s); ++pose) {
    RenderOptions options = s.render;
    if (frame > 0 || pose > 0) options.seed = hash(s.render.seed, kPoseStream, frame * poses_of(s) + pose);
    const ProgressCallback part = [&](double fraction) { progress((pose + fraction) / poses_of(s)); };
    add_share(render_at(s, first_world, first, pose_s(s, frame, pose), options, map, part), poses_of(s), mean);
  }
  return mean;
}

/// The first frame's geometry, each row's at its own time.
Truth first_truth(const Simulation& s, const RenderScene& world, const CameraView& view) {
  Truth truth = empty_truth(view.lens.sensor());
  for (const Band& band : bands_of(s)) {
    const Moment now = moment(s, view, 0, band);
    if (now.own_scene) {
      trace_truth_rows(world_of(s, now, world), now.view, band.first_row, band.end_row, truth);
    } else {
      trace_truth_rows(world, now.view, band.first_row, band.end_row, truth);
    }
  }
  // the middle of the lens lies in what it sees
  if (std::any_of(truth.depth_m.data.begin(), truth.depth_m.data.end(), [](float depth) { return depth <= 0; })) {
    throw InputError(printable(s.path) + ": /camera: lies in a surface: must look at it from a distance");
  }
  return truth;
}

/// Motion from the first frame to that whose middle is exposed at `time_s`. A point that the first frame's band shows
/// is looked for in the same band of the later frame and the two next to it, and taken from the one that it lands
/// nearest.
Image motion_to(const Simulation& s, const RenderScene& world, const CameraView& view, double time_s) {
  const std::vector<Band> bands = bands_of(s);
  Image motion(s.sensor.width_px, s.sensor.height_px, 2, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const Band& band = bands[i];
    const Moment now = moment(s, view, 0, band);
    const std::unique_ptr<RenderScene> own =
        now.own_scene ? std::make_unique<RenderScene>(*now.own_scene, LightCacheOptions{0}) : nullptr;
    Image distance(s.sensor.width_px, s.sensor.height_px, 1, std::numeric_limits<float>::infinity());
    for (std::size_t j = std::max<std::size_t>(i, 1) - 1; j < std::min(i + 2, bands.size()); ++j) {
      const Moment later = moment(s, view, time_s, bands[j]);
      const Scene& later_scene = later.own_scene ? *later.own_scene : world.scene;
      const Image found =
          trace_motion_rows(own ? *own : world, now.view, later_scene, later.view, band.first_row, band.end_row);
      for (int y = band.first_row; y < band.end_row; ++y) {
        for (int x = 0; x < motion.width; ++x) {
          const float row = static_cast<float>(y) + 0.5f + found.at(x, y, 1);
          const float away = std::max(
              {static_cast<float>(bands[j].first_row) - row, row - static_cast<float>(bands[j].end_row), 0.0f});
          if (!(away < distance.at(x, y))) continue;
          distance.at(x, y) = away;
          for (int c = 0; c < 2; ++c) motion.at(x, y, c) = found.at(x, y, c);
        }
      }
    }
  }
  return motion;
}

/// Glare: the same share of every photosite's light goes evenly to all of its color. It comes from all over the lens,
/// so that both halves get the same.
void spread_glare(double share, Views& views) {
  if (share == 0) return;
  double sums[3] = {}, counts[3] = {};
  for (int y = 0; y < views.left.height; ++y) {
    for (int x = 0; x < views.left.width; ++x) {
      const int c = cfa_color(x, y);
      sums[c] += 0.5 * (views.left.at(x, y, c) + views.right.at(x, y, c));
      counts[c] += 1;
    }
  }
  for (Image* view : {&views.left, &views.right}) {
    for (std::size_t i = 0; i < view->data.size(); ++i) {
      const double even = sums[i % 3] / counts[i % 3];
      view->data[i] = static_cast<float>((1 - share) * view->data[i] + share * even);
    }
  }
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

/// A picture in the scene's colors, or the error of each photosite in its own filter's color, with the scene's white
/// made neutral.
Image with_neutral_white(Image image, const std::array<double, 3>& white) {
  if (white == std::array<double, 3>{1, 1, 1}) return image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c) {
        image.at(x, y, c) /= static_cast<float>(white[image.channels == 1 ? cfa_color(x, y) : c]);
      }
    }
  }
  return image;
}

double rms(const Image& image) {
  double sum = 0;
  for (const float value : image.data) sum += static_cast<double>(value) * value;
  return std::sqrt(sum / static_cast<double>(image.data.size()));
}

/// One of truth's pictures and its error, the scene's white neutral.
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
  Views views = render_at(s, job.world, job.view, 0, options, sampling.map, step_of(job.stage, name));
  // both halves are the same light, so that errors add up, too
  const double unit_per_half_nit = 2 * job.unit_per_nit;
  const std::array<double, 3>& white = s.sensor.illuminant;
  const auto neutral = [&](Image image, double unit) {
    return with_neutral_white(in_units(std::move(image), unit), white);
  };
  TruthPicture truth{{}, neutral(standard_error(sampling, 1, views.left), unit_per_half_nit), 0};
  truth.noise = truth.sigma.empty() ? unit_per_half_nit * measure_error(job.world, job.view, options, 1, white)
                                    : rms(truth.sigma);
  truth.picture = neutral(undivided(std::move(views)), job.unit_per_nit);
  return truth;
}

/// Through the lens that the scene file names for the photograph. Each color is rendered by itself where the lens has
/// any.
TruthPicture render_through_lens(const Job& job, LensSampler lens, const char* name) {
  const Simulation& s = job.simulation;
  const CameraView view{job.view.world_from_camera, std::move(lens)};
  RenderOptions options = s.render;
  options.samples_per_pixel = s.photograph_samples_per_pixel.value_or(s.render.samples_per_pixel);
  options.seed = hash(s.render.seed, kPhotographStream);
  const PictureSampling sampling = sample_picture(s, job.world, view, options, job.goal, {});
  const int colors = view.lens.has_color() || view.lens.diffracts() ? 3 : 1;
  Image picture, halves;
  for (int color = 0; color < colors; ++color) {
    if (colors > 1) options.color = color, options.seed = hash(s.render.seed, kPhotographStream, color);
    Views views = render_at(s, job.world, view, 0, options, sampling.map, step_of(job.stage, name));
    spread_glare(s.photograph->veiling_glare, views);
    if (color == 1 || colors == 1) halves = views.left;
    Image all = undivided(std::move(views));
    if (color == 0) picture = all;
    for (std::size_t i = color; i < all.data.size() && color > 0; i += 3) picture.data[i] = all.data[i];
  }
  options.color.reset();
  const double unit_per_half_nit = 2 * job.unit_per_nit;  // as if the halves' errors were the same
  const std::array<double, 3>& white = s.sensor.illuminant;
  const auto neutral = [&](Image image, double unit) {
    return with_neutral_white(in_units(std::move(image), unit), white);
  };
  TruthPicture truth{neutral(std::move(picture), job.unit_per_nit),
                     neutral(standard_error(sampling, 1, halves), unit_per_half_nit), 0};
  truth.noise =
      truth.sigma.empty() ? unit_per_half_nit * measure_error(job.world, view, options, 1, white) : rms(truth.sigma);
  return truth;
}

/// Truth's pictures in the frames' normalized signal: a neutral gray reads the same in all channels after the sensor's
/// color response is divided out, as white balance does.
void add_truth_pictures(const Job& job, Truth& truth) {
  const Simulation& s = job.simulation;
  truth.noise.emplace();
  truth.photograph_aperture_scale = s.photograph_aperture_scale;
  std::optional<LensSampler> lens = s.with_photograph ? prepare_photograph_lens(s) : std::nullopt;
  truth.photograph_lens =
      s.photograph ? fmt::format("{} at f/{:.3g}", s.photograph->name, s.photograph->thin.f_number) : "ideal";
  if (const double lit = lens ? lit_share(*lens) : 1; lit < 1) {
    truth.photograph_lens += fmt::format(", lights {:.0f} % of the view", std::floor(100 * lit));
  }
  if (s.with_all_in_focus) {
    TruthPicture sharp =
        render_picture(job, 0, s.all_in_focus_samples_per_pixel, kAllInFocusStream, "all-in-focus image");
    truth.all_in_focus = std::move(sharp.picture);
    truth.all_in_focus_sigma = std::move(sharp.sigma);
    truth.noise->all_in_focus = sharp.noise;
  }
  if (s.with_photograph) {
    constexpr const char* kWide = "wide-aperture photograph";
    TruthPicture wide = lens ? render_through_lens(job, std::move(*lens), kWide)
                             : render_picture(job, s.photograph_aperture_scale, s.photograph_samples_per_pixel,
                                              kPhotographStream, kWide);
    truth.photograph = std::move(wide.picture);
    truth.photograph_sigma = std::move(wide.sigma);
    truth.noise->photograph = wide.noise;
  }
}

/// The first frame's views, before the sensor adds its noise.
void add_truth_views(const Job& job, const Views& views, Truth& truth) {
  const std::array<double, 3>& white = job.simulation.sensor.illuminant;
  truth.left = with_neutral_white(in_units(views.left, job.unit_per_nit), white);
  truth.right = with_neutral_white(in_units(views.right, job.unit_per_nit), white);
}

/// What half a photosite of the first frame sees, from the views in `truth`.
Image half_nits_of(const Job& job, const Truth& truth) {
  const std::array<double, 3>& white = job.simulation.sensor.illuminant;
  Image half_nits = truth.left;
  for (std::size_t i = 0; i < half_nits.data.size(); ++i) half_nits.data[i] += truth.right.data[i];
  half_nits = with_neutral_white(std::move(half_nits), {1 / white[0], 1 / white[1], 1 / white[2]});
  scale(half_nits, 0.5 / job.unit_per_nit);
  return half_nits;
}

/// What frames differ by is noise or motion, and the merge tells them apart by the noise that the capture states. So it
/// states what each frame draws anew: the sensor's variance, and so many times that from rendering.
void add_rendering_noise(double over_sensor, Exposure& exposure) {
  for (NoiseProfile* noise : {&exposure.mosaic_noise, &exposure.dp_noise}) {
    noise->shot_dn *= 1 + over_sensor;
    noise->read_dn2 *= 1 + over_sensor;
  }
}

/// What is known of the first frame's samples and error, and of truth's views', which are in `truth`.
void describe_sampling(const Job& job, const PictureSampling& sampling, Truth& truth) {
  const Simulation& s = job.simulation;
  const int pictures = poses_of(s);
  if (!sampling.target) {
    RenderOptions options = s.render;
    options.samples_per_pixel = static_cast<int>(sampling.map.samples.front());
    truth.noise->views = job.unit_per_nit * measure_error(job.world, job.view, options, pictures, s.sensor.illuminant);
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
  truth.views_sigma = with_neutral_white(
      in_units(standard_error(sampling, pictures, half_nits_of(job, truth)), job.unit_per_nit), s.sensor.illuminant);
  truth.render_sigma = truth.views_sigma;
  truth.noise->views = rms(truth.views_sigma);
}

}  // namespace

Scene load_scene(const Simulation& s, double time_s, bool decode_textures) {
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
  if (decode_textures) keep_decoded(scene.textures);
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
  c.alpha = std::max(s.lens.split.alpha(thin.rim_slope()), 0.0);
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

std::optional<LensSampler> prepare_photograph_lens(const Simulation& s) {
  if (!s.photograph) return {};
  SensorGrid sensor = sensor_grid(s.sensor);
  sensor.pixel_pitch_m *= s.photograph->thin.image_distance_m() / s.lens.thin.image_distance_m();
  return prepare_lens(s, *s.photograph, sensor);
}

std::vector<std::string> warnings_of(const Simulation& s) {
  std::vector<std::string> warnings = s.warnings;
  const std::optional<LensSampler> lens = s.with_photograph ? prepare_photograph_lens(s) : std::nullopt;
  const double lit = lens ? lit_share(*lens) : 1;
  if (lit < 1) {
    warnings.push_back(
        fmt::format("{}: /truth/photograph_lens: {} lights {:.0f} % of the view; the rest of the "
                    "photograph is black",
                    printable(s.path), printable(s.photograph->name), std::floor(100 * lit)));
  }
  return warnings;
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

void require_renderable(const Simulation& s, const Scene& scene) {
  require_valid(check(s), s.path);
  check_memory(s, (s.animation ? 2 : 1) * bytes_of(scene));
  if (s.animation) check_animation(s, scene);
}

Capture simulate(const Simulation& s, RenderScene& world, const CameraView& view, const StageCallback& stage) {
  require_renderable(s, world.scene);
  Capture capture;
  capture.camera = describe_camera(s);
  capture.camera.relative_light = relative_light(view.lens);
  capture.exposure = describe_exposure(s.sensor, s.exposure);
  require_readable(capture.camera, capture.exposure, s.path + ": its capture");
  capture.face_px = s.face_px;
  const double lux_s_per_nit = view.lens.lux_per_nit() * s.exposure.time_s;
  const double unit_per_nit = lux_s_per_nit / capture.exposure.lux_s_per_unit;
  const ErrorTarget noise = sensor_noise(s, view.lens.lux_per_nit());
  const Job job{s, world, view, unit_per_nit, goal_of(s, noise, unit_per_nit), stage};
  prepare_light(s, world, view, job.goal);
  RenderError error;
  if (!job.goal && !s.time_budget_s) {
    error = estimate_error(world, view, s.render, noise, samples_of_pose(s));
    error.samples /= poses_of(s);  // which share their light
    capture.provenance.noise_fraction_reached = std::sqrt(error.both());
  }
  Truth& truth = capture.truth.emplace(first_truth(s, world, view));
  add_truth_pictures(job, truth);

  const PictureSampling sampling =
      sample_views(s, world, view, noise, job.goal, step_of(stage, "error of the two views"));
  if (s.time_budget_s || s.noise_fraction) {
    const double over_target = expected_error(sampling, poses_of(s));
    capture.provenance.noise_fraction_reached = over_target * s.noise_fraction.value_or(1);
  }
  Views views;
  for (int i = 0; i < s.burst_frames; ++i) {
    if (i == 0 || moves(s)) {  // else all frames see the first one's light
      views = render_frame(s, world, view, sampling.map, i, [&](double fraction) {
        if (stage) stage("left and right view", (i + fraction) / s.burst_frames);
      });
      spread_glare(s.lens.veiling_glare, views);
    }
    if (i == 0) add_truth_views(job, views, truth);
    if (i > 0 && moves(s)) truth.motion.push_back(motion_to(s, world, view, middle_s(s, i)));
    const Image electrons = expected_electrons(views.left, views.right, s.sensor, s.exposure, view.lens.lux_per_nit());
    capture.frames.push_back(expose(electrons, s.sensor, s.exposure, hash(s.render.seed, kSensorNoiseStream, i)));
    capture.frames.back().camera_from_world =
        row_major(glm::inverse(moment(s, view, middle_s(s, i)).view.world_from_camera));
    if (stage) stage("sensor", (i + 1.0) / s.burst_frames);
  }
  if (sampling.target) error.samples = sample_variance(sampling, poses_of(s), half_nits_of(job, truth), noise);
  if (moves(s)) add_rendering_noise(error.samples, capture.exposure);
  describe_sampling(job, sampling, truth);
  capture.provenance.scene = s.json.dump();
  return capture;
}

}  // namespace dualpixel::simulator
