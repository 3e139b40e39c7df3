#include "simulator/picture_sampling.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "simulator/render/render_error.h"
#include "simulator/sampling/mosaic.h"

namespace dualpixel::simulator {
namespace {

constexpr int kLightPilotSamples = 16;
constexpr double kLightShare = 0.5;  ///< of the square error that a goal allows

ErrorTarget scaled(ErrorTarget target, double factor) {
  for (double& value : target.per_nit) value *= factor;
  for (double& value : target.constant) value *= factor;
  return target;
}

/// What half a photosite of an undivided picture may be off by. Both halves are the same light through the ideal lens,
/// so that the picture is off by twice as much: four times the square. The sensor's noise adds up to twice the square
/// only.
ErrorTarget goal_of_picture(const Simulation& s, const ErrorTarget& goal) {
  return scaled(goal, s.noise_fraction ? 0.5 : 0.25);
}

/// Square error that light takes of `target`, with the light cache that `world` has.
double light_share(RenderScene& world, const CameraView& view, const RenderOptions& options,
                   const ErrorTarget& target) {
  return estimate_error(world, view, options, target, kLightPilotSamples).light;
}

/// The same of the goal, in the picture where it is most.
double largest_light_share(const Simulation& s, RenderScene& world, const CameraView& view, const ErrorTarget& goal) {
  double most = light_share(world, view, s.render, goal);
  RenderOptions picture = s.render;
  for (const double scale : {0.0, s.photograph_aperture_scale}) {
    picture.ideal_aperture_scale = scale;
    most = std::max(most, light_share(world, view, picture, goal_of_picture(s, goal)));
  }
  return most;
}

/// The map whose samples, of all poses and frames, take what the pilot leaves of the time, with the pilot's own speed.
SampleMap samples_in_time(const Simulation& s, const RenderScene& world, const CameraView& view,
                          const ErrorTarget& target, const SampleLimits& limits, const ProgressCallback& progress) {
  constexpr std::uint32_t kMostPilotSamples = 32;  // about six a photosite in all
  const auto start = std::chrono::steady_clock::now();
  const auto spent_s = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const Pilot pilot = probe_tiles(world, view, s.render, target, kMostPilotSamples, progress);
  const double sample_s = spent_s() / pilot.samples;
  const double maps = (moves(s) ? s.burst_frames : 1) * poses_of(s);
  return share_budget(
      pilot, [&] { return std::max(*s.time_budget_s - spent_s(), 0.0) / (sample_s * maps); }, limits);
}

/// The cheapest samples with which the mean of `count` poses keeps `target`.
PictureSampling sample_to(RenderScene& world, const CameraView& view, const RenderOptions& options,
                          const ErrorTarget& target, std::uint32_t count, const SampleLimits& limits,
                          const ProgressCallback& progress) {
  const double light = light_share(world, view, options, target);
  const double left = std::max(1 - light, 0.25);
  const Pilot pilot = probe_tiles(world, view, options, scaled(target, left), SampleLimits{}.most, progress);
  PictureSampling sampling{share_samples(pilot, std::sqrt(count), limits), target, light};
  for (float& ratio : sampling.map.error_ratio) ratio *= static_cast<float>(std::sqrt(left));
  return sampling;
}

/// Calls visit(x, y, the error of samples over the target's).
template <typename Visit>
void for_each_photosite(const PictureSampling& sampling, Visit visit) {
  for (std::size_t i = 0; i < sampling.map.samples.size(); ++i) {
    const Tile tile = tile_at(sampling.map, static_cast<int>(i));
    for (int y = tile.y0; y < tile.y1; ++y) {
      for (int x = tile.x0; x < tile.x1; ++x) visit(x, y, static_cast<double>(sampling.map.error_ratio[i]));
    }
  }
}

}  // namespace

std::optional<ErrorTarget> goal_of(const Simulation& s, const ErrorTarget& noise, double unit_per_nit) {
  if (s.noise_fraction) return scaled(noise, *s.noise_fraction * *s.noise_fraction);
  if (!s.render_error) return {};
  ErrorTarget target;
  for (int c = 0; c < 3; ++c) {  // of pictures in which the illuminant is neutral
    const double nits = *s.render_error / unit_per_nit * s.sensor.illuminant[c];
    target.constant[c] = nits * nits;
  }
  return target;
}

void prepare_light(const Simulation& s, RenderScene& world, const CameraView& view,
                   const std::optional<ErrorTarget>& goal) {
  const auto use = [&](const LightCacheOptions& light) {
    light.light_spacing_px == 0 ? world.light_cache.reset() : use_light(world, light);
  };
  if (!goal || s.light.light_spacing_px == 0) return use(s.light);
  // How fast the error falls depends on the scene, so that what was extrapolated is measured at each count. Points that
  // are found for it at the last count are those of the pictures.
  LightCacheOptions light = s.light;
  int samples = kLightPilotSamples;
  do {
    light.light_samples = samples;
    use(light);
    samples = light_samples_for(kLightShare, largest_light_share(s, world, view, *goal), samples);
  } while (samples > light.light_samples);
}

std::uint32_t samples_of_pose(const Simulation& s) {
  const auto samples = static_cast<std::uint32_t>(s.render.samples_per_pixel),
             poses = static_cast<std::uint32_t>(poses_of(s));
  return poses == 1 ? samples : std::max(std::bit_floor(samples / poses), 2u);
}

PictureSampling sample_views(const Simulation& s, RenderScene& world, const CameraView& view, const ErrorTarget& noise,
                             const std::optional<ErrorTarget>& goal, const ProgressCallback& progress) {
  const std::uint32_t count = std::max<std::uint32_t>(poses_of(s), 1);
  const SampleLimits all;
  const SampleLimits limits{std::max(all.fewest / std::bit_ceil(count), 2u), all.most / std::bit_floor(count)};
  if (s.time_budget_s) {
    const double light = light_share(world, view, s.render, noise);
    return {samples_in_time(s, world, view, noise, limits, progress), noise, light};
  }
  if (goal) return sample_to(world, view, s.render, *goal, count, limits, progress);
  return {uniform_map(s.sensor.width_px, s.sensor.height_px, samples_of_pose(s)), {}};
}

PictureSampling sample_picture(const Simulation& s, RenderScene& world, const CameraView& view,
                               const RenderOptions& picture, const std::optional<ErrorTarget>& goal,
                               const ProgressCallback& progress) {
  if (goal) return sample_to(world, view, picture, goal_of_picture(s, *goal), 1, {}, progress);
  const auto samples = static_cast<std::uint32_t>(picture.samples_per_pixel);
  return {uniform_map(s.sensor.width_px, s.sensor.height_px, samples), {}};
}

double expected_error(const PictureSampling& sampling, int count) {
  double sum = 0;
  for (float ratio : sampling.map.error_ratio) sum += static_cast<double>(ratio) * ratio;
  return std::sqrt(sum / static_cast<double>(sampling.map.error_ratio.size()) / count + sampling.light);
}

Image standard_error(const PictureSampling& sampling, int count, const Image& half_nits) {
  if (!sampling.target) return {};
  Image sigma(half_nits.width, half_nits.height);
  for_each_photosite(sampling, [&](int x, int y, double ratio) {
    const int c = cfa_color(x, y);
    const double error2 = ratio * ratio / count + sampling.light;
    sigma.at(x, y) = static_cast<float>(std::sqrt(error2 * sampling.target->at(c, half_nits.at(x, y, c))));
  });
  return sigma;
}

double sample_variance(const PictureSampling& sampling, int count, const Image& half_nits, const ErrorTarget& noise) {
  double from_samples = 0, from_sensor = 0;
  for_each_photosite(sampling, [&](int x, int y, double ratio) {
    const int c = cfa_color(x, y);
    const double nits = half_nits.at(x, y, c);
    from_samples += ratio * ratio / count * sampling.target->at(c, nits);
    from_sensor += noise.at(c, nits);
  });
  return from_samples / from_sensor;
}

double measure_error(RenderScene& world, const CameraView& view, const RenderOptions& picture, int count,
                     const std::array<double, 3>& white) {
  const ErrorTarget square_nits{.constant = {white[0] * white[0], white[1] * white[1], white[2] * white[2]}};
  const RenderError error = estimate_error(world, view, picture, square_nits, picture.samples_per_pixel);
  return std::sqrt(error.samples / count + error.light);
}

}  // namespace dualpixel::simulator
