#include "simulator/plan/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
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

/// Error of all but samples, squared.
double squared_bias(const Plan& plan, const PlanChoice& c) {
  double sum = square(plan.lenses[c.lens].error_dp_px) + square(plan.bounces[c.bounce].error_dp_px) +
               square(plan.lights[c.light].error_dp_px);
  const double light_noise = plan.lights[c.light].noise * plan.light_samples[c.light_samples].error_dp_px;
  sum += square(plan.bounces[c.bounce].noise * light_noise);
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (!c.effects[i]) sum += square(plan.effects[i].error_dp_px);
  }
  return sum;
}

/// Time of one photosite. What is more accurate is not taken to be cheaper, whatever the clock says; so reflections are
/// charged with points of light on small triangles, which they do without.
double photosite_s(const Plan& plan, const PlanChoice& c, int samples) {
  double bounce_s = 0, light_s = 0, lens_s = 0;
  for (std::size_t i = 0; i <= c.bounce; ++i) {
    bounce_s = std::max(bounce_s, plan.bounces[i].seconds_per_sample);
    light_s = std::max(light_s, plan.bounces[i].light_seconds);
  }
  for (std::size_t i = 0; i <= c.lens; ++i) lens_s = std::max(lens_s, plan.lenses[i].seconds_per_sample);
  double making = 0;
  for (std::size_t i = 0; i <= c.light; ++i) making = std::max(making, plan.lights[i].making);
  making *= plan.light_samples[c.light_samples].making;
  double effects_s = 0;
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (c.effects[i]) effects_s += plan.effects[i].seconds_per_sample;
  }
  const double sample_s = bounce_s + lens_s - plan.lenses[plan.pilot_lens].seconds_per_sample;
  return making * light_s + samples * (effects_s + std::max(sample_s, lens_s));
}

/// Steps of a factor of sqrt(2): times scatter.
double work_steps(double seconds) { return std::round(2 * std::log2(std::max(seconds, 1e-15))); }

/// All sets of effects, that of the scene file first; it alone where nothing was measured.
std::vector<std::vector<bool>> sets_of_effects(const Plan& plan, const std::vector<bool>& of_file) {
  std::vector<std::vector<bool>> sets;
  const std::size_t count = plan.measured ? std::size_t{1} << of_file.size() : 1;
  for (std::size_t toggled = 0; toggled < count; ++toggled) {
    sets.push_back(of_file);
    for (std::size_t i = 0; i < of_file.size(); ++i) sets.back()[i] = of_file[i] != ((toggled >> i & 1) != 0);
  }
  return sets;
}

/// Whether all effects that a choice has change something behind its lens.
bool makes_sense(const Plan& plan, const PlanChoice& c) {
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (c.effects[i] && !knows(plan.lenses[c.lens].candidate.lens, plan.effects[i].effect)) return false;
  }
  return true;
}

/// All choices that make sense, but for samples; the cheaper ones first.
std::vector<PlanChoice> choices_of(const Plan& plan, const std::vector<bool>& effects_of_file) {
  std::vector<PlanChoice> choices;
  const std::vector<std::vector<bool>> effects = sets_of_effects(plan, effects_of_file);
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
      for (std::size_t t = 0; t < plan.lights.size(); ++t) {
        for (std::size_t n = 0; n < plan.light_samples.size(); ++n) {
          for (const std::vector<bool>& set : effects) {
            const PlanChoice choice{l, b, t, n, set};
            if (!plan.measured || makes_sense(plan, choice)) choices.push_back(choice);
          }
        }
      }
    }
  }
  return choices;
}

/// A power of two.
int least_samples(const Plan& plan, const PlanChoice& c) {
  unsigned least = kPilotSamples[0];
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (c.effects[i]) least = std::max(least, std::bit_ceil(static_cast<unsigned>(plan.effects[i].least_samples)));
  }
  return static_cast<int>(least);
}

/// Chooses the least work whose error is at most `error_dp_px`, and returns its samples; 0: there is none.
int choose_within(Plan& plan, const PilotErrors& pilots, const std::vector<PlanChoice>& choices, int scene_samples,
                  double error_dp_px) {
  double least_work = std::numeric_limits<double>::infinity();
  int chosen_samples = 0;
  for (const PlanChoice& c : choices) {
    const double bias2 = squared_bias(plan, c);
    const auto within = [&](int samples) {
      return std::sqrt(bias2 + square(sample_error(plan, pilots, c.bounce, samples))) <= error_dp_px;
    };
    int samples = plan.measured ? least_samples(plan, c) : scene_samples;
    while (plan.measured && samples < kMostSamples && !within(samples)) samples *= 2;
    const double work = work_steps(photosite_s(plan, c, samples));
    if (!within(samples) || work >= least_work) continue;
    least_work = work;
    plan.chosen = c, chosen_samples = samples;
  }
  return chosen_samples;
}

