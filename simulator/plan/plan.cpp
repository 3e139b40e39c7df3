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
  if (sensor.width_px >= kLeastPlanWidth && sensor.height_px >= kLeastPlanHeight) return;
  throw InputError(fmt::format("{}: /sensor: {} x {} photosites: a plan needs at least {} x {}, one matcher's window",
                               printable(simulation.path), sensor.width_px, sensor.height_px, kLeastPlanWidth,
                               kLeastPlanHeight));
}

/// Error of `samples` samples at bounce step b.
double sample_error(const Plan& plan, const PilotErrors& pilots, std::size_t b, int samples) {
  return plan.measured ? plan.bounces[b].noise * pilots.sample_error(samples) : 0.0;
}

double root_of_squares(const Plan& plan, const PilotErrors& pilots, std::size_t l, std::size_t b, int samples) {
  return std::sqrt(square(plan.lenses[l].error_dp_px) + square(plan.bounces[b].error_dp_px) +
                   square(sample_error(plan, pilots, b, samples)));
}

/// The least work whose error stays within the tolerance; the reference with the most samples where none does.
void choose(Plan& plan, const PilotErrors& pilots, int scene_samples) {
  const auto within = [&](std::size_t l, std::size_t b, int samples) {
    return root_of_squares(plan, pilots, l, b, samples) <= plan.tolerance_dp_px;
  };
  plan.met = false;
  plan.lens = plan.lenses.size() - 1;
  plan.bounce = plan.bounces.size() - 1;
  int chosen_samples = plan.measured ? kMostSamples : scene_samples;
  double least_work = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
      int samples = plan.measured ? kPilotSamples[0] : scene_samples;
      while (plan.measured && samples < kMostSamples && !within(l, b, samples)) samples *= 2;
      const double work = samples * (plan.lenses[l].candidate.work + plan.bounces[b].bounces);
      if (!within(l, b, samples) || work >= least_work) continue;
      least_work = work;
      plan.met = true;
      plan.lens = l, plan.bounce = b, chosen_samples = samples;
    }
  }
  const int first = plan.measured ? kPilotSamples[0] : chosen_samples,
            last = plan.measured ? std::min(4 * chosen_samples, kMostSamples) : first;
  for (int samples = first; samples <= last; samples *= 2) {
    if (samples == chosen_samples) plan.sample = plan.samples.size();
    plan.samples.push_back({samples, sample_error(plan, pilots, plan.bounce, samples)});
  }
}

}  // namespace

double Plan::error_dp_px(std::size_t l, std::size_t b, std::size_t s) const {
  return std::sqrt(square(lenses[l].error_dp_px) + square(bounces[b].error_dp_px) + square(samples[s].error_dp_px));
}

double Plan::picture_s(std::size_t l, std::size_t b, std::size_t s) const {
  return photosites * samples[s].samples *
         (bounces[b].seconds_per_sample + lenses[l].seconds_per_sample - lenses[pilot_lens].seconds_per_sample);
}

Plan plan(const Simulation& simulation, const Scene& scene, double tolerance_dp_px, std::uint64_t seed,
          const ProgressCallback& progress) {
  check_sensor(simulation);
  const RenderScene world(scene);
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
  } else {
    const int bounces = simulation.render.max_bounces;
    plan.bounces = {{.bounces = bounces, .seconds_per_sample = pilots.render(bounces, 16, 0).seconds_per_sample}};
    if (progress) progress(1);
  }
  choose(plan, errors, simulation.render.samples_per_pixel);
  return plan;
}

Simulation planned(Simulation simulation, const Plan& plan) {
  simulation.lens = plan.lenses[plan.lens].candidate.lens;
  if (!plan.measured) return simulation;
  simulation.render.max_bounces = plan.bounces[plan.bounce].bounces;
  simulation.render.samples_per_pixel = plan.samples[plan.sample].samples;
  simulation.noise_fraction.reset();
  simulation.render_error.reset();
  simulation.time_budget_s.reset();
  return simulation;
}

}  // namespace dualpixel::simulator
