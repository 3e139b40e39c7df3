#include "simulator/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/error.h"
#include "simulator/plan/error_statistics.h"
#include "simulator/plan/lens_candidates.h"
#include "simulator/plan/lens_errors.h"
#include "simulator/plan/pilot_errors.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::simulator {
namespace {

constexpr int kMostSamples = 65536;

void check_sensor(const Simulation& simulation) {
  const SensorOptions& sensor = simulation.sensor;
  const LeastSensor least = least_sensor(sensor);
  if (sensor.width_px >= least.width_px && sensor.height_px >= least.height_px) return;
  throw InputError(fmt::format("{}: /sensor: {} x {} photosites: a plan needs at least {} x {}, one matcher's window",
                               printable(simulation.path), sensor.width_px, sensor.height_px, least.width_px,
                               least.height_px));
}

/// Error of `samples` samples at bounce step b.
double sample_error(const Plan& plan, const PilotErrors& pilots, std::size_t b, int samples) {
  return plan.measured ? plan.bounces[b].noise * pilots.sample_error(samples) : 0.0;
}

double root_of_squares(const Plan& plan, const PilotErrors& pilots, std::size_t l, std::size_t b, std::size_t t,
                       int samples) {
  return std::sqrt(square(plan.lenses[l].error_dp_px) + square(plan.bounces[b].error_dp_px) +
                   square(plan.lights[t].error_dp_px) + square(sample_error(plan, pilots, b, samples)));
}

/// Time of one photosite. What is more accurate is not taken to be cheaper, whatever the clock says.
double photosite_s(const Plan& plan, std::size_t l, std::size_t b, std::size_t t, int samples) {
  double bounce_s = 0, light_s = 0, lens_s = 0;
  for (std::size_t i = 0; i <= b; ++i) {
    bounce_s = std::max(bounce_s, plan.bounces[i].seconds_per_sample);
    light_s = std::max(light_s, plan.bounces[i].light_seconds);
  }
  for (std::size_t i = 0; i <= l; ++i) lens_s = std::max(lens_s, plan.lenses[i].seconds_per_sample);
  double making = 0;
  for (std::size_t i = 0; i <= t; ++i) making = std::max(making, plan.lights[i].making);
  const double sample_s = bounce_s + lens_s - plan.lenses[plan.pilot_lens].seconds_per_sample;
  return making * light_s + samples * std::max(sample_s, lens_s);
}

/// Steps of a factor of sqrt(2): times scatter.
double work_steps(double seconds) { return std::round(2 * std::log2(std::max(seconds, 1e-15))); }

template <typename Visit>
void for_all_steps(const Plan& plan, const Visit& visit) {
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
      for (std::size_t t = 0; t < plan.lights.size(); ++t) visit(l, b, t);
    }
  }
}

/// Chooses the least work whose error is at most `error_dp_px`, and returns its samples; 0: there is none.
int choose_within(Plan& plan, const PilotErrors& pilots, int scene_samples, double error_dp_px) {
  double least_work = std::numeric_limits<double>::infinity();
  int chosen_samples = 0;
  for_all_steps(plan, [&](std::size_t l, std::size_t b, std::size_t t) {
    const auto within = [&](int samples) { return root_of_squares(plan, pilots, l, b, t, samples) <= error_dp_px; };
    int samples = plan.measured ? kPilotSamples[0] : scene_samples;
    while (plan.measured && samples < kMostSamples && !within(samples)) samples *= 2;
    const double work = work_steps(photosite_s(plan, l, b, t, samples));
    if (!within(samples) || work >= least_work) return;
    least_work = work;
    plan.lens = l, plan.bounce = b, plan.light = t, chosen_samples = samples;
  });
  return chosen_samples;
}