/// The least work whose error stays within the tolerance. Where none does, within a tenth of the least error that there
/// is: the last tenth may take a hundred times as long.
void choose(Plan& plan, const PilotErrors& pilots, const std::vector<bool>& effects_of_file, int scene_samples) {
  constexpr double kNearTheLeast = 1.1;
  const std::vector<PlanChoice> choices = choices_of(plan, effects_of_file);
  int chosen_samples = choose_within(plan, pilots, choices, scene_samples, plan.tolerance_dp_px);
  plan.met = chosen_samples > 0;
  if (!plan.met) {
    const int most = plan.measured ? kMostSamples : scene_samples;
    double least = std::numeric_limits<double>::infinity();
    for (const PlanChoice& c : choices) {
      least = std::min(least, std::sqrt(squared_bias(plan, c) + square(sample_error(plan, pilots, c.bounce, most))));
    }
    chosen_samples = choose_within(plan, pilots, choices, scene_samples, kNearTheLeast * least);
    if (chosen_samples == 0) throw InputError("plan: no error could be measured: values of the scene are too large");
  }
  const int first = plan.measured ? kPilotSamples[0] : chosen_samples,
            last = plan.measured ? std::min(4 * chosen_samples, kMostSamples) : first;
  for (int samples = first; samples <= last; samples *= 2) {
    if (samples == chosen_samples) plan.chosen.sample = plan.samples.size();
    plan.samples.push_back({samples, sample_error(plan, pilots, plan.chosen.bounce, samples)});
  }
}

}  // namespace

double Plan::error_dp_px(const PlanChoice& c) const {
  return std::sqrt(squared_bias(*this, c) + square(samples[c.sample].error_dp_px));
}

double Plan::picture_s(const PlanChoice& c) const {
  return photosites * photosite_s(*this, c, samples[c.sample].samples);
}

Plan plan(const Simulation& simulation, const Scene& scene, double tolerance_dp_px, std::uint64_t seed,
          const ProgressCallback& progress) {
  check_sensor(simulation);
  const Simulation bare = without_effects(simulation);
  RenderScene world(scene, simulation.light);
  Plan plan;
  plan.tolerance_dp_px = tolerance_dp_px;
  plan.seed = seed;
  plan.photosites = static_cast<double>(simulation.sensor.width_px) * simulation.sensor.height_px;
  plan.frames = moves(simulation) ? simulation.burst_frames : 1;
  for (LensCandidate& candidate : lens_candidates(bare.lens)) {
    plan.lenses.push_back({.candidate = std::move(candidate)});
  }
  measure_lens_errors(bare, world, hash(seed, 0), plan.lenses);

  const auto* last = std::get_if<PrescriptionModel>(&plan.lenses.back().candidate.lens.model);
  plan.pilot_lens = plan.lenses.size() - (last && last->exact_trace ? 2 : 1);  // an exact trace would take too long
  Simulation pilot_simulation = bare;
  pilot_simulation.lens = plan.lenses[plan.pilot_lens].candidate.lens;
  PilotRenders pilots(pilot_simulation, world, seed);
  const PilotErrors errors = measure_pilots(pilots, simulation, tolerance_dp_px, progress);
  plan.windows = errors.windows;
  plan.windows_textured = errors.windows_textured;
  plan.measured = !errors.bounces.empty();
  if (plan.measured) {
    plan.bounces = errors.bounces;
    plan.lights = errors.lights;
    plan.light_samples = errors.light_samples;
    plan.effects = errors.effects;
  } else {
    const double spacing_px = simulation.light.light_spacing_px;
    const int bounces = simulation.render.max_bounces;
    const PilotRender pilot = pilots.render(
        {.bounces = bounces, .samples = 16, .light_spacing_px = spacing_px, .timed = true, .new_light = true});
    plan.bounces = {
        {.bounces = bounces, .seconds_per_sample = pilot.seconds_per_sample, .light_seconds = pilot.light_seconds}};
    plan.lights = {{.spacing_px = spacing_px}};
    plan.light_samples = {{simulation.light.light_samples}};
    for (const Effect effect : effects_of(simulation)) plan.effects.push_back({effect});
  }
  if (progress) progress(1);
  std::vector<bool> effects_of_file;
  for (const EffectStep& step : plan.effects) effects_of_file.push_back(has(simulation, step.effect));
  choose(plan, errors, effects_of_file, simulation.render.samples_per_pixel);
  return plan;
}

Simulation planned(const Simulation& file, const Plan& plan) {
  const PlanChoice& chosen = plan.chosen;
  Simulation simulation = without_effects(file);
  simulation.lens = plan.lenses[chosen.lens].candidate.lens;
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (chosen.effects[i]) add(plan.effects[i].effect, file, simulation);
  }
  if (!plan.measured) return simulation;
  simulation.render.max_bounces = plan.bounces[chosen.bounce].bounces;
  simulation.light.light_spacing_px = plan.lights[chosen.light].spacing_px;
  simulation.light.light_samples = plan.light_samples[chosen.light_samples].samples;
  simulation.render.samples_per_pixel = plan.samples[chosen.sample].samples;
  simulation.noise_fraction.reset();
  simulation.render_error.reset();
  simulation.time_budget_s.reset();
  return simulation;
}

}  // namespace dualpixel::simulator