/// The least work whose error stays within the tolerance. Where none does, within a tenth of the least error that there
/// is: the last tenth may take a hundred times as long.
void choose(Plan& plan, const PilotErrors& pilots, int scene_samples) {
  constexpr double kNearTheLeast = 1.1;
  int chosen_samples = choose_within(plan, pilots, scene_samples, plan.tolerance_dp_px);
  plan.met = chosen_samples > 0;
  if (!plan.met) {
    const int most = plan.measured ? kMostSamples : scene_samples;
    double least = std::numeric_limits<double>::infinity();
    for_all_steps(plan, [&](std::size_t l, std::size_t b, std::size_t t) {
      least = std::min(least, root_of_squares(plan, pilots, l, b, t, most));
    });
    chosen_samples = choose_within(plan, pilots, scene_samples, kNearTheLeast * least);
    if (chosen_samples == 0) throw InputError("plan: no error could be measured: values of the scene are too large");
  }
  const int first = plan.measured ? kPilotSamples[0] : chosen_samples,
            last = plan.measured ? std::min(4 * chosen_samples, kMostSamples) : first;
  for (int samples = first; samples <= last; samples *= 2) {
    if (samples == chosen_samples) plan.sample = plan.samples.size();
    plan.samples.push_back({samples, sample_error(plan, pilots, plan.bounce, samples)});
  }
}

}  // namespace

double Plan::error_dp_px(std::size_t l, std::size_t b, std::size_t t, std::size_t s) const {
  return std::sqrt(square(lenses[l].error_dp_px) + square(bounces[b].error_dp_px) + square(lights[t].error_dp_px) +
                   square(samples[s].error_dp_px));
}

double Plan::picture_s(std::size_t l, std::size_t b, std::size_t t, std::size_t s) const {
  return photosites * photosite_s(*this, l, b, t, samples[s].samples);
}

Plan plan(const Simulation& simulation, const Scene& scene, double tolerance_dp_px, std::uint64_t seed,
          const ProgressCallback& progress) {
  check_sensor(simulation);
  RenderScene world(scene, simulation.light);
  Plan plan;
  plan.tolerance_dp_px = tolerance_dp_px;
  plan.seed = seed;
  plan.photosites = static_cast<double>(simulation.sensor.width_px) * simulation.sensor.height_px;
  for (LensCandidate& candidate : lens_candidates(simulation.lens)) {
    plan.lenses.push_back({.candidate = std::move(candidate)});
  }
  measure_lens_errors(simulation, world, hash(seed, 0), plan.lenses);

  const auto* last = std::get_if<PrescriptionModel>(&plan.lenses.back().candidate.lens.model);
  plan.pilot_lens = plan.lenses.size() - (last && last->exact_trace ? 2 : 1);  // an exact trace would take too long
  const PilotRenders pilots(simulation, world, plan.lenses[plan.pilot_lens].candidate.lens, seed);
  const PilotErrors errors = measure_pilots(pilots, simulation, tolerance_dp_px, progress);
  plan.windows = errors.windows;
  plan.windows_textured = errors.windows_textured;
  plan.measured = !errors.bounces.empty();
  if (plan.measured) {
    plan.bounces = errors.bounces;
    plan.lights = errors.lights;
  } else {
    const double spacing_px = simulation.light.light_spacing_px;
    const int bounces = simulation.render.max_bounces;
    const PilotRender pilot =
        pilots.render({.bounces = bounces, .samples = 16, .light_spacing_px = spacing_px, .timed = true});
    plan.bounces = {
        {.bounces = bounces, .seconds_per_sample = pilot.seconds_per_sample, .light_seconds = pilot.light_seconds}};
    plan.lights = {{.spacing_px = spacing_px}};
    if (progress) progress(1);
  }
  choose(plan, errors, simulation.render.samples_per_pixel);
  return plan;
}

Simulation planned(Simulation simulation, const Plan& plan) {
  simulation.lens = plan.lenses[plan.lens].candidate.lens;
  if (!plan.measured) return simulation;
  simulation.render.max_bounces = plan.bounces[plan.bounce].bounces;
  simulation.light.light_spacing_px = plan.lights[plan.light].spacing_px;
  simulation.render.samples_per_pixel = plan.samples[plan.sample].samples;
  simulation.noise_fraction.reset();
  simulation.render_error.reset();
  simulation.time_budget_s.reset();
  return simulation;
}

}  // namespace dualpixel::simulator
